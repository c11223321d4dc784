//! Means and variances of samples.

/// Mean and variance of numbers added one at a time.
///
/// Welford's update (*Technometrics* 4(3), 1962): stable even if the variance is far below the squared mean.
/// Its rounding depends on the order; use [`ExactSum`](super::ExactSum) if the bits must not.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SampleMoments {
    count: u64,
    mean: f64,
    sum_of_squared_deviations: f64,
}

impl SampleMoments {
    /// The moments of no numbers.
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

    /// Adds all the numbers of `other` (Chan et al., *Updating Formulae and a Pairwise Algorithm for
    /// Computing Sample Variances*, 1979).
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

    /// Number of numbers added.
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The mean; `None` before the first number.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.mean)
    }

    /// The unbiased variance of one number; `None` for fewer than two.
    pub fn variance(&self) -> Option<f64> {
        (self.count > 1).then(|| self.sum_of_squared_deviations / (self.count - 1) as f64)
    }

    /// The standard error of the mean, for independent numbers; `None` for fewer than two.
    pub fn standard_error(&self) -> Option<f64> {
        self.variance()
            .map(|variance| (variance / self.count as f64).sqrt())
    }
}

impl Extend<f64> for SampleMoments {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, values: I) {
        values.into_iter().for_each(|value| self.add(value));
    }
}

impl FromIterator<f64> for SampleMoments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Self::new();
        moments.extend(values);
        moments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_definition_however_they_are_grouped() {
        let values = [4.0, 7.0, 13.0, 16.0];
        let all: SampleMoments = values.into_iter().collect();
        assert_eq!(all.mean(), Some(10.0));
        assert_eq!(all.variance(), Some(30.0));
        assert_eq!(all.standard_error(), Some(7.5f64.sqrt()));
        for split in 0..=4 {
            let mut merged: SampleMoments = values[..split].iter().copied().collect();
            merged.merge(&values[split..].iter().copied().collect());
            assert_eq!(merged.count(), 4);
            // A few operations on numbers below 100.
            assert!((merged.mean().unwrap() - 10.0).abs() <= 8.0 * f64::EPSILON * 10.0);
            assert!((merged.variance().unwrap() - 30.0).abs() <= 8.0 * f64::EPSILON * 100.0);
        }
    }

    #[test]
    fn a_large_mean_does_not_eat_a_small_variance() {
        // The textbook formula Σx² − n x̄² gives garbage here: ε (10⁹)² is 200.
        let moments: SampleMoments = [4.0, 7.0, 13.0, 16.0]
            .map(|x| x + 1e9)
            .into_iter()
            .collect();
        assert_eq!(moments.variance(), Some(30.0));
    }

    #[test]
    fn too_few_numbers_have_no_moments() {
        let mut moments = SampleMoments::new();
        assert_eq!(moments.mean(), None);
        moments.add(3.0);
        assert_eq!((moments.mean(), moments.variance()), (Some(3.0), None));
    }
}
