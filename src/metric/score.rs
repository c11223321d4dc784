//! The distance of two values, measured by their error bars.

use super::bars::Bars;
use super::pair::TestPair;
use crate::numeric::distributions::student_t_cdf;
use crate::numeric::math;

/// Half a unit in the last place of an `f32`, relative: the change that storing a value may make.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// Degrees of freedom from which Hill's expansion is good to 4e-7 in the probability.
const EXPANSION_FROM: f64 = 5.0;

/// A difference and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// The other value less the reference; with bounds, the distance between the intervals.
    pub excess: f64,
    /// Its standard error σ, rounding of stored values included.
    pub standard_error: f64,
    /// Degrees of freedom of σ.
    pub freedom: f64,
    /// True if few samples arrived: bounds by them were taken, and σ is large. It has no distribution.
    pub of_few: bool,
}

impl TestPair<'_> {
    /// True if either image has bounds here.
    pub fn has_bounds(&self) -> bool {
        self.reference.bounds.is_some() || self.other.bounds.is_some()
    }

    /// The parts of Welch's statistic of a texel:
    ///
    /// ```text
    /// z = (o − r) / √(σ_o² + σ_r²),      ν = (σ_o² + σ_r²)² / (σ_o⁴/ν_o + σ_r⁴/ν_r)
    /// ```
    ///
    /// (Welch 1947; Satterthwaite 1946). A value with bounds is all of lo..=hi at once: o − r is then the
    /// distance between the intervals, zero if they overlap. An image without any error bars counts as exact.
    ///
    /// A value of few samples is all between its bounds by them ([`Bars::sampling`]), if there are any. Their
    /// half distance then stands for σ: beyond it, tails are longer than normal ones.
    ///
    /// `None` if an image has standard errors, but zero at this texel and no bounds. A texel that no sample
    /// reached has 0 ± 0, which means that nothing is known.
    pub fn score(&self, texel: usize) -> Option<Score> {
        let sides = [&self.reference, &self.other];
        let few = sides.map(|bars| bars.few(texel));
        let is_known = |bars: &Bars| {
            bars.bounds.is_some() || bars.standard_errors.is_none() || bars.variance(texel) > 0.0
        };
        let mut known = sides.into_iter().zip(&few);
        if !known.all(|(bars, few)| few.is_some() || is_known(bars)) {
            return None;
        }
        if few.iter().any(Option::is_some) {
            return Some(self.score_of_few(texel, few));
        }
        let (excess, rounding) = self.excess(texel);
        let [own, others] = [&self.reference, &self.other].map(|bars| bars.variance(texel));
        let variance = own + others;
        let spread = own * own / self.reference.freedom + others * others / self.other.freedom;
        Some(Score {
            excess,
            standard_error: (variance + rounding).sqrt(),
            freedom: if spread > 0.0 {
                variance * variance / spread
            } else {
                f64::INFINITY
            },
            of_few: false,
        })
    }

    /// The score where few samples arrived in an image, or in both.
    fn score_of_few(&self, texel: usize, few: [Option<[f64; 2]>; 2]) -> Score {
        let sides = [&self.reference, &self.other];
        let ends: [[f64; 2]; 2] =
            std::array::from_fn(|i| few[i].unwrap_or_else(|| sides[i].interval(texel)));
        let variances: [f64; 2] = std::array::from_fn(|i| {
            few[i].map_or_else(
                || sides[i].variance(texel),
                |[low, high]| 0.25 * (high - low) * (high - low),
            )
        });
        let (excess, rounding) = distance(ends[0], ends[1]);
        Score {
            excess,
            standard_error: (variances[0] + variances[1] + rounding).sqrt(),
            freedom: f64::INFINITY,
            of_few: true,
        }
    }

    /// An estimate of a texel's squared true difference, and of that estimate's variance.
    ///
    /// For the distance e of [`TestPair::score`] and its variance σ², the estimate is e² − σ². As a sample
    /// variance is, it is right in the mean over texels, those with a standard error of zero included. For
    /// normal errors its variance is 2 σ⁴ + 4 μ² σ² about the true difference μ, and 2 σᵢ⁴/νᵢ for the
    /// uncertainty of σ. With e² − σ² for μ²,
    ///
    /// ```text
    /// Var = 4 e² σ² − 2 σ⁴ + 2 (σ_o⁴/ν_o + σ_r⁴/ν_r).
    /// ```
    ///
    /// With bounds, a texel whose intervals overlap adds nothing. The estimate is then at most right in the
    /// mean, and right if the truth is at the end of the interval.
    pub fn unexplained(&self, texel: usize) -> [f64; 2] {
        let (excess, rounding) = self.excess(texel);
        if excess == 0.0 && self.has_bounds() {
            return [0.0; 2];
        }
        let [own, others] = [&self.reference, &self.other].map(|bars| bars.variance(texel));
        let variance = own + others;
        let square = excess * excess;
        let spread = own * own / self.reference.freedom + others * others / self.other.freedom;
        [
            square - variance - rounding,
            variance * (4.0 * square - 2.0 * variance) + 2.0 * spread,
        ]
    }

    /// The signed distance between the intervals, and the variance that storing their ends may have added.
    fn excess(&self, texel: usize) -> (f64, f64) {
        distance(self.reference.interval(texel), self.other.interval(texel))
    }

    /// True if the texel's values differ at all.
    pub fn differs(&self, texel: usize) -> bool {
        self.reference.values[texel] != self.other.values[texel]
    }
}

