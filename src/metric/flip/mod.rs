//! FLIP: the difference a viewer sees who flips between two images, 0 (none) to 1.
//!
//! - LDR-FLIP: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, *FLIP: A Difference
//!   Evaluator for Alternating Images*, HPG 2020, with the separable kernels of the authors' later
//!   releases.
//! - HDR-FLIP: Andersson, Nilsson, Shirley, Akenine-Möller, *Visualizing Errors in Rendered High
//!   Dynamic Range Images*, Eurographics 2021: the largest LDR-FLIP over a range of exposures.
//!
//! `tests/compare/flip.rs` holds both against the authors' own package. Our own code, since the
//! one crate there is (`nv-flip`) binds to their C++ and does LDR only.

mod colour;
mod filters;
mod tile;

use rayon::prelude::*;

use colour::luminance;
use filters::Filters;
use tile::{TILE, Tile};

/// Pixels a degree of vision at 0.7 m from a screen 0.7 m wide with 3840 pixels: the authors' default.
pub const PIXELS_PER_DEGREE: f32 = 0.7 * (3840.0 / 0.7) * (std::f32::consts::PI / 180.0);

/// Red, green and blue, row by row, linear sRGB.
pub type Planes<'a> = [&'a [f32]; 3];

/// Two images of one size.
#[derive(Clone, Copy, Debug)]
pub struct Images<'a> {
    /// The truth.
    pub reference: Planes<'a>,
    /// What is compared with it.
    pub test: Planes<'a>,
    /// Texels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// The exposures of HDR-FLIP \[stops\].
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Exposures {
    /// The lowest: the brightest texel of the reference just keeps its contrast.
    pub start: f32,
    /// The highest: so does the median.
    pub stop: f32,
    /// How many there are, evenly spaced, both ends included.
    pub count: usize,
}

/// What is done to values before they are compared.
#[derive(Clone, Copy)]
enum Display {
    /// Clamped to 0..=1.
    Clamp,
    /// Multiplied by a factor, tone-mapped, clamped.
    Expose(f32),
}

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
        raise(&mut map, images, &filters, Display::Expose(exposure.exp2()));
    }
    map
}

impl Exposures {
    /// The luminance that ACES maps to 0.85, above which it has little contrast left.
    ///
    /// The positive root of (2.51 a² x² + 0.03 a x) = 0.85 (2.43 a² x² + 0.59 a x + 0.14), where
    /// a = 0.6 undoes the exposure built into Narkowicz' fit.
    fn brightest_shown() -> f32 {
        const SHOWN: f32 = 0.85;
        let a = tile::ACES[0] - SHOWN * tile::ACES[2];
        let b = tile::ACES[1] - SHOWN * tile::ACES[3];
        let c = -SHOWN * tile::ACES[4];
        (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
    }

    /// The authors' choice for a reference (Andersson et al. 2021, section 3.2): from log₂(x/max) to
    /// log₂(x/median) of its luminance, one exposure a stop, two at least.
    ///
    /// Where the median is not positive (an image more than half dark), that of the positive
    /// texels takes its place: the authors' choice would be infinite. `None` where no texel has a
    /// positive luminance.
    pub fn of(reference: Planes) -> Option<Self> {
        let [red, green, blue] = reference;
        let mut luminances: Vec<f32> = (red, green, blue)
            .into_par_iter()
            .map(|(&r, &g, &b)| luminance([r, g, b]))
            .collect();
        let brightest = luminances.iter().copied().fold(0.0, f32::max);
        if brightest <= 0.0 || !brightest.is_finite() {
            return None;
        }
        let mut median = median_of(&mut luminances);
        if median <= 0.0 {
            luminances.retain(|luminance| *luminance > 0.0);
            median = median_of(&mut luminances);
        }
        let shown = Self::brightest_shown();
        let (start, stop) = ((shown / brightest).log2(), (shown / median).log2());
        Some(Self {
            start,
            stop,
            count: (stop - start).ceil().max(2.0) as usize,
        })
    }
}

/// The upper median; `values` are not empty and not NaN.
fn median_of(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Raises each texel of `map` to its LDR-FLIP, where that is larger.
fn raise(map: &mut [f32], images: &Images, filters: &Filters, display: Display) {
    let width = images.width;
    map.par_chunks_mut(TILE * width).enumerate().for_each_init(
        || Tile::new(filters),
        |tile, (band, rows)| {
            for left in (0..width).step_by(TILE) {
                tile.load(images, display, [left, band * TILE]);
                tile.compare(filters);
                tile.raise(rows, width, left);
            }
        },
    );
}
