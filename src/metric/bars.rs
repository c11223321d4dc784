//! Values with their error bars.

use std::borrow::Cow;

/// Values with what is known of their errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Bars<'a> {
    /// The values.
    pub values: Cow<'a, [f32]>,
    /// One standard error of each.
    pub standard_errors: Option<Cow<'a, [f32]>>,
    /// Lower and upper bounds.
    pub bounds: Option<[Cow<'a, [f32]>; 2]>,
    /// Lower and upper bounds by the same samples as the standard errors, which stand in for these where few
    /// samples arrived.
    pub sampling: Option<[Cow<'a, [f32]>; 2]>,
    /// Degrees of freedom of the standard errors; infinite if they count as exact.
    pub freedom: f64,
}

/// The attribute of files whose bounds are of the same samples as their standard errors.
pub const CONFIDENCE: &str = "confidence";

/// Effective number of samples k, (value / standard error)², from which a standard error is one. Sums of few
/// samples are skewed, and z² is too large by 2 s/k in the mean: s is 1 for equal weights, 9/4 for
/// exponential ones. That is 2 % to 5 %, less than the 7 % of 32 replicates. (`tests/photons/bounds.rs`)
const MANY: f64 = 100.0;

impl Bars<'_> {
    /// True if anything is known of the errors.
    pub fn has_any(&self) -> bool {
        self.standard_errors.is_some() || self.bounds.is_some()
    }

    /// The bounds of a texel that few samples reached, where they are known.
    pub(super) fn few(&self, texel: usize) -> Option<[f64; 2]> {
        let [low, high] = self.sampling.as_ref()?;
        let value = f64::from(self.values[texel]);
        let is_many = value * value >= MANY * self.variance(texel) && value != 0.0;
        let ends = [f64::from(low[texel]), f64::from(high[texel])];
        (!is_many && ends[0] < ends[1]).then_some(ends)
    }

    pub(super) fn interval(&self, texel: usize) -> [f64; 2] {
        match &self.bounds {
            Some([low, high]) => [f64::from(low[texel]), f64::from(high[texel])],
            None => [f64::from(self.values[texel]); 2],
        }
    }

    pub(super) fn variance(&self, texel: usize) -> f64 {
        let error = |errors: &Cow<[f32]>| f64::from(errors[texel]);
        let error = self.standard_errors.as_ref().map_or(0.0, error);
        error * error
    }
}