/// The signed distance between two intervals, and the variance that storing their ends may have added.
fn distance([low, high]: [f64; 2], [other_low, other_high]: [f64; 2]) -> (f64, f64) {
    let (other, own) = if other_low > high {
        (other_low, high)
    } else if other_high < low {
        (other_high, low)
    } else {
        return (0.0, 0.0);
    };
    (
        other - own,
        ROUNDING * ROUNDING * (other * other + own * own),
    )
}

impl Score {
    /// The distance in standard errors; zero if there is no distance.
    pub fn z(&self) -> f64 {
        if self.excess == 0.0 {
            0.0
        } else {
            self.excess / self.standard_error
        }
    }

    /// The probability of a |z| at least as large if there is no true difference.
    pub fn p(&self) -> f64 {
        (2.0 * student_t_cdf(-self.z().abs(), self.freedom)).min(1.0)
    }

    /// The |z| that is as unlikely for a normal variable as this one is for Student's t.
    ///
    /// It is Hill's expansion (*Comm. ACM* 13(10), 1970, algorithm 395), which takes much less time than the
    /// t distribution itself. The probability it gives is off by less than 4e-7, and by less than 6e-4 of
    /// itself up to |t| = 12.
    ///
    /// `None` below five degrees of freedom, for which the expansion is worse.
    pub fn normal_score(&self) -> Option<f64> {
        let (t, nu) = (self.z().abs(), self.freedom);
        if nu == f64::INFINITY {
            return Some(t);
        }
        if nu < EXPANSION_FROM {
            return None;
        }
        let a = nu - 0.5;
        let b = 48.0 * a * a;
        let square = a * math::ln_1p(t * t / nu);
        let w = square.sqrt();
        let fourth = ((4.0 * square + 33.0) * square + 240.0) * square + 855.0;
        let correction =
            (square + 3.0) / b - fourth / (10.0 * b * (b + 0.8 * square * square + 100.0));
        Some(w * (1.0 + correction))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::distributions::normal_cdf;

    #[test]
    fn hills_expansion_is_students_distribution_to_the_accuracy_claimed() {
        for freedom in [5.0, 7.5, 15.0, 31.0, 62.0, 500.0] {
            for step in 1..=240 {
                let score = Score {
                    excess: 0.05 * f64::from(step),
                    standard_error: 1.0,
                    freedom,
                    of_few: false,
                };
                let fast = 2.0 * normal_cdf(-score.normal_score().unwrap());
                let exact = score.p();
                assert!((fast - exact).abs() < 4e-7, "{score:?}: {fast} {exact}");
                assert!(
                    (fast / exact - 1.0).abs() < 6e-4,
                    "{score:?}: {fast} {exact}"
                );
            }
        }
    }

    fn exact(value: f32) -> Bars<'static> {
        Bars {
            values: vec![value].into(),
            standard_errors: None,
            bounds: None,
            sampling: None,
            freedom: f64::INFINITY,
        }
    }

