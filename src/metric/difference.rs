//! Differences of two images: figures that need no error bars.
//!
//! Means are over samples: all texels and channels of a layer, unless said otherwise. d is the other image
//! less the reference r, in the image's unit. A texel is *lit* if the mean of the reference's channels is
//! above zero.

use rayon::prelude::*;
use serde::Serialize;

use super::pair::LayerPair;
use super::sums::{parts, sums};
use crate::numeric::math;

/// ε of relMSE in units of the squared mean of the reference, and of SMAPE in units of its mean.
///
/// Rousselle et al. (2011) divide by r² + 0.01 for images with a mean near one. Scaled to the mean, the
/// figure does not depend on the unit.
pub const EPSILON: f64 = 0.01;

/// Percentiles of the absolute difference that are reported, in thousandths.
pub const PER_MILLE: [u16; 5] = [500, 900, 950, 990, 999];

/// Figures of a layer. Relative figures are `None` if the reference has no light to be relative to.
///
/// # Example: two percent too much light
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
/// let difference = &comparison.layers[0].difference;
/// assert!((difference.energy_ratio.unwrap() - 1.02).abs() < 1e-6);
/// assert_eq!(difference.lit, 256);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Lit texels.
    pub lit: usize,
    /// Mean of the reference.
    pub mean_reference: f64,
    /// Mean of the other image.
    pub mean_other: f64,
    /// Mean of the reference over lit texels.
    #[doc(hidden)]
    pub mean_lit: f64,
    /// √(mean d²).
    pub rmse: f64,
    /// √(mean d²) / mean r, both over lit texels.
    pub relative_rmse: Option<f64>,
    /// mean d² / (r² + ε).
    pub rel_mse: Option<f64>,
    /// ε of `rel_mse`: [`EPSILON`] (mean r)².
    #[doc(hidden)]
    pub rel_mse_epsilon: f64,
    /// mean |d| / (|r| + |r + d| + ε): between 0 and 1.
    pub smape: Option<f64>,
    /// ε of `smape`: [`EPSILON`] mean r.
    #[doc(hidden)]
    pub smape_epsilon: f64,
    /// mean |d|.
    pub mae: f64,
    /// Σ (r + d) / Σ r.
    pub energy_ratio: Option<f64>,
    /// 10 log₁₀(peak² / mean d²) \[dB\]; `None` if the images are equal, which makes it infinite, or the
    /// reference is dark.
    pub psnr: Option<f64>,
    /// The peak of `psnr`: the largest value of the reference.
    #[doc(hidden)]
    pub psnr_peak: f64,
    /// Percentiles over texels of |d|, channels averaged.
    pub percentiles: Vec<Percentile>,
    /// The texel with the largest |d|, channels averaged.
    pub worst: WorstTexel,
}

/// The value that a part of the texels does not exceed.
///
/// # Example: the median
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
/// let median = comparison.layers[0].difference.percentiles[0];
/// assert_eq!(median.percent, 50.0);
/// assert!((median.value - 0.02).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Percentile {
    /// The part \[%\].
    pub percent: f64,
    /// The smallest |d| that this part of the texels does not exceed.
    pub value: f64,
}

/// The texel that differs most.
///
/// # Example: the place to look at first
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
/// let worst = &comparison.layers[0].difference.worst;
/// println!("texel ({}, {})", worst.x, worst.y);
/// assert!((worst.difference - 0.02).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstTexel {
    /// Column in the file.
    pub x: usize,
    /// Row in the file.
    pub y: usize,
    /// |d|, channels averaged.
    pub difference: f64,
    /// The reference there, channel by channel.
    #[doc(hidden)]
    pub reference: Vec<f64>,
    /// The other image there, channel by channel.
    #[doc(hidden)]
    pub other: Vec<f64>,
}

