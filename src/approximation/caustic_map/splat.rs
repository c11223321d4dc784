//! Stage `splat`, by kernels: photons drawn into a map as points of some width.

use glam::{DMat2, DVec2};

use super::work::Work;
use crate::approximation::bands::{Band, DEVIATIONS, in_bands, reach};
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

/// Draws photons with their own spread: flux \[W\] by texel.
///
/// Each splat's weights are those of its Gaussian at the centres of its texels, divided by their sum: no flux
/// is lost but beyond the map's border.
pub fn draw(side: usize, photons: &[Photon]) -> (Vec<Rgb>, Work) {
    let (map, fragments) = in_bands(
        [side; 2],
        photons,
        |photon| reach(photon.at.y, 2.0 * half_width(&photon.spread).y),
        |photon: &Photon, band| match photon.spread {
            Spread::Round(diameter) => {
                band.draw_round(photon.at, diameter, |texel: &mut Rgb, weight, _| {
                    *texel += photon.flux * weight;
                });
            }
            Spread::Ellipse(covariance) => draw_ellipse(photon, &covariance, band),
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
        let mut value = (-0.5 * (p * x * x + 2.0 * q * x * y + r * y * y)).exp();
        let mut factor = (-(p * (x + 0.5) + q * y)).exp();
        let change = (-p).exp();
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
