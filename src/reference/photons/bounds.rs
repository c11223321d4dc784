//! Bounds of a texel's flux that hold for few photons, too, and for none.
//!
//! A standard error from the scatter of replicates is 0 where no photon arrived, and far off where few did.
//! The sum T of a texel's contributions wᵢ is a compound Poisson variable: contributions are independent, and
//! their number is random. (Sobol' points are more even than that, which makes bounds too wide, not too
//! narrow.) Its variance is E Σ wᵢ². The gamma interval of Fay and Feuer (*Statistics in Medicine* 16, 1997,
//! equations 9 and 10) covers its mean μ; for equal weights it is Garwood's exact interval of a Poisson mean:
//!
//! ```text
//! low  = V/T · G(α/2;  T²/V)
//! high = (V + W²)/(T + W) · G(1 − α/2;  (T + W)²/(V + W²))
//! ```
//!
//! G(p; k) is the quantile of a gamma variable of shape k and scale 1, V estimates the variance of T, and W
//! is the largest contribution that there may be: one more photon than was seen. Without any, T = V = 0 and
//! high = W ln(2/α). α is 1 − [`CONFIDENCE`].
//!
//! Contributions are positive: of filters with negative lobes nothing is said here. Light that falls on
//! several pixels counts once in each.
//!
//! **V** comes from the replicates, as the standard error does: of n ≪ R contributions, each in a replicate
//! of its own, ΣS² is Σ w². It is an estimate with R − 1 degrees of freedom, and can be small by chance. Two
//! things help:
//!
//! - Σ wᵢ² ≥ T²/n (Cauchy and Schwarz) for n contributions in all. Up to 4 R of them, V is at least that. Of
//!   more, Sobol' points may have less scatter than a Poisson variable, and replicates tell it well enough.
//! - For more than R contributions, Student's quantile t with R − 1 degrees of freedom takes the place of the
//!   normal one in G. For many, the interval is then T ± t √V.
//!
//! One replicate says nothing of the scatter: V is then W T, the most that weights up to W allow.
//!
//! **W** is the largest contribution of the layer that any photon of the run brought. The next one is larger
//! with probability 1/(N + 1) after N. Of fewer than [`ENOUGH`], the largest flux of a photon at its start
//! stands in for it: on a receiver no contribution is larger, but for what shading normals add, which counts
//! as it is seen. A camera's contributions have no such bound: there it is the largest of all layers, and
//! nothing is known without any.
//!
//! **G** is Wilson and Hilferty's (*PNAS* 17, 1931), k (1 − 1/(9 k) ± q/(3 √k))³ with q = 3.29: at this
//! confidence it is 3 % too wide for k = 1, 0.02 % for 100, and never too narrow (`tests/photons/bounds.rs`).

use rayon::prelude::*;

use super::weights::Largest;
use crate::numeric::distributions::critical_value;
use crate::numeric::math;
use crate::radiometry::Rgb;

/// The probability that a texel's truth lies between its bounds.
pub const CONFIDENCE: f64 = 0.999;

/// Contributions of a layer from which their largest is taken for the largest that there may be: the next one
/// exceeds it with a probability of a thousandth, and then mostly by little.
pub const ENOUGH: u64 = 1000;

/// Bounds from sums of so many replicates.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    replicates: f64,
    normal: f64,
    student: f64,
}

/// What is known of a texel's sum.
#[derive(Clone, Copy, Debug)]
pub struct Sum {
    /// T, in any unit.
    pub total: f64,
    /// The variance of T as replicates have it; NaN if there is one of them.
    pub variance: f64,
    /// n, or any larger number.
    pub contributions: u64,
    /// W; NaN if it is not known.
    pub largest: f64,
}

impl Bounds {
    /// Bounds from `replicates` independent sums.
    pub fn new(replicates: u32) -> Self {
        let replicates = f64::from(replicates);
        Self {
            replicates,
            normal: critical_value(CONFIDENCE, f64::INFINITY),
            student: critical_value(CONFIDENCE, (replicates - 1.0).max(1.0)),
        }
    }

