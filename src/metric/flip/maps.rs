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
    let mut map = vec![0.0; images.width * images.height];
    raise(
        &mut map,
        images,
        &Filters::new(pixels_per_degree),
        Display::Clamp,
    );
    map
}

/// HDR-FLIP of each texel, row by row: the largest LDR-FLIP over `exposures`, tone-mapped by ACES.
pub fn hdr(images: &Images, pixels_per_degree: f32, exposures: &Exposures) -> Vec<f32> {
    let filters = Filters::new(pixels_per_degree);
    let mut map = vec![0.0; images.width * images.height];
    let step = (exposures.stop - exposures.start) / exposures.count.max(2).saturating_sub(1) as f32;
    for i in 0..exposures.count {
        let exposure = exposures.start + i as f32 * step;
        raise(
            &mut map,
            images,
            &filters,
            Display::Expose(single::exp2(exposure)),
        );
    }
    map
}

/// Raises each texel of `map` to its LDR-FLIP, if that is larger.
fn raise(map: &mut [f32], images: &Images, filters: &Filters, display: Display) {
    let width = images.width;
    map.par_chunks_mut(TILE * width).enumerate().for_each_init(
        || FlipTile::new(filters),
        |tile, (band, rows)| {
            for left in (0..width).step_by(TILE) {
                tile.load(images, display, [left, band * TILE]);
                tile.compare(filters);
                tile.raise(rows, width, left);
            }
        },
    );
}
