//! FLIP of each texel of two images.

use rayon::prelude::*;

use super::display::Display;
use super::exposures::Exposures;
use super::filters::Filters;
use super::images::Images;
use super::tile::{FlipTile, TILE};
use crate::numeric::math::single;

/// LDR-FLIP of each texel, row by row; values outside 0..=1 are clamped.
pub fn ldr(images: &Images, pixels_per_degree: f32) -> Vec<f32> {
    largest(images, pixels_per_degree, &[Display::Clamp])
}

/// HDR-FLIP of each texel, row by row: the largest LDR-FLIP over `exposures`, tone-mapped by ACES.
pub fn hdr(images: &Images, pixels_per_degree: f32, exposures: &Exposures) -> Vec<f32> {
    let step = (exposures.stop - exposures.start) / exposures.count.max(2).saturating_sub(1) as f32;
    let displays = (0..exposures.count).map(|i| {
        let exposure = exposures.start + i as f32 * step;
        Display::Expose(single::exp2(exposure))
    });
    largest(images, pixels_per_degree, &displays.collect::<Vec<_>>())
}

/// The largest LDR-FLIP of each texel over some displays.
fn largest(images: &Images, pixels_per_degree: f32, displays: &[Display]) -> Vec<f32> {
    let filters = &Filters::new(pixels_per_degree);
    let width = images.width;
    let mut map = vec![0.0; width * images.height];
    // As light without noise often is, straight from emitters.
    if images.reference == images.test {
        return map;
    }
    // An image has few bands, and one of few exposures has few of these: both keep threads busy.
    let bands = map.par_chunks_mut(TILE * width).enumerate();
    bands.for_each(|(band, rows)| {
        let texels = rows.len();
        let of_displays = displays.par_iter().fold(
            || None,
            |so_far: Option<(FlipTile, Vec<f32>)>, display| {
                let (mut tile, mut rows) =
                    so_far.unwrap_or_else(|| (FlipTile::new(filters), vec![0.0; texels]));
                for left in (0..width).step_by(TILE) {
                    tile.load(images, *display, [left, band * TILE]);
                    tile.compare(filters);
                    tile.raise(&mut rows, width, left);
                }
                Some((tile, rows))
            },
        );
        let found = of_displays.flatten().map(|(_, rows)| rows);
        let found = found.reduce_with(|mut one, other| {
            raise(&mut one, &other);
            one
        });
        // The largest of some numbers is the same in any order.
        raise(rows, &found.unwrap_or_default());
    });
    map
}

/// Raises values to others that are larger.
fn raise(values: &mut [f32], others: &[f32]) {
    for (value, other) in values.iter_mut().zip(others) {
        *value = value.max(*other);
    }
}
