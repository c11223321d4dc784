//! An estimate beside a closed form, texel by texel.

use nephroid::internals::reference::closed_form::TexelGrid;
use nephroid::internals::run::Estimate;

use super::scenes::{Photons, layer, sensor_area};
use super::student;
use nephroid::internals::scene::Scene;

/// Photons a texel must expect of each replicate before its error bar is judged.
///
/// Below this the texel's sum in one replicate is a count of a few photons and no normal
/// number: √30 = 5.5 is where a Poisson count's skewness falls below 0.2.
pub const LEAST_PHOTONS: f64 = 30.0;

/// One layer of an estimate, and its closed form.
pub struct Compared {
    /// Name of the layer, for messages.
    pub name: String,
    /// Estimated irradiance [W/m²].
    pub estimate: Vec<f64>,
    /// Its standard error [W/m²].
    pub error: Vec<f64>,
    /// The closed form lies between these [W/m²]: equal where it is exact.
    pub low: Vec<f64>,
    /// See `low`.
    pub high: Vec<f64>,
    /// A lower bound on the photons that fall into the texel in each replicate.
    pub photons: Vec<f64>,
    /// Degrees of freedom of the error bars.
    pub freedom: u32,
    /// Replicates that they come from.
    pub replicates: f64,
}

/// Agreement of an estimate with a closed form over the texels that can be judged.
#[derive(Clone, Copy, Debug)]
pub struct Agreement {
    /// Number of texels that were judged.
    pub texels: usize,
    /// Mean z-score.
    pub mean: f64,
    /// Mean squared z-score: the variance about the truth.
    pub variance: f64,
    /// The largest |z|.
    pub largest: f64,
    /// √(mean squared difference) / mean of the closed form.
    pub relative_rmse: f64,
    /// √(mean squared standard error) / mean of the closed form.
    pub relative_error: f64,
}

impl Compared {
    /// A layer, its first channel, beside its closed form.
    pub fn new(
        scene: &Scene,
        photons: &Photons,
        estimate: &Estimate,
        signature: &str,
        truth: &[f64],
    ) -> Self {
        Self::channel(scene, photons, estimate, signature, 0, truth)
    }

    /// As [`Compared::new`], for one channel.
    pub fn channel(
        scene: &Scene,
        photons: &Photons,
        estimate: &Estimate,
        signature: &str,
        channel: usize,
        truth: &[f64],
    ) -> Self {
        let (values, error) = layer(estimate, signature, channel);
        assert_eq!(values.len(), truth.len());
        let texel_area = sensor_area(scene) / truth.len() as f64;
        // No photon brings more than its share of what was emitted, so a texel of a given flux
        // takes at least so many of them.
        let emitted = estimate.ledger.emitted.0[channel];
        let replicates = f64::from(photons.settings.replicates);
        let each = estimate.paths as f64 / replicates;
        Self {
            name: format!("{} {signature}", scene.path().display()),
            estimate: values,
            error,
            low: truth.to_vec(),
            high: truth.to_vec(),
            photons: truth
                .iter()
                .map(|value| value * texel_area / emitted * each)
                .collect(),
            freedom: photons.settings.replicates - 1,
            replicates,
        }
    }

    /// Says that no photon of the layer carries more than this fraction of the flux it started with:
    /// so many more of them there must be.
    pub fn photons_carry_at_most(mut self, share: f64) -> Self {
        self.photons.iter_mut().for_each(|count| *count /= share);
        self
    }

    /// Widens the closed form by what is not known of it, the same for all texels [W/m²].
    pub fn known_to(mut self, accuracy: f64) -> Self {
        self.low.iter_mut().for_each(|low| *low -= accuracy);
        self.high.iter_mut().for_each(|high| *high += accuracy);
        self
    }

    /// The texels whose closed form says that enough photons fall into them.
    ///
    /// Chosen by the truth: chosen by the estimate, texels that happened to catch more light
    /// than their due would be preferred, and the z-scores would have a positive mean.
    pub fn judged(&self) -> impl Iterator<Item = usize> {
        (0..self.low.len()).filter(|&texel| self.photons[texel] >= LEAST_PHOTONS)
    }

    /// The distance from the closed form in standard errors, negative below it.
    pub fn z(&self, texel: usize) -> f64 {
        let value = self.estimate[texel];
        let off = if value > self.high[texel] {
            value - self.high[texel]
        } else {
            (value - self.low[texel]).min(0.0)
        };
        if off == 0.0 {
            return 0.0;
        }
        // Fixed-point sums round to about 1e-15 of a texel's flux; where light arrives
        // without any randomness, that is all the error there is.
        let rounding = 1e-13 * value.abs();
        off / self.error[texel].hypot(rounding)
    }

