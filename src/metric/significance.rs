//! Tests if the difference is more than the error bars explain.
//!
//! There is one test for each texel and channel ([`super::score`]). Under the hypothesis that both images
//! have the same expectation and honest bars, their p-values are uniform on 0..1. The smallest of n of them
//! is then below 1 − (1 − α)^(1/n) with probability α (Šidák 1967), at most if they are correlated.

use serde::Serialize;

use super::pair::{LayerPair, TestPair};
use super::score::Score;
use super::sums::parts;
use crate::numeric::distributions::{chi_squared_survival, normal_cdf};
use crate::numeric::math;

/// Bins of the histogram of p-values.
pub const BINS: usize = 20;

/// The fewest p-values that a bin must expect for the χ² distribution to hold (Cochran 1954).
const LEAST_PER_BIN: f64 = 5.0;

/// The tests of a layer's differences against the error bars.
///
/// # Example: differences in standard errors
///
/// ```
/// # use nephroid::{CompareImage, CompareSettings, Image, compare};
/// # let grey = |value: f64| {
/// #     let mut image = Image::new(16, 16);
/// #     image.add_rgb("E", &[[value; 3]; 256]);
/// #     image.add_rgb("E.stderr", &[[0.001; 3]; 256]);
/// #     CompareImage::new(format!("{value}.exr"), image)
/// # };
/// # let (truth, mine) = (grey(1.0), grey(1.02));
/// # let comparison = compare(&truth, &mine, &CompareSettings::default())?;
/// let significance = comparison.layers[0].significance.as_ref().unwrap();
/// assert_eq!(significance.tests, 256, "equal channels count once");
/// assert!(significance.mean_z.abs() > 10.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Significance {
    /// Number of tests: texels times channels with an error bar.
    pub tests: u64,
    /// Number of texels times channels that differ, but have a standard error of 0 in an image, as if no
    /// sample arrived. They are not tested.
    #[doc(hidden)]
    pub untested: u64,
    /// Number of texels times channels where few samples arrived, with bounds by them. They take part in the
    /// test of all, and not in the means and the histogram: they have no distribution.
    #[doc(hidden)]
    pub few: u64,
    /// Mean of z: 0 if the images agree.
    pub mean_z: f64,
    /// Mean of z²: ν / (ν − 2) if the images agree and bars are right. A larger mean: bars too small or
    /// images different. A smaller one: bars too large, or errors of the two images that are not independent.
    pub mean_square_z: f64,
    /// The test with the smallest p-value.
    #[doc(hidden)]
    pub extreme: Option<Extreme>,
    /// Number of p-values in each of [`BINS`] equal parts of 0..1.
    #[doc(hidden)]
    pub histogram: [u64; BINS],
    /// The test for uniform p-values. `None` with too few tests, and with bounds: these are no distribution,
    /// and p-values are then too large by design.
    #[doc(hidden)]
    pub uniformity: Option<Uniformity>,
    /// The test that no texel differs, all tests taken together.
    pub family: JointTest,
    /// True if bounds took part.
    #[doc(hidden)]
    pub has_bounds: bool,
}

/// The texel that is hardest to explain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Extreme {
    /// Column in the file.
    pub x: usize,
    /// Row in the file.
    pub y: usize,
    /// The channel.
    pub channel: String,
    /// The difference in standard errors.
    pub z: f64,
    /// Degrees of freedom; `None` for infinitely many.
    pub freedom: Option<f64>,
    /// Two-sided p-value.
    pub p: f64,
}

/// Pearson's χ² test of the histogram against equal bins, channel by channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Uniformity {
    /// The largest χ² of a channel.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub freedom: usize,
    /// The probability of a χ² so large in any of the channels (Šidák), for independent texels.
    pub p: f64,
    /// True if `p` is at least the significance level.
    pub uniform: bool,
}

/// All tests of a layer as one.
///
/// # Example: noise or not
///
/// ```
/// # use nephroid::{CompareImage, CompareSettings, Image, compare};
/// # let grey = |value: f64| {
/// #     let mut image = Image::new(16, 16);
/// #     image.add_rgb("E", &[[value; 3]; 256]);
/// #     image.add_rgb("E.stderr", &[[0.001; 3]; 256]);
/// #     CompareImage::new(format!("{value}.exr"), image)
/// # };
/// # let (truth, mine) = (grey(1.0), grey(1.02));
/// # let comparison = compare(&truth, &mine, &CompareSettings::default())?;
/// let significance = comparison.layers[0].significance.as_ref().unwrap();
/// assert!(significance.family.different, "a texel differs by more than noise");
/// assert!(significance.family.p < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JointTest {
    /// The significance level α: the probability that equal images are called different.
    #[doc(hidden)]
    pub level: f64,
    /// 1 − (1 − α)^(1/n): a p-value below it decides.
    #[doc(hidden)]
    pub threshold: f64,
    /// 1 − (1 − p)^n of the smallest p-value.
    pub p: f64,
    /// True if a texel differs significantly.
    pub different: bool,
}

/// Counts and sums over a range of texels.
#[derive(Clone)]
struct Counts {
    tests: u64,
    untested: u64,
    few: u64,
    z: f64,
    squares: f64,
    histogram: [u64; BINS],
    extreme: Option<ExtremeCandidate>,
}

/// A candidate for the smallest p-value.
#[derive(Clone, Copy)]
struct ExtremeCandidate {
    texel: usize,
    p: f64,
    z: f64,
}

impl ExtremeCandidate {
    /// True if this p-value is smaller; if both are too small for a number, true if |z| is larger.
    fn beats(self, other: Self) -> bool {
        self.p < other.p || (self.p == other.p && self.z.abs() > other.z.abs())
    }
}