    #[test]
    fn welch_and_satterthwaite_as_in_the_formulas() {
        let with = |value: f32, error: f32, freedom| Bars {
            standard_errors: Some(vec![error].into()),
            freedom,
            ..exact(value)
        };
        let pair = TestPair {
            name: "R".to_owned(),
            reference: with(10.0, 3.0, 7.0),
            other: with(20.0, 4.0, 15.0),
        };
        let score = pair.score(0).unwrap();
        // Rounding adds some 1e-13 to 25.
        assert!((score.z() - 2.0).abs() < 1e-12);
        let expected = 25.0 * 25.0 / (81.0 / 7.0 + 256.0 / 15.0);
        assert!((score.freedom / expected - 1.0).abs() < 1e-12);
    }

    /// The score of a pair of one texel.
    fn score(reference: Bars, other: Bars) -> Option<Score> {
        let pair = TestPair {
            name: "R".to_owned(),
            reference,
            other,
        };
        pair.score(0)
    }

    #[test]
    fn bounds_that_overlap_are_no_distance_and_a_gap_counts_from_end_to_end() {
        let between = |low: f32, high: f32| Bars {
            bounds: Some([vec![low].into(), vec![high].into()]),
            ..exact(0.5 * (low + high))
        };
        let z = |reference, other| score(reference, other).map(|score| (score.excess, score.z()));
        assert_eq!(z(between(1.0, 3.0), between(3.0, 5.0)), Some((0.0, 0.0)));
        assert_eq!(z(between(1.0, 3.0), exact(2.0)), Some((0.0, 0.0)));
        assert_eq!(z(between(3.0, 4.0), exact(2.0)).unwrap().0, -1.0);
        let noisy = Bars {
            standard_errors: Some(vec![0.5].into()),
            ..exact(5.0)
        };
        let (excess, score) = z(between(1.0, 4.0), noisy).unwrap();
        assert_eq!(excess, 1.0);
        assert!((score - 2.0).abs() < 1e-9);
        // A texel that no sample reached: nothing is known of it.
        let unreached = Bars {
            standard_errors: Some(vec![0.0].into()),
            ..exact(0.0)
        };
        assert_eq!(z(between(1.0, 4.0), unreached.clone()), None);
        assert_eq!(z(unreached, exact(2.0)), None);
    }

    #[test]
    fn bounds_by_samples_stand_in_for_standard_errors_where_few_samples_arrived() {
        let sampled = |value: f32, error: f32| Bars {
            standard_errors: Some(vec![error].into()),
            sampling: Some([vec![0.5 * value].into(), vec![value + 4.0].into()]),
            ..exact(value)
        };
        let score = |reference, other| score(reference, other).unwrap();
        // No sample at all: bounds 0 to 4, whose half distance is 2.
        let dark = score(sampled(0.0, 0.0), exact(3.0));
        assert!(dark.of_few && dark.z() == 0.0);
        let far = score(sampled(0.0, 0.0), exact(10.0));
        assert!(far.of_few && (far.z() - 3.0).abs() < 1e-9, "{far:?}");
        // 99 effective samples, and 101.
        let few = score(sampled(10.0, 10.0 / 99_f32.sqrt()), exact(16.0));
        let many = score(sampled(10.0, 10.0 / 101_f32.sqrt()), exact(16.0));
        assert!(few.of_few && few.excess == 2.0, "{few:?}");
        assert!(!many.of_few && many.excess == 6.0, "{many:?}");
    }
}
