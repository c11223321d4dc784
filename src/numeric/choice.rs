//! Choosing one of many, each with its own probability.

/// A distribution over indices, with probabilities in proportion to given weights.
///
/// It inverts the cumulative sum: neighbours in `u` stay neighbours, so that points that cover [0, 1) evenly
/// also cover the indices evenly.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedChoice {
    /// The sum of the weights up to and including each one.
    cumulative: Vec<f64>,
}

/// One index chosen at random, and the randomness left over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selection {
    /// The index.
    pub index: usize,
    /// A number in [0, 1), uniform for every index, so that `u` can be used once more.
    pub rest: f64,
}

impl WeightedChoice {
    /// The distribution over as many indices as there are `weights`. `None` if a weight is negative or not
    /// finite, or if their sum is not a positive finite number.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sum = 0.0;
        let cumulative: Vec<f64> = weights
            .into_iter()
            .map(|weight| {
                // A negative weight would make the sums fall: NaN spoils all that follow.
                sum += if weight >= 0.0 { weight } else { f64::NAN };
                sum
            })
            .collect();
        (sum.is_finite() && sum > 0.0).then_some(Self { cumulative })
    }

    /// The sum of the weights.
    #[inline]
    pub fn total(&self) -> f64 {
        // `new` refuses to choose among nothing.
        self.cumulative[self.cumulative.len() - 1]
    }

    /// The index chosen by `u` in [0, 1); never one of weight zero.
    #[inline]
    pub fn choose(&self, u: f64) -> Selection {
        let total = self.total();
        let wanted = (u * total).min(total.next_down());
        let index = self.cumulative.partition_point(|sum| *sum <= wanted);
        let before = self.before(index);
        let rest = (wanted - before) / (self.cumulative[index] - before);
        Selection {
            index,
            rest: rest.min(1.0f64.next_down()),
        }
    }

    /// The probability of an index; 0 for one that does not exist.
    #[inline]
    pub fn probability(&self, index: usize) -> f64 {
        self.cumulative
            .get(index)
            .map_or(0.0, |sum| (sum - self.before(index)) / self.total())
    }

    /// The probability of all indices below `index` together, at most as many as there are.
    #[inline]
    pub fn below(&self, index: usize) -> f64 {
        self.before(index) / self.total()
    }

    #[inline]
    fn before(&self, index: usize) -> f64 {
        if index == 0 {
            0.0
        } else {
            self.cumulative[index - 1]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_index_owns_an_interval_as_long_as_its_probability() {
        let choice = WeightedChoice::new([1.0, 0.0, 2.0, 5.0, 0.0]).unwrap();
        // Eighths are exact.
        let owned = [1, 0, 2, 5, 0];
        for (index, eighths) in owned.into_iter().enumerate() {
            assert_eq!(choice.probability(index), f64::from(eighths) / 8.0);
            let steps = (0..64)
                .filter(|step| choice.choose(f64::from(*step) / 64.0).index == index)
                .count();
            assert_eq!(steps, 8 * eighths as usize);
        }
        assert_eq!(choice.probability(5), 0.0);
    }

    #[test]
    fn the_rest_runs_from_0_to_1_across_each_interval() {
        let choice = WeightedChoice::new([1.0, 3.0]).unwrap();
        for (u, index, rest) in [
            (0.0, 0, 0.0),
            (0.125, 0, 0.5),
            (0.25, 1, 0.0),
            (0.625, 1, 0.5),
        ] {
            assert_eq!(choice.choose(u), Selection { index, rest });
        }
        assert!(choice.choose(1.0f64.next_down()).rest < 1.0);
        // Out of range is not out of bounds.
        assert_eq!(choice.choose(1.0).index, 1);
    }

    #[test]
    fn nothing_to_choose_from_is_none() {
        assert_eq!(WeightedChoice::new([]), None);
        assert_eq!(WeightedChoice::new([0.0, 0.0]), None);
        assert_eq!(WeightedChoice::new([1.0, -1.0, 3.0]), None);
        assert_eq!(WeightedChoice::new([f64::NAN, 1.0]), None);
        assert_eq!(WeightedChoice::new([f64::INFINITY]), None);
        assert_eq!(WeightedChoice::new([f64::MAX, f64::MAX]), None);
    }
}