    /// Figures over the texels that `region` holds.
    pub fn agreement_of(&self, region: impl Fn(usize) -> bool) -> Agreement {
        let judged: Vec<usize> = (0..self.low.len()).filter(|&texel| region(texel)).collect();
        let count = judged.len() as f64;
        let mean = |value: &dyn Fn(usize) -> f64| {
            judged.iter().map(|&texel| value(texel)).sum::<f64>() / count
        };
        let truth = |texel: usize| 0.5 * (self.low[texel] + self.high[texel]);
        let level = mean(&truth);
        Agreement {
            texels: judged.len(),
            mean: mean(&|texel| self.z(texel)),
            variance: mean(&|texel| self.z(texel).powi(2)),
            largest: judged
                .iter()
                .map(|&texel| self.z(texel).abs())
                .fold(0.0, f64::max),
            relative_rmse: mean(&|texel| (self.estimate[texel] - truth(texel)).powi(2)).sqrt()
                / level,
            relative_error: mean(&|texel| self.error[texel].powi(2)).sqrt() / level,
        }
    }

    /// Figures over all texels that can be judged.
    pub fn agreement(&self) -> Agreement {
        self.agreement_of(|texel| self.photons[texel] >= LEAST_PHOTONS)
    }

    /// Every region that can be judged lies within Student's quantile of the closed form; at
    /// least `least` of them can.
    ///
    /// `alpha` is the probability that a right program fails one of `comparisons` in the whole
    /// test file (Bonferroni).
    pub fn assert_every_texel_agrees(&self, least: usize, alpha: f64, comparisons: usize) {
        let limit = student::two_sided_quantile(alpha / comparisons as f64, self.freedom);
        let mut judged = 0;
        for texel in self.judged() {
            judged += 1;
            let z = self.z(texel);
            assert!(
                z.abs() <= limit,
                "{}: texel {texel} is {} ± {}, the closed form {}..{}: z = {z:.2}, allowed {limit:.2}",
                self.name,
                self.estimate[texel],
                self.error[texel],
                self.low[texel],
                self.high[texel]
            );
        }
        assert!(
            judged >= least,
            "{}: only {judged} can be judged",
            self.name
        );
    }

    /// The z-scores of all texels that can be judged have the mean 0 and the variance of
    /// Student's t, within what so many texels allow.
    ///
    /// - Mean: of n z-scores it deviates by √(ν/(ν−2)/n). Texels are counts of the same photons:
    ///   where one has more another has less, so their covariance only narrows this.
    ///   A texel's N photons make a sum of skewness γ ≤ 1/√N, which pulls the mean
    ///   of t by −γ/2 (mean and deviation of a skewed sum go together; Johnson 1978).
    /// - Variance: t² has a known deviation and skewness; the mean of n of them is judged by its
    ///   normal quantile with the first Cornish–Fisher term. Skewed sums raise E t² by up to
    ///   2γ² (the first term of its expansion in 1/R).
    pub fn assert_honest_errors(&self, least: usize, alpha: f64, comparisons: usize) {
        let it = self.agreement();
        assert!(it.texels >= least, "{}: only {it:?}", self.name);
        let n = it.texels as f64;
        let quantile = student::normal_quantile(alpha / comparisons as f64);
        let law = student::moments(self.freedom);
        let photons = |texel: usize| self.photons[texel] * self.replicates;
        let skew = self
            .judged()
            .map(|texel| 0.5 / photons(texel).sqrt())
            .sum::<f64>()
            / n;
        let mean_limit = quantile * (law.variance / n).sqrt() + skew;
        assert!(
            it.mean.abs() <= mean_limit,
            "{}: {it:?}; |mean| up to {mean_limit} allowed",
            self.name
        );
        let edgeworth = law.skewness_of_square / (6.0 * n.sqrt()) * (quantile * quantile - 1.0);
        let skew_squared = self.judged().map(|texel| 2.0 / photons(texel)).sum::<f64>() / n;
        let low = law.variance - (quantile - edgeworth) * law.deviation_of_square / n.sqrt();
        let high = law.variance
            + (quantile + edgeworth) * law.deviation_of_square / n.sqrt()
            + skew_squared;
        assert!(
            (low..=high).contains(&it.variance),
            "{}: {it:?}; variance {low}..{high} allowed",
            self.name
        );
    }

    /// Texels that the closed form and all their neighbours leave dark are exactly dark; at
    /// least `least` are.
    pub fn assert_darkness_is_exact(&self, grid: &TexelGrid, least: usize) {
        let is_dark = |texel: usize| {
            let (column, row) = (texel % grid.columns, texel / grid.columns);
            let near = |i: usize, count: usize| i.saturating_sub(1)..=(i + 1).min(count - 1);
            near(row, grid.rows)
                .flat_map(|y| near(column, grid.columns).map(move |x| y * grid.columns + x))
                .all(|texel| self.high[texel] == 0.0)
        };
        let dark: Vec<usize> = (0..self.low.len())
            .filter(|&texel| is_dark(texel))
            .collect();
        assert!(dark.len() >= least, "{}: {} dark", self.name, dark.len());
        for texel in dark {
            assert!(
                self.estimate[texel] == 0.0,
                "{}: texel {texel} should be dark",
                self.name
            );
        }
    }
}