    /// Bounds of the mean of a sum: `low` ≤ T ≤ `high`. NaN stays NaN.
    pub fn of(&self, sum: &Sum) -> [f64; 2] {
        let Sum {
            total,
            variance,
            contributions,
            largest,
        } = *sum;
        if total.is_nan() || largest.is_nan() {
            return [f64::NAN; 2];
        }
        let n = contributions as f64;
        let (variance, width) = if variance.is_nan() || self.replicates < 2.0 {
            (largest * total, self.normal)
        } else {
            let least = if n > 0.0 && n <= 4.0 * self.replicates {
                total * total / n
            } else {
                0.0
            };
            let width = if n > self.replicates {
                self.student
            } else {
                self.normal
            };
            (variance.max(least), width)
        };
        [
            gamma_quantile(total, variance, -width).min(total),
            gamma_quantile(total + largest, variance + largest * largest, width).max(total),
        ]
    }

    /// Bounds of light whose standard error is known exactly.
    pub fn of_normal(&self, value: f64, error: f64) -> [f64; 2] {
        let low = value - self.normal * error;
        // `max` would turn an unknown bound (NaN) into 0.
        [
            if low < 0.0 { 0.0 } else { low },
            value + self.normal * error,
        ]
    }

    /// Bounds of all texels, channel by channel: lower and upper ones.
    pub fn of_texels(
        &self,
        flux: &[Rgb],
        variance: &[Rgb],
        counts: &[u64],
        largest: Rgb,
    ) -> [Vec<Rgb>; 2] {
        let of = |total: f64, variance: f64, contributions: u64, c: usize| {
            self.of(&Sum {
                total,
                variance,
                contributions,
                largest: largest.0[c],
            })
        };
        // Most texels of most layers are dark.
        let dark: [[f64; 2]; 3] = std::array::from_fn(|c| of(0.0, 0.0, 0, c));
        let (mut low, mut high) = (Vec::new(), Vec::new());
        (flux, variance, counts)
            .into_par_iter()
            .map(|(flux, variance, count)| {
                let channels: [[f64; 2]; 3] = std::array::from_fn(|c| {
                    let total = flux.0[c];
                    if total == 0.0 {
                        dark[c]
                    } else {
                        of(total, variance.0[c], *count, c)
                    }
                });
                let end = |end: usize| Rgb(channels.map(|channel| channel[end]));
                (end(0), end(1))
            })
            .unzip_into_vecs(&mut low, &mut high);
        [low, high]
    }
}

/// The largest mean number of photons that may all fail to come, at [`CONFIDENCE`]: ln(2/α), Garwood's upper
/// bound of a Poisson mean of which nothing was seen.
pub fn at_most_unseen() -> f64 {
    math::ln(2.0 / (1.0 - CONFIDENCE))
}

/// The quantile of a gamma variable of this mean and variance, by Wilson and Hilferty; `width` is that of a
/// normal variable. 0 for a mean of 0.
fn gamma_quantile(mean: f64, variance: f64, width: f64) -> f64 {
    if mean <= 0.0 || variance <= 0.0 {
        return mean;
    }
    // 1/k, which vanishes where there is no scatter.
    let inverse = variance / (mean * mean);
    let root = 1.0 - inverse / 9.0 + width * inverse.sqrt() / 3.0;
    let root = root.max(0.0);
    mean * (root * root * root)
}

/// The largest contribution that a layer may get, from those that it and all layers got and the photons at
/// their start; all in one unit.
pub fn largest_possible(layer: &Largest, all: &Largest, is_camera: bool) -> Rgb {
    if layer.contributions >= ENOUGH {
        return layer.flux;
    }
    if is_camera {
        return match all.contributions {
            0 => Rgb::grey(f64::NAN),
            _ => all.flux,
        };
    }
    Rgb(std::array::from_fn(|c| {
        layer.flux.0[c].max(all.emitted.0[c])
    }))
}
