//! Means, variances and the distributions that turn them into confidence.

/// Mean and variance of numbers seen one at a time.
///
/// Welford's update (*Technometrics* 4(3), 1962): stable where the variance is far below the
/// squared mean. Its rounding depends on the order; where bits must not, sum with
/// [`ExactSum`](super::ExactSum).
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Moments {
    count: u64,
    mean: f64,
    sum_of_squared_deviations: f64,
}

impl Moments {
    /// No number seen.
    pub const fn new() -> Self {
        Self {
            count: 0,
            mean: 0.0,
            sum_of_squared_deviations: 0.0,
        }
    }

    /// Adds one number.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        let deviation = value - self.mean;
        self.mean += deviation / self.count as f64;
        self.sum_of_squared_deviations += deviation * (value - self.mean);
    }

    /// Adds all that `other` has seen (Chan et al., *Updating Formulae and a Pairwise Algorithm for Computing Sample Variances*, 1979).
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        if self.count == 0 {
            *self = *other;
            return;
        }
        let count = self.count + other.count;
        let difference = other.mean - self.mean;
        let share = other.count as f64 / count as f64;
        self.mean += difference * share;
        self.sum_of_squared_deviations +=
            other.sum_of_squared_deviations + difference * difference * self.count as f64 * share;
        self.count = count;
    }

    /// How many numbers were seen.
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The mean; `None` before the first number.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.mean)
    }

    /// The unbiased variance of one number; `None` below two.
    pub fn variance(&self) -> Option<f64> {
        (self.count > 1).then(|| self.sum_of_squared_deviations / (self.count - 1) as f64)
    }

    /// The standard error of the mean, for independent numbers; `None` below two.
    pub fn standard_error(&self) -> Option<f64> {
        self.variance()
            .map(|variance| (variance / self.count as f64).sqrt())
    }
}

impl Extend<f64> for Moments {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, values: I) {
        values.into_iter().for_each(|value| self.add(value));
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Self::new();
        moments.extend(values);
        moments
    }
}
