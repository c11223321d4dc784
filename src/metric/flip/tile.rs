//! LDR-FLIP of one square of texels.
//!
//! All that a texel depends on lies within a few texels of it. So memory stays small, and the squares can be
//! done in any order.

use super::colour::{Colour, from_opponent, hyab, to_hunt_lab, to_opponent};
use super::display::{Display, shown};
use super::filters::{Filters, along, strided};
use super::images::Images;
use crate::numeric::math;

/// Texels a side: small enough for a cache, large beside the kernels' reach.
pub(super) const TILE: usize = 128;

/// The exponent of colour differences.
const COLOUR_EXPONENT: f32 = 0.7;
/// Part of the largest difference below which differences take most of the scale.
const LARGE_DIFFERENCE: f32 = 0.4;
/// Error up to which these differences reach.
const LARGE_ERROR: f32 = 0.95;

/// Buffers of one of the two images.
struct TileSide {
    /// Luma, red-green, blue-yellow of the square and its border.
    opponent: [Vec<f32>; 3],
    /// Filtered along rows: luma, red-green, blue-yellow twice; smooth, edge, point.
    rows: [Vec<f32>; 7],
    /// Filtered along columns, too: luma, red-green, blue-yellow.
    seen: [Vec<f32>; 3],
    /// Strength of edges and of points.
    features: [Vec<f32>; 2],
}

/// Buffers of a square and the error found in it.
pub(super) struct FlipTile {
    reach: usize,
    /// Texels a row with the border.
    padded: usize,
    /// The largest colour difference possible, raised to [`COLOUR_EXPONENT`].
    largest: f32,
    sides: [TileSide; 2],
    scratch: [Vec<f32>; 2],
    error: Vec<f32>,
}

impl FlipTile {
    pub(super) fn new(filters: &Filters) -> Self {
        let reach = filters.reach();
        let padded = TILE + 2 * reach;
        let buffer = |length: usize| vec![0.0; length];
        let side = || TileSide {
            opponent: std::array::from_fn(|_| buffer(padded * padded)),
            rows: std::array::from_fn(|_| buffer(TILE * padded)),
            seen: std::array::from_fn(|_| buffer(TILE * TILE)),
            features: std::array::from_fn(|_| buffer(TILE * TILE)),
        };
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(to_hunt_lab);
        Self {
            reach,
            padded,
            largest: power(hyab(green, blue), COLOUR_EXPONENT),
            sides: [side(), side()],
            scratch: std::array::from_fn(|_| buffer(TILE)),
            error: buffer(TILE * TILE),
        }
    }

    /// Takes the square whose upper left texel is `corner`; beyond the image its border is repeated.
    pub(super) fn load(&mut self, images: &Images, display: Display, corner: [usize; 2]) {
        let place = |i: usize, corner: usize, size: usize| {
            (corner + i).saturating_sub(self.reach).min(size - 1)
        };
        for (side, planes) in self.sides.iter_mut().zip([images.reference, images.test]) {
            for y in 0..self.padded {
                let row = place(y, corner[1], images.height) * images.width;
                for x in 0..self.padded {
                    let from = row + place(x, corner[0], images.width);
                    let rgb = planes.map(|plane| shown(plane[from], display));
                    let colour = to_opponent(rgb);
                    for (plane, value) in side.opponent.iter_mut().zip(colour) {
                        plane[y * self.padded + x] = value;
                    }
                }
            }
        }
    }

    /// The error of the square's texels.
    pub(super) fn compare(&mut self, filters: &Filters) {
        for side in &mut self.sides {
            side.filter_rows(filters, self.padded, self.reach);
            side.filter_columns(filters, self.reach, &mut self.scratch);
        }
        let [reference, test] = &self.sides;
        for (i, error) in self.error.iter_mut().enumerate() {
            let seen = [reference, test]
                .map(|side| -> Colour { std::array::from_fn(|c| side.seen[c][i]) });
            let colour = if seen[0] == seen[1] {
                0.0
            } else {
                let [one, other] = seen.map(|seen| {
                    to_hunt_lab(from_opponent(seen).map(|value| value.clamp(0.0, 1.0)))
                });
                remapped(power(hyab(one, other), COLOUR_EXPONENT), self.largest)
            };
            let feature = (0..2)
                .map(|kind| (reference.features[kind][i] - test.features[kind][i]).abs())
                .fold(0.0, f32::max);
            let feature = (std::f32::consts::FRAC_1_SQRT_2 * feature).sqrt();
            *error = if feature == 0.0 || (colour == 0.0 && feature < 1.0) {
                colour
            } else {
                power(colour, 1.0 - feature)
            };
        }
    }

