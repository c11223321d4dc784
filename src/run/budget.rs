//! The limits of a run.

use std::time::{Duration, Instant};

/// The limits of a run: it ends at the first that it reaches.
///
/// Without any limit a method does its default amount of work.
///
/// # Example: half a percent, but at most ten seconds
///
/// ```
/// use std::time::Duration;
///
/// let budget = nephroid::Budget {
///     time: Some(Duration::from_secs(10)),
///     ..nephroid::Budget::error(0.005)
/// };
/// assert_eq!(budget.relative_error, Some(0.005));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Relative error to stop at: the standard error of random methods over lit texels, the likely error
    /// of deterministic ones.
    pub relative_error: Option<f64>,
    /// Time from the start of the run.
    pub time: Option<Duration>,
    /// Work, all replicates together, in the method's own unit: photons, rays of beams, samples a pixel.
    pub work: Option<u64>,
}

impl Budget {
    /// A budget that ends at a relative error.
    ///
    /// # Example: one percent
    ///
    /// ```
    /// assert_eq!(nephroid::Budget::error(0.01).relative_error, Some(0.01));
    /// ```
    pub fn error(relative_error: f64) -> Self {
        Self {
            relative_error: Some(relative_error),
            ..Self::default()
        }
    }

    /// A budget that ends after so much work, in the method's own unit.
    ///
    /// # Example: a million photons
    ///
    /// ```
    /// assert_eq!(nephroid::Budget::work(1 << 20).work, Some(1_048_576));
    /// ```
    pub fn work(work: u64) -> Self {
        Self {
            work: Some(work),
            ..Self::default()
        }
    }

    /// A budget that ends after so much time.
    ///
    /// # Example: a minute
    ///
    /// ```
    /// let minute = std::time::Duration::from_secs(60);
    /// assert_eq!(nephroid::Budget::time(minute).time, Some(minute));
    /// ```
    pub fn time(time: Duration) -> Self {
        Self {
            time: Some(time),
            ..Self::default()
        }
    }

    /// These limits, and those of `other` for what has none here.
    ///
    /// # Example: a limit on work beside one on the error
    ///
    /// ```
    /// use nephroid::Budget;
    ///
    /// let both = Budget::error(0.01).or(Budget::work(1 << 20));
    /// assert_eq!((both.relative_error, both.work), (Some(0.01), Some(1 << 20)));
    /// ```
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            relative_error: self.relative_error.or(other.relative_error),
            time: self.time.or(other.time),
            work: self.work.or(other.work),
        }
    }

    /// True if the amount of work is known beforehand: neither time nor error ends the run.
    #[doc(hidden)]
    pub fn is_work_only(&self) -> bool {
        self.time.is_none() && self.relative_error.is_none()
    }

    /// The instant at which the time is over, for a run that began at `start`. A time beyond what the clock
    /// can tell is no limit.
    pub(crate) fn deadline(&self, start: Instant) -> Option<Instant> {
        self.time.and_then(|time| start.checked_add(time))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_limits_go_before_those_of_another_budget() {
        let own = Budget {
            time: Some(Duration::from_secs(1)),
            ..Budget::error(0.01)
        };
        let other = Budget {
            time: Some(Duration::from_secs(2)),
            work: Some(3),
            ..Budget::error(0.02)
        };
        let both = own.or(other);
        assert_eq!(
            both,
            Budget {
                work: Some(3),
                ..own
            }
        );
        assert_eq!(Budget::default().or(other), other);
        assert_eq!(other.or(own), other);
    }
}
