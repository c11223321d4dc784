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
    /// Degrees of freedom of the standard errors; infinite if they count as exact.
    pub freedom: f64,
}

impl Bars<'_> {
    /// True if anything is known of the errors.
    pub fn has_any(&self) -> bool {
        self.standard_errors.is_some() || self.bounds.is_some()
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