impl Significance {
    /// The tests of a layer at significance level `level`; `None` if no image has error bars.
    pub(crate) fn of(pair: &LayerPair, level: f64) -> Option<Self> {
        if pair.tests.is_empty() {
            return None;
        }
        let channels: Vec<Counts> = pair
            .tests
            .iter()
            .map(|test| count(test, pair.texels()))
            .collect();
        let has_bounds = pair.tests.iter().any(TestPair::has_bounds);
        let total = channels.iter().fold(Counts::new(), Counts::merged);
        let tests = total.tests as f64;
        let all = (total.tests + total.few) as f64;
        let extreme = pair
            .tests
            .iter()
            .zip(&channels)
            .filter_map(|(test, counts)| extreme(pair, test, counts))
            .min_by(|one, other| one.p.total_cmp(&other.p));
        Some(Self {
            tests: total.tests,
            untested: total.untested,
            few: total.few,
            mean_z: mean(total.z, tests),
            mean_square_z: mean(total.squares, tests),
            histogram: total.histogram,
            uniformity: if has_bounds {
                None
            } else {
                uniformity(&channels, level)
            },
            family: family(extreme.as_ref().map_or(1.0, |it| it.p), all, level),
            extreme,
            has_bounds,
        })
    }
}

fn mean(sum: f64, count: f64) -> f64 {
    if count > 0.0 { sum / count } else { 0.0 }
}

/// 1 − (1 − p)^n: the probability that the smallest of n uniform numbers is at most p.
fn sidak(p: f64, n: f64) -> f64 {
    if n > 0.0 {
        -math::exp_m1(n * math::ln_1p(-p))
    } else {
        1.0
    }
}

fn family(smallest: f64, tests: f64, level: f64) -> JointTest {
    JointTest {
        level,
        threshold: if tests > 0.0 {
            -math::exp_m1(math::ln_1p(-level) / tests)
        } else {
            0.0
        },
        p: sidak(smallest, tests),
        different: tests > 0.0 && sidak(smallest, tests) < level,
    }
}

fn uniformity(channels: &[Counts], level: f64) -> Option<Uniformity> {
    let freedom = BINS - 1;
    let largest = channels
        .iter()
        .filter_map(|counts| {
            let expected = counts.tests as f64 / BINS as f64;
            let square = |&found: &u64| (found as f64 - expected) * (found as f64 - expected);
            let sum: f64 = counts.histogram.iter().map(square).sum();
            (expected >= LEAST_PER_BIN).then_some(sum / expected)
        })
        .reduce(f64::max)?;
    let p = sidak(
        chi_squared_survival(largest, freedom as f64),
        channels.len() as f64,
    );
    Some(Uniformity {
        chi_squared: largest,
        freedom,
        p,
        uniform: p >= level,
    })
}

fn extreme(pair: &LayerPair, test: &TestPair, counts: &Counts) -> Option<Extreme> {
    let ExtremeCandidate { texel, .. } = counts.extreme?;
    let score = test.score(texel)?;
    let [x, y] = pair.place(texel);
    Some(Extreme {
        x,
        y,
        channel: test.name.clone(),
        z: score.z(),
        freedom: score.freedom.is_finite().then_some(score.freedom),
        p: score.p(),
    })
}

/// The tests of one channel.
fn count(test: &TestPair, texels: usize) -> Counts {
    parts(texels, |range| {
        let mut counts = Counts::new();
        for texel in range {
            match test.score(texel) {
                Some(score) => counts.add(texel, &score),
                None if test.differs(texel) => counts.untested += 1,
                None => {}
            }
        }
        counts
    })
    .iter()
    .fold(Counts::new(), Counts::merged)
}

impl Counts {
    const fn new() -> Self {
        Self {
            tests: 0,
            untested: 0,
            few: 0,
            z: 0.0,
            squares: 0.0,
            histogram: [0; BINS],
            extreme: None,
        }
    }

    fn add(&mut self, texel: usize, score: &Score) {
        let z = score.z();
        let p = score
            .normal_score()
            .map_or_else(|| score.p(), |normal| 2.0 * normal_cdf(-normal));
        if score.of_few {
            self.few += 1;
        } else {
            self.tests += 1;
            self.z += z;
            self.squares += z * z;
            let bin = (p * BINS as f64) as usize;
            self.histogram[bin.min(BINS - 1)] += 1;
        }
        let candidate = ExtremeCandidate { texel, p, z };
        if self.extreme.is_none_or(|extreme| candidate.beats(extreme)) {
            self.extreme = Some(candidate);
        }
    }

    /// Both together; `self` comes first.
    fn merged(mut self, other: &Self) -> Self {
        self.tests += other.tests;
        self.untested += other.untested;
        self.few += other.few;
        self.z += other.z;
        self.squares += other.squares;
        for (bin, count) in self.histogram.iter_mut().zip(other.histogram) {
            *bin += count;
        }
        self.extreme = match (self.extreme, other.extreme) {
            (Some(one), Some(other)) if other.beats(one) => Some(other),
            (one, other) => one.or(other),
        };
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_family_threshold_is_the_p_that_the_family_p_of_is_the_level() {
        for tests in [1.0, 100.0, 1e9] {
            let threshold = family(1.0, tests, 0.05).threshold;
            // Two rounded functions near the identity.
            assert!((sidak(threshold, tests) / 0.05 - 1.0).abs() < 1e-14 * 100.0);
            assert!(family(0.99 * threshold, tests, 0.05).different);
            assert!(!family(1.01 * threshold, tests, 0.05).different);
        }
        assert!(!family(1.0, 0.0, 0.05).different);
    }
}