impl Difference {
    /// The figures of a layer.
    pub(crate) fn of(pair: &LayerPair) -> Self {
        let texels = pair.texels();
        let samples = (texels * pair.channels.len()) as f64;
        let [reference, other, lit, lit_reference] = sums(texels, |i| {
            let (reference, other) = pair.channels.iter().fold((0.0, 0.0), |(r, o), one| {
                (r + f64::from(one.reference[i]), o + f64::from(one.other[i]))
            });
            if reference > 0.0 {
                [reference, other, 1.0, reference]
            } else {
                [reference, other, 0.0, 0.0]
            }
        });
        let mean = reference / samples;
        let rel_mse_epsilon = EPSILON * mean * mean;
        let smape_epsilon = EPSILON * mean.max(0.0);
        let [squares, lit_squares, absolute, relative, symmetric] = sums(texels, |i| {
            let mut terms = [0.0; 5];
            let mut light = 0.0;
            for one in &pair.channels {
                let (r, o) = (f64::from(one.reference[i]), f64::from(one.other[i]));
                let d = o - r;
                light += r;
                terms[0] += d * d;
                terms[2] += d.abs();
                if d != 0.0 {
                    terms[3] += d * d / (r * r + rel_mse_epsilon);
                    terms[4] += d.abs() / (r.abs() + o.abs() + smape_epsilon);
                }
            }
            if light > 0.0 {
                terms[1] = terms[0];
            }
            terms
        });
        let peak = pair
            .channels
            .par_iter()
            .map(|one| {
                one.reference
                    .iter()
                    .copied()
                    .fold(f32::NEG_INFINITY, f32::max)
            })
            .reduce(|| f32::NEG_INFINITY, f32::max);
        let peak = f64::from(peak);
        let lit_samples = lit * pair.channels.len() as f64;
        let mean_lit = if lit > 0.0 {
            lit_reference / lit_samples
        } else {
            0.0
        };
        let has_light = mean > 0.0;
        let (percentiles, worst) = spread(pair);
        Self {
            lit: lit as usize,
            mean_reference: mean,
            mean_other: other / samples,
            mean_lit,
            rmse: (squares / samples).sqrt(),
            relative_rmse: (lit > 0.0).then(|| (lit_squares / lit_samples).sqrt() / mean_lit),
            rel_mse: has_light.then_some(relative / samples),
            rel_mse_epsilon,
            smape: has_light.then_some(symmetric / samples),
            smape_epsilon,
            mae: absolute / samples,
            energy_ratio: has_light.then_some(other / reference),
            psnr: (peak > 0.0 && squares > 0.0)
                .then(|| 10.0 * math::log10(peak * peak * samples / squares)),
            psnr_peak: peak,
            percentiles,
            worst,
        }
    }
}

/// Percentiles and the largest of |d|.
fn spread(pair: &LayerPair) -> (Vec<Percentile>, WorstTexel) {
    let texels = pair.texels();
    let weight = 1.0 / pair.channels.len() as f64;
    let difference = |i: usize| {
        let sum: f64 = pair
            .channels
            .iter()
            .map(|one| (f64::from(one.other[i]) - f64::from(one.reference[i])).abs())
            .sum();
        weight * sum
    };
    let (texel, largest) = parts(texels, |range| {
        range.map(|i| (i, difference(i))).fold((0, -1.0), larger)
    })
    .into_iter()
    .fold((0, -1.0), larger);
    let at = |plane: fn(&super::pair::ChannelPair, usize) -> f32| {
        let values = pair.channels.iter().map(|one| f64::from(plane(one, texel)));
        values.collect()
    };
    let [x, y] = pair.place(texel);
    let worst = WorstTexel {
        x,
        y,
        difference: largest,
        reference: at(|one, i| one.reference[i]),
        other: at(|one, i| one.other[i]),
    };
    let mut all: Vec<f64> = (0..texels).into_par_iter().map(difference).collect();
    let mut percentiles = Vec::new();
    // From the highest down: each selection leaves the values below it in front.
    for per_mille in PER_MILLE.into_iter().rev() {
        let rank = (texels * usize::from(per_mille)).div_ceil(1000).max(1) - 1;
        let value = *all.select_nth_unstable_by(rank, f64::total_cmp).1;
        all.truncate(rank + 1);
        let percent = f64::from(per_mille) / 10.0;
        percentiles.push(Percentile { percent, value });
    }
    percentiles.reverse();
    (percentiles, worst)
}

/// The pair with the larger number; the first of equal ones.
fn larger(one: (usize, f64), other: (usize, f64)) -> (usize, f64) {
    if other.1 > one.1 { other } else { one }
}
