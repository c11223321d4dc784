//! Stage `splat`, by kernels: photons drawn into a map as points of some width.

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use super::variants::Kernel;
use super::work::Work;
use crate::approximation::bands::{Band, DEVIATIONS, in_bands, reach};
use crate::numeric::math;
use crate::radiometry::Rgb;

/// A photon, ready to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// In texels of the map.
    pub at: DVec2,
    /// What it carries \[W\].
    pub flux: Rgb,
    /// How wide it is drawn.
    pub spread: Spread,
}

/// The form of a splat.
#[derive(Clone, Copy, Debug)]
pub enum Spread {
    /// A round Gaussian in a square point of this diameter, in texels.
    Round(f64),
    /// An elliptical Gaussian with this covariance, in texels².
    Ellipse(DMat2),
}

/// The half-width along the two axes within which a splat has its texels.
fn half_width(spread: &Spread) -> DVec2 {
    match spread {
        Spread::Round(diameter) => DVec2::splat(0.5 * diameter),
        Spread::Ellipse(covariance) => {
            let deviations = DVec2::new(covariance.x_axis.x, covariance.y_axis.y);
            deviations.map(f64::sqrt) * (0.5 * DEVIATIONS)
        }
    }
}

/// The weight of a texel whose centre is `distance` from a photon's, by the filter of Wyman's demo of 2008
/// (`simplePhotonSplat`): Pavicic's (*Convenient anti-aliasing filters that minimize "bumpy" sampling*,
/// Graphics Gems, 1990) within the circle of diameter D,
///
/// ```text
/// w = α (1 − (1 − e^(−2β r²/D²)) / (1 − e^−β)) / (0.42 D²),   α = 0.918, β = 1.953
/// ```
///
/// At the rim it is 27 % of what it is in the middle. The sum of weights is near 1 for wide splats; those of
/// a few texels lose or gain, by how the photon lies.
fn filter(distance_squared: f64, diameter: f64) -> f64 {
    const ALPHA: f64 = 0.918;
    const BETA: f64 = 1.953;
    let (place, size) = (
        distance_squared / math::powi(diameter, 2),
        math::powi(diameter, 2),
    );
    if place >= 0.25 {
        return 0.0;
    }
    let fall = (1.0 - math::exp(-2.0 * BETA * place)) / (1.0 - math::exp(-BETA));
    ALPHA * (1.0 - fall) / (0.42 * size)
}

/// The weights above 0 of a photon's texels, by the filter of 2008, on a map without border: `add(weight,
/// [column, row])`.
pub fn filtered(at: DVec2, diameter: f64, mut add: impl FnMut(f64, [i64; 2])) {
    let (columns, rows) = (reach(at.x, diameter), reach(at.y, diameter));
    for row in rows.0..=rows.1 {
        for column in columns.0..=columns.1 {
            let center = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
            let weight = filter(center.distance_squared(at), diameter);
            if weight > 0.0 {
                add(weight, [column, row]);
            }
        }
    }
}

/// What the filter of 2008 adds to the flux \[W\] of photons, on a map without border: the sum of its weights
/// is not 1.
pub fn added(photons: &[Photon]) -> Rgb {
    let one = |photon: &Photon| {
        let Spread::Round(diameter) = photon.spread else {
            return Rgb::BLACK;
        };
        let mut sum = 0.0;
        filtered(photon.at, diameter, |weight, _| sum += weight);
        photon.flux * (sum - 1.0)
    };
    // Chunk by chunk, so that the sum is the same bits on any threads.
    let chunks: Vec<Rgb> = photons
        .par_chunks(4096)
        .map(|chunk| chunk.iter().map(one).sum())
        .collect();
    chunks.into_iter().sum()
}

/// Draws photons with their own spread: flux \[W\] by texel.
///
/// A Gaussian's weights are those at the centres of its texels, divided by their sum: no flux is lost but
/// beyond the map's border.
pub fn draw(side: usize, photons: &[Photon], kernel: Kernel) -> (Vec<Rgb>, Work) {
    let (map, fragments) = in_bands(
        [side; 2],
        photons,
        |photon| reach(photon.at.y, 2.0 * half_width(&photon.spread).y),
        |photon: &Photon, band: &mut Band<Rgb>| match (photon.spread, kernel) {
            (Spread::Round(diameter), Kernel::Gaussian) => {
                band.draw_round(photon.at, diameter, |texel: &mut Rgb, weight, _| {
                    *texel += photon.flux * weight;
                });
            }
            (Spread::Round(diameter), Kernel::Wyman2008) => {
                filtered(photon.at, diameter, |weight, [column, row]| {
                    if let Some(texel) = band.texel(column, row) {
                        *texel += photon.flux * weight;
                        band.fragments += 1;
                    }
                });
            }
            (Spread::Ellipse(covariance), _) => draw_ellipse(photon, &covariance, band),
        },
    );
    let work = Work {
        splats: photons.len() as u64,
        fragments,
        bytes: (map.len() * 12) as u64,
        ..Work::default()
    };
    (map, work)
}

