//! Choosing one of many, each with its own probability.

/// A distribution over indices, with probabilities in proportion to given weights.
///
/// It inverts the cumulative sum: neighbours in `u` stay neighbours, so that points that cover [0, 1) evenly
/// also cover the indices evenly.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedChoice {
    /// The sum of the weights up to and including each one.
    cumulative: Vec<f64>,
    /// For each of as many equal parts of the total: the first index whose sum is in that part or beyond.
    /// There is one more part at the end.
    first_of_part: Vec<u32>,
    /// Parts by weight.
    parts: f64,
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
        if !sum.is_finite() || sum <= 0.0 {
            return None;
        }
        let count = cumulative.len();
        let mut choice = Self {
            cumulative,
            first_of_part: Vec::with_capacity(count + 2),
            parts: count as f64 / sum,
        };
        for (index, &sum) in choice.cumulative.iter().enumerate() {
            let beyond = choice.part(sum) + 1;
            if choice.first_of_part.len() < beyond {
                choice.first_of_part.resize(beyond, index as u32);
            }
        }
        // Every number below the total is in a part that begins before these.
        choice.first_of_part.resize(count + 2, count as u32 - 1);
        Some(choice)
    }

    /// The part of the total in which a sum is. It never falls where the sum grows, whatever is rounded.
    #[inline]
    fn part(&self, sum: f64) -> usize {
        ((sum * self.parts) as usize).min(self.cumulative.len())
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
        // Sums in earlier parts are smaller than what is wanted, and the first in a later part is larger.
        let part = self.part(wanted);
        let [first, last] = [part, part + 1].map(|part| self.first_of_part[part] as usize);
        let among = &self.cumulative[first..=last];
        let index = first + among.partition_point(|sum| *sum <= wanted);
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
    fn the_parts_of_the_total_find_what_a_search_of_all_finds() {
        let mut weights = vec![1.0, 0.0, 0.0, 1e-9, 7.0, 1e-300];
        weights.extend((0..500).map(|k| f64::from(k * k % 97) * if k < 250 { 1.0 } else { 1e-6 }));
        weights.extend([0.0, 0.0]);
        for weights in [
            weights,
            vec![3.0],
            vec![0.0, 5e-324],
            vec![1e300, 1.0, 1e300],
        ] {
            let choice = WeightedChoice::new(weights.iter().copied()).unwrap();
            let total = choice.total();
            let near = choice.cumulative.iter().flat_map(|sum| {
                let u = sum / total;
                [u.next_down(), u, u.next_up()]
            });
            let even = (0..10_000).map(|step| f64::from(step) / 10_000.0);
            for u in even.chain(near).filter(|u| (0.0..1.0).contains(u)) {
                let wanted = (u * total).min(total.next_down());
                let expected = choice.cumulative.partition_point(|sum| *sum <= wanted);
                assert_eq!(choice.choose(u).index, expected, "{u}");
            }
        }
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
