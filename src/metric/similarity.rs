//! Structural similarity: the degree to which two images vary together.

use rayon::prelude::*;
use serde::Serialize;

use super::pair::LayerPair;
use crate::numeric::math;

/// SSIM of a layer, and the settings that it depends on.
///
/// # Example: images that vary together
///
/// ```
/// # use nephroid::{CompareImage, CompareSettings, Image, compare};
/// # let grey = |value: f64| {
/// #     let mut image = Image::new(16, 16);
/// #     image.add_rgb("E", &[[value; 3]; 256]);
/// #     image.add_rgb("E.stderr", &[[0.001; 3]; 256]);
/// #     CompareImage::new(format!("{value}.exr"), image)
/// # };
/// # let (truth, mine) = (grey(1.0), grey(1.02));
/// # let comparison = compare(&truth, &mine, &CompareSettings::default())?;
/// let similarity = comparison.layers[0].similarity.unwrap();
/// assert!(similarity.ssim > 0.99);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Similarity {
    /// The mean over windows and channels: 1 for equal images.
    pub ssim: f64,
    /// Texels a side of the window.
    #[doc(hidden)]
    pub window: usize,
    /// Standard deviation of the window's Gaussian weights \[texels\].
    #[doc(hidden)]
    pub deviation: f64,
    /// The dynamic range L: the 99th percentile of the reference's lit samples.
    #[doc(hidden)]
    pub dynamic_range: f64,
}

/// Texels a side of the window.
const WINDOW: usize = 11;
/// Standard deviation of its weights.
const DEVIATION: f64 = 1.5;
/// The constants K₁ and K₂.
const K: [f64; 2] = [0.01, 0.03];
/// The part of the reference's lit samples that lies within the dynamic range.
const RANGE_PART: f64 = 0.99;

impl Similarity {
    /// SSIM by Wang, Bovik, Sheikh, Simoncelli (*IEEE Trans. Image Processing* 13(4), 2004),
    ///
    /// ```text
    /// SSIM = (2 μ_r μ_o + C₁)(2 σ_ro + C₂) / ((μ_r² + μ_o² + C₁)(σ_r² + σ_o² + C₂)),  Cᵢ = (Kᵢ L)²
    /// ```
    ///
    /// with means and covariances over a window of 11 x 11 texels under Gaussian weights of deviation 1.5,
    /// and K = 0.01 and 0.03. The figure is the mean over all windows that lie wholly in the image.
    ///
    /// The dynamic range L of 8-bit images is 255; a map of light has none. With its largest value as L, the
    /// few texels of a focus would make all else look alike. So L is the 99th percentile of the reference's
    /// positive samples.
    ///
    /// `None` if the image is smaller than the window or the reference is dark.
    pub(crate) fn of(pair: &LayerPair) -> Option<Self> {
        if pair.width < WINDOW || pair.height < WINDOW {
            return None;
        }
        let mut lit: Vec<f32> = pair
            .channels
            .iter()
            .flat_map(|one| one.reference.iter().copied().filter(|value| *value > 0.0))
            .collect();
        if lit.is_empty() {
            return None;
        }
        let rank = ((RANGE_PART * lit.len() as f64) as usize).min(lit.len() - 1);
        let dynamic_range = f64::from(*lit.select_nth_unstable_by(rank, f32::total_cmp).1);
        drop(lit);
        let constants = K.map(|k| (k * dynamic_range) * (k * dynamic_range));
        let weights = weights();
        let rows = pair.height - WINDOW + 1;
        // Row by row in order, so that the sum is the same on any number of threads.
        let sums: Vec<f64> = (0..rows)
            .into_par_iter()
            .map(|row| {
                let of = |one: &super::pair::ChannelPair| {
                    row_sum(
                        one.reference,
                        one.other,
                        pair.width,
                        row,
                        &weights,
                        constants,
                    )
                };
                pair.channels.iter().map(of).sum()
            })
            .collect();
        let windows = rows * (pair.width - WINDOW + 1) * pair.channels.len();
        Some(Self {
            ssim: sums.iter().sum::<f64>() / windows as f64,
            window: WINDOW,
            deviation: DEVIATION,
            dynamic_range,
        })
    }
}

/// Gaussian weights that sum to one.
fn weights() -> [f64; WINDOW] {
    let bell = |i: usize| {
        let x = (i as f64 - (WINDOW / 2) as f64) / DEVIATION;
        math::exp(-0.5 * x * x)
    };
    let sum: f64 = (0..WINDOW).map(bell).sum();
    std::array::from_fn(|i| bell(i) / sum)
}

/// The sum of SSIM over the windows whose first row is `row`.
fn row_sum(
    reference: &[f32],
    other: &[f32],
    width: usize,
    row: usize,
    weights: &[f64; WINDOW],
    [c1, c2]: [f64; 2],
) -> f64 {
    // Columns first: weighted sums of r, o, r², o² and r o.
    let mut columns = vec![[0.0f64; 5]; width];
    for (k, weight) in weights.iter().enumerate() {
        let from = (row + k) * width;
        let texels = reference[from..from + width]
            .iter()
            .zip(&other[from..from + width]);
        for (column, (&r, &o)) in columns.iter_mut().zip(texels) {
            let (r, o) = (f64::from(r), f64::from(o));
            column[0] += weight * r;
            column[1] += weight * o;
            column[2] += weight * r * r;
            column[3] += weight * o * o;
            column[4] += weight * r * o;
        }
    }
    columns
        .windows(WINDOW)
        .map(|window| {
            let mut moments = [0.0; 5];
            for (column, weight) in window.iter().zip(weights) {
                for (moment, value) in moments.iter_mut().zip(column) {
                    *moment += weight * value;
                }
            }
            let [r, o, rr, oo, ro] = moments;
            let (variances, covariance) = ((rr - r * r) + (oo - o * o), ro - r * o);
            (2.0 * r * o + c1) * (2.0 * covariance + c2) / ((r * r + o * o + c1) * (variances + c2))
        })
        .sum()
}
