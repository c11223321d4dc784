//! Stage `splat`, by kernels: photons drawn into a map as points of some width.

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use crate::approximation::Work;
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

/// A point's diameter in standard deviations of its Gaussian.
///
/// The 7-tap filter of binomial weights, which a 7x7 Gaussian is on a device, has the variance 6/4: its diameter
/// is 5.7 deviations.
pub const DEVIATIONS: f64 = 6.0;

/// Rows of a map that are drawn as one task: photons of a band are drawn in their order, so that sums are the same
/// bits on any number of threads.
const BAND: usize = 16;

/// A number of texels, among places that may lie outside of a map.
pub fn signed(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

/// Where along one axis a point of `diameter` about `center` has its texels' centres: first and last texel, at
/// least the one that holds its own centre.
#[inline]
pub fn reach(center: f64, diameter: f64) -> (i64, i64) {
    let home = center.floor() as i64;
    let first = (center - 0.5 * diameter - 0.5).ceil() as i64;
    let last = (center + 0.5 * diameter - 0.5).floor() as i64;
    (first.min(home), last.max(home))
}

/// Weights of a Gaussian along one axis, at the centres of texels `first` to `last`; their sum is 1.
fn weights(center: f64, (first, last): (i64, i64), deviation: f64, into: &mut Vec<f64>) {
    into.clear();
    // Where a beam is focused most points are of one texel.
    if first == last {
        into.push(1.0);
        return;
    }
    let scale = -0.5 / (deviation * deviation);
    into.extend((first..=last).map(|texel| {
        let offset = texel as f64 + 0.5 - center;
        (offset * offset * scale).exp()
    }));
    let sum: f64 = into.iter().sum();
    // A point much narrower than a texel whose centre it misses is all in that texel.
    if sum > 0.0 {
        for weight in into.iter_mut() {
            *weight /= sum;
        }
    } else {
        let share = 1.0 / into.len() as f64;
        into.fill(share);
    }
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

/// Some rows of a map that one task draws.
pub struct Band<'a, V> {
    side: usize,
    /// The first row.
    first: i64,
    texels: &'a mut [V],
    /// Texels drawn so far, counted again for each splat.
    pub fragments: u64,
    /// The weights of a point's columns and rows, or of all texels of an ellipse; kept to save making them.
    across: Vec<f64>,
    down: Vec<f64>,
}

impl<V> Band<'_, V> {
    /// The texel in a column and a row of the map; `None` outside of the band.
    #[inline]
    pub fn texel(&mut self, column: i64, row: i64) -> Option<&mut V> {
        let row = usize::try_from(row - self.first).ok()?;
        let column = usize::try_from(column)
            .ok()
            .filter(|&column| column < self.side)?;
        self.texels.get_mut(row * self.side + column)
    }

    /// Adds to each texel of the band that a round point holds: `add(texel, weight, [column, row])`.
    #[inline]
    pub fn draw_round(
        &mut self,
        at: DVec2,
        diameter: f64,
        mut add: impl FnMut(&mut V, f64, [i64; 2]),
    ) {
        let deviation = diameter / DEVIATIONS;
        let (columns, rows) = (reach(at.x, diameter), reach(at.y, diameter));
        weights(at.x, columns, deviation, &mut self.across);
        weights(at.y, rows, deviation, &mut self.down);
        let last_row = self.first + signed(self.texels.len() / self.side) - 1;
        let (left, right) = (columns.0.max(0), columns.1.min(signed(self.side) - 1));
        for row in rows.0.max(self.first)..=rows.1.min(last_row) {
            let down = self.down[(row - rows.0) as usize];
            let line = &mut self.texels[(row - self.first) as usize * self.side..][..self.side];
            for column in left..=right {
                let weight = self.across[(column - columns.0) as usize] * down;
                add(&mut line[column as usize], weight, [column, row]);
                self.fragments += 1;
            }
        }
    }
}

/// Runs `draw(photon, band)` for every photon and every band of a map of `side` rows of `V` that it reaches. Returns the map.
pub fn in_bands<V: Clone + Default + Send + Sync>(
    side: usize,
    photons: &[Photon],
    half_height: impl Fn(&Photon) -> f64 + Sync,
    draw: impl Fn(&Photon, &mut Band<V>) + Sync,
) -> (Vec<V>, Work) {
    let bands = side.div_ceil(BAND);
    let mut lists: Vec<Vec<u32>> = vec![Vec::new(); bands];
    for (index, photon) in photons.iter().enumerate() {
        let (first, last) = reach(photon.at.y, 2.0 * half_height(photon));
        let last = last.min(signed(side) - 1);
        if last >= 0 && first < signed(side) {
            let bands = first.max(0) as usize / BAND..=last as usize / BAND;
            lists[bands]
                .iter_mut()
                .for_each(|list| list.push(index as u32));
        }
    }
    let mut map = vec![V::default(); side * side];
    let work = map
        .par_chunks_mut(BAND * side)
        .zip(&lists)
        .enumerate()
        .map(|(band, (texels, list))| {
            let mut band = Band {
                side,
                first: signed(band * BAND),
                texels,
                fragments: 0,
                across: Vec::new(),
                down: Vec::new(),
            };
            for &index in list {
                draw(&photons[index as usize], &mut band);
            }
            Work {
                fragments: band.fragments,
                ..Work::default()
            }
        })
        .reduce(Work::default, |a, b| a + b);
    (map, work)
}

/// Draws photons with their own spread: flux \[W\] by texel.
///
/// Each splat's weights are those of its Gaussian at the centres of its texels, divided by their sum: no flux is lost but
/// beyond the map's border.
pub fn draw(side: usize, photons: &[Photon]) -> (Vec<Rgb>, Work) {
    let (map, mut work) = in_bands(
        side,
        photons,
        |photon| half_width(&photon.spread).y,
        |photon, band| match photon.spread {
            Spread::Round(diameter) => {
                band.draw_round(photon.at, diameter, |texel: &mut Rgb, weight, _| {
                    *texel += photon.flux * weight;
                });
            }
            Spread::Ellipse(covariance) => draw_ellipse(photon, &covariance, band),
        },
    );
    work.splats = photons.len() as u64;
    work.bytes = (map.len() * 12) as u64;
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

    /// First and last column in a row, where p x² + 2 q x y + r y² ≤ 3²; none where the last is before the first.
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

    /// Adds the Gaussian's values at the centres of a row's texels `first` to `last` to a list, from left to right.
    ///
    /// The exponent is a square in the column: from texel to texel values change by a factor that itself changes by e^−p. Within
    /// the ellipse none is less than e^−4.5, so that thousands of products keep twelve digits.
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
    // An ellipse has the centre of its own texel: it is at least a third of a texel wide, one way and the other.
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