/// The texels whose centres are in an ellipse of three deviations, row by row.
struct Ellipse {
    at: DVec2,
    /// Inverse of the covariance [1/texel²]: ((p, q), (q, r)).
    precision: [f64; 3],
    /// First and last row that may have any.
    rows: (i64, i64),
}

impl Ellipse {
    fn new(at: DVec2, covariance: &DMat2) -> Self {
        let inverse = covariance.inverse();
        Self {
            at,
            precision: [inverse.x_axis.x, inverse.x_axis.y, inverse.y_axis.y],
            rows: reach(at.y, DEVIATIONS * covariance.y_axis.y.sqrt()),
        }
    }

    /// First and last column in a row, where p x² + 2 q x y + r y² ≤ 3²; none where the last is before the
    /// first.
    fn columns(&self, row: i64) -> (i64, i64) {
        const EDGE: f64 = 0.25 * DEVIATIONS * DEVIATIONS;
        let [p, q, r] = self.precision;
        let y = row as f64 + 0.5 - self.at.y;
        let half = (p * EDGE - (p * r - q * q) * y * y).max(0.0).sqrt() / p;
        let middle = self.at.x - 0.5 - q * y / p;
        (
            (middle - half).ceil() as i64,
            (middle + half).floor() as i64,
        )
    }

    /// Adds the Gaussian's values at the centres of a row's texels `first` to `last` to a list, from left to
    /// right.
    ///
    /// The exponent is a square in the column: from texel to texel values change by a factor that itself
    /// changes by e^−p. Within the ellipse none is less than e^−4.5, so that thousands of products keep
    /// twelve digits.
    fn values(&self, row: i64, (first, last): (i64, i64), into: &mut Vec<f64>) {
        let [p, q, r] = self.precision;
        let y = row as f64 + 0.5 - self.at.y;
        let x = first as f64 + 0.5 - self.at.x;
        let mut value = math::exp(-0.5 * (p * x * x + 2.0 * q * x * y + r * y * y));
        let mut factor = math::exp(-(p * (x + 0.5) + q * y));
        let change = math::exp(-p);
        for _ in first..=last {
            into.push(value);
            value *= factor;
            factor *= change;
        }
    }
}

fn draw_ellipse(photon: &Photon, covariance: &DMat2, band: &mut Band<Rgb>) {
    let ellipse = Ellipse::new(photon.at, covariance);
    let mut values = std::mem::take(&mut band.across);
    values.clear();
    let rows = ellipse.rows.0..=ellipse.rows.1;
    for row in rows.clone() {
        ellipse.values(row, ellipse.columns(row), &mut values);
    }
    let sum: f64 = values.iter().sum();
    // An ellipse has the centre of its own texel: it is at least a third of a texel wide, one way and the
    // other.
    if sum > 0.0 && sum.is_finite() {
        let mut next = values.iter();
        for row in rows {
            let (first, last) = ellipse.columns(row);
            for (column, value) in (first..=last).zip(next.by_ref()) {
                if let Some(texel) = band.texel(column, row) {
                    *texel += photon.flux * (value / sum);
                    band.fragments += 1;
                }
            }
        }
    }
    band.across = values;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Standard deviation along an axis of one photon's texels, in texels.
    fn deviation(kernel: Kernel, diameter: f64) -> f64 {
        const SIDE: usize = 256;
        let photon = Photon {
            at: DVec2::splat(128.3),
            flux: Rgb::WHITE,
            spread: Spread::Round(diameter),
        };
        let (map, _) = draw(SIDE, &[photon], kernel);
        let squares = map.iter().enumerate().map(|(index, texel)| {
            let offset = (index % SIDE) as f64 + 0.5 - 128.3;
            texel.mean() * offset * offset
        });
        let sum: f64 = map.iter().map(|texel| texel.mean()).sum();
        (squares.sum::<f64>() / sum).sqrt()
    }

    #[test]
    fn the_filter_of_2008_is_wider_than_a_gaussian_of_the_same_diameter() {
        let diameter = 101.0;
        // A Gaussian of D/6, cut at three deviations: its variance is less by 6 φ(3) / (2 Φ(3) − 1).
        let gaussian: f64 = diameter / 6.0 * (1.0 - 6.0 * 0.004_432 / 0.997_300_f64).sqrt();
        let found = deviation(Kernel::Gaussian, diameter);
        // Sums over a hundred texels for integrals.
        assert!((found / gaussian - 1.0).abs() < 1e-3, "{found} {gaussian}");
        // ⟨r²⟩/2 of the filter over its circle, by the midpoint rule.
        let parts = 100_000;
        let (mut weight, mut squares) = (0.0, 0.0);
        for part in 0..parts {
            let r = (f64::from(part) + 0.5) / f64::from(parts) * 0.5;
            let value = (0.918 * (1.0 - (1.0 - math::exp(-3.906 * r * r)) / 0.858_152_111)) * r;
            weight += value;
            squares += value * r * r;
        }
        let filter = diameter * (0.5 * squares / weight).sqrt();
        let found = deviation(Kernel::Wyman2008, diameter);
        assert!((found / filter - 1.0).abs() < 1e-3, "{found} {filter}");
        assert!(
            (filter / gaussian - 1.35).abs() < 0.02,
            "{}",
            filter / gaussian
        );
    }
}
