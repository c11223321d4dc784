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
    let scale = -0.5 / (deviation * deviation);
    into.extend((first..=last).map(|texel| {
        let offset = texel as f64 + 0.5 - center;
        (offset * offset * scale).exp()
    }));
    let sum: f64 = into.iter().sum();
    // A point much narrower than a texel whose centre it misses is all in that texel.
    if sum > 0.0 {
        into.iter_mut().for_each(|weight| *weight /= sum);
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

/// Runs `draw(photon, rows, band)` for every photon and every band of a map of `side` rows of `V` that it reaches: `rows`
/// are the band's. Returns the map.
pub fn in_bands<V: Clone + Default + Send + Sync>(
    side: usize,
    photons: &[Photon],
    half_height: impl Fn(&Photon) -> f64 + Sync,
    draw: impl Fn(&Photon, std::ops::Range<i64>, &mut [V], &mut Work) + Sync,
) -> (Vec<V>, Work) {
    let bands = side.div_ceil(BAND);
    let mut lists: Vec<Vec<u32>> = vec![Vec::new(); bands];
    for (index, photon) in photons.iter().enumerate() {
        let (first, last) = reach(photon.at.y, 2.0 * half_height(photon));
        let last = last.min(side as i64 - 1);
        if last >= 0 && first < side as i64 {
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
            let mut work = Work::default();
            let first = (band * BAND) as i64;
            let rows = first..first + (texels.len() / side) as i64;
            for &index in list {
                draw(&photons[index as usize], rows.clone(), texels, &mut work);
            }
            work
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
        |photon, rows, texels, work| match photon.spread {
            Spread::Round(diameter) => draw_round(photon, diameter, side, rows, texels, work),
            Spread::Ellipse(covariance) => {
                draw_ellipse(photon, &covariance, side, rows, texels, work);
            }
        },
    );
    work.splats = photons.len() as u64;
    work.bytes = (map.len() * 12) as u64;
    (map, work)
}

fn draw_round(
    photon: &Photon,
    diameter: f64,
    side: usize,
    rows: std::ops::Range<i64>,
    texels: &mut [Rgb],
    work: &mut Work,
) {
    round_weights(photon.at, diameter, |first, across, down| {
        for (weight_y, row) in down.iter().zip(first[1]..) {
            if !rows.contains(&row) {
                continue;
            }
            let line = &mut texels[(row - rows.start) as usize * side..][..side];
            for (weight_x, column) in across.iter().zip(first[0]..) {
                if let Some(texel) = usize::try_from(column).ok().and_then(|c| line.get_mut(c)) {
                    *texel += photon.flux * (weight_x * weight_y);
                    work.fragments += 1;
                }
            }
        }
    });
}

/// The texels of a round point: its first column and row, weights of its columns and of its rows.
pub fn round_weights(at: DVec2, diameter: f64, tell: impl FnOnce([i64; 2], &[f64], &[f64])) {
    let deviation = diameter / DEVIATIONS;
    let (columns, rows) = (reach(at.x, diameter), reach(at.y, diameter));
    let (mut across, mut down) = (Vec::new(), Vec::new());
    weights(at.x, columns, deviation, &mut across);
    weights(at.y, rows, deviation, &mut down);
    tell([columns.0, rows.0], &across, &down);
}

fn draw_ellipse(
    photon: &Photon,
    covariance: &DMat2,
    side: usize,
    rows: std::ops::Range<i64>,
    texels: &mut [Rgb],
    work: &mut Work,
) {
    let half = half_width(&photon.spread);
    let precision = covariance.inverse();
    let (left, right) = reach(photon.at.x, 2.0 * half.x);
    let (top, bottom) = reach(photon.at.y, 2.0 * half.y);
    let weight = |column: i64, row: i64| {
        let offset = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - photon.at;
        (-0.5 * offset.dot(precision * offset)).exp()
    };
    let mut sum = 0.0;
    for row in top..=bottom {
        for column in left..=right {
            sum += weight(column, row);
        }
    }
    if sum <= 0.0 || !sum.is_finite() {
        return;
    }
    for row in top.max(rows.start)..=bottom.min(rows.end - 1) {
        let line = &mut texels[(row - rows.start) as usize * side..][..side];
        for column in left.max(0)..=right.min(side as i64 - 1) {
            line[column as usize] += photon.flux * (weight(column, row) / sum);
            work.fragments += 1;
        }
    }
}
