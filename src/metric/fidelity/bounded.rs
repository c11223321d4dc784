//! A figure between two ends.

use serde::Serialize;

/// A figure, with the values that the truth's bars allow.
///
/// # Example: an L1 that the truth's bars leave open by a third
///
/// ```
/// let l1 = nephroid::Bounded { value: 0.3, low: Some(0.2), high: Some(0.4) };
/// assert!(l1.low < Some(l1.value) && Some(l1.value) < l1.high);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bounded {
    /// The figure, with the truth's values taken at their word.
    pub value: f64,
    /// The least that it can be; `None` if the truth has no bars.
    pub low: Option<f64>,
    /// The most that it can be; `None` if the truth has no bars, or bars that allow anything.
    pub high: Option<f64>,
}

impl Bounded {
    /// The figure in another unit.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self {
            value: factor * self.value,
            low: self.low.map(|low| factor * low),
            high: self.high.map(|high| factor * high),
        }
    }
}