    /// Raises those texels of `rows` that the square covers, from column `left` on.
    pub(super) fn raise(&self, rows: &mut [f32], width: usize, left: usize) {
        let columns = TILE.min(width - left);
        for (row, errors) in rows.chunks_mut(width).zip(self.error.chunks(TILE)) {
            let texels = &mut row[left..left + columns];
            for (texel, &error) in texels.iter_mut().zip(errors) {
                *texel = texel.max(error);
            }
        }
    }
}

impl TileSide {
    fn filter_rows(&mut self, filters: &Filters, padded: usize, reach: usize) {
        let [wide, narrow] = &filters.blue_yellow;
        let kernels = [
            (0, &filters.achromatic),
            (1, &filters.red_green),
            (2, wide),
            (2, narrow),
            (0, &filters.smooth),
            (0, &filters.edge),
            (0, &filters.point),
        ];
        for (out, (channel, weights)) in self.rows.iter_mut().zip(kernels) {
            let first = reach - weights.len() / 2;
            for (out, row) in out
                .chunks_exact_mut(TILE)
                .zip(self.opponent[channel].chunks_exact(padded))
            {
                along(&row[first..], weights, out);
            }
        }
    }

    fn filter_columns(&mut self, filters: &Filters, reach: usize, scratch: &mut [Vec<f32>; 2]) {
        let Self {
            rows,
            seen,
            features,
            ..
        } = self;
        let [wide, narrow] = &filters.blue_yellow;
        let [first, second] = scratch;
        for y in 0..TILE {
            let texels = y * TILE..(y + 1) * TILE;
            let down = |plane: usize, weights: &[f32], out: &mut [f32]| {
                let top = (y + reach - weights.len() / 2) * TILE;
                strided(&rows[plane][top..], TILE, weights, out);
            };
            down(0, &filters.achromatic, &mut seen[0][texels.clone()]);
            down(1, &filters.red_green, &mut seen[1][texels.clone()]);
            down(2, wide, first);
            down(3, narrow, second);
            for ((out, a), b) in seen[2][texels.clone()]
                .iter_mut()
                .zip(first.iter())
                .zip(second.iter())
            {
                *out = a + b;
            }
            // Luma is 116 Y − 16. Features are of Y, and derivatives do not see the constant.
            for (kind, (across, derivative)) in [(5, &filters.edge), (6, &filters.point)]
                .into_iter()
                .enumerate()
            {
                down(across, &filters.smooth, first);
                down(4, derivative, second);
                for ((out, x), y) in features[kind][texels.clone()]
                    .iter_mut()
                    .zip(first.iter())
                    .zip(second.iter())
                {
                    *out = (x * x + y * y).sqrt() / 116.0;
                }
            }
        }
    }
}

/// xʸ for x ≥ 0, to a rounding of f32. It takes half the time of `powf`, which took a quarter of that of a
/// study's report.
#[inline]
fn power(x: f32, y: f32) -> f32 {
    if y == 0.0 {
        return 1.0;
    }
    // The logarithm of zero is −∞, and 2 to that is zero.
    math::exp2(f64::from(y) * math::log2(f64::from(x))) as f32
}

/// Colour differences on the scale 0..=1, small ones stretched (Andersson et al. 2020, section 4.1.3).
#[inline]
fn remapped(difference: f32, largest: f32) -> f32 {
    let large = LARGE_DIFFERENCE * largest;
    if difference < large {
        difference * LARGE_ERROR / large
    } else {
        LARGE_ERROR + (difference - large) / (largest - large) * (1.0 - LARGE_ERROR)
    }
}
