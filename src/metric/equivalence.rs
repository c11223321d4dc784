//! Equivalence of two images within a margin.
//!
//! A test that finds no difference does not show that there is none. Two one-sided tests (TOST; Schuirmann
//! 1987) do. An image is *equivalent* if a difference as large as the margin is refuted, *different* if a
//! difference within the margin is refuted, else *undecided*.

use serde::Serialize;

use super::difference::Difference;
use super::pair::LayerPair;
use super::sums::{square_sums, sums};
use crate::numeric::distributions::{critical_value, student_t_cdf};

/// The verdict on a difference and a margin.
///
/// # Example: a condition of a test
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
/// use nephroid::Verdict;
///
/// let verdict = comparison.verdict;
/// assert!(verdict != Verdict::Equivalent, "2 % apart at a margin of 1 %");
/// assert!(Verdict::Equivalent < Verdict::Different, "the worse is the larger");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The same within the margin.
    Equivalent,
    /// Too uncertain to tell.
    Undecided,
    /// More than the margin apart.
    Different,
}

impl Verdict {
    /// Its name.
    ///
    /// # Example: a line of a report
    ///
    /// ```
    /// assert_eq!(nephroid::Verdict::Equivalent.name(), "equivalent");
    /// ```
    pub const fn name(self) -> &'static str {
        match self {
            Self::Equivalent => "equivalent",
            Self::Undecided => "undecided",
            Self::Different => "different",
        }
    }
}

/// A layer's verdicts at a margin.
///
/// # Example: means and texels
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
/// let equivalence = &comparison.layers[0].equivalence;
/// let worse = equivalence.bias.verdict.max(equivalence.texels.verdict);
/// assert_eq!(equivalence.verdict, worse);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Equivalence {
    /// The margin, as a fraction of the reference's mean.
    #[doc(hidden)]
    pub margin: f64,
    /// The significance level of each one-sided test.
    #[doc(hidden)]
    pub level: f64,
    /// The verdict on the mean.
    pub bias: MeanEquivalence,
    /// The verdict on the texels.
    pub texels: TexelEquivalence,
    /// The worse of both.
    pub verdict: Verdict,
}

/// The difference of the means. Relative figures are `None` if the reference is dark.
///
/// # Example: a bias with its interval
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
/// let bias = &comparison.layers[0].equivalence.bias;
/// let [low, high] = bias.interval.unwrap();
/// assert!(0.0199 < low && high < 0.0201, "2 %, and the same everywhere");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeanEquivalence {
    /// Mean of the other image less that of the reference, in the image's unit.
    pub bias: f64,
    /// `bias` over the reference's mean.
    pub relative: Option<f64>,
    /// Standard error of `relative`; `None` with fewer than two squares.
    #[doc(hidden)]
    pub standard_error: Option<f64>,
    /// Its degrees of freedom: squares less one.
    #[doc(hidden)]
    pub freedom: usize,
    /// Texels a side of the squares that its scatter is taken over.
    #[doc(hidden)]
    pub square: usize,
    /// The interval that covers the true `relative` with probability 1 − α.
    pub interval: Option<[f64; 2]>,
    /// The larger p-value of the two one-sided tests: below α shows equivalence.
    pub p: Option<f64>,
    /// The verdict of both tests.
    pub verdict: Verdict,
}

/// The difference of texels, beyond what the bars explain.
///
/// # Example: the difference that noise does not explain
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
/// let texels = &comparison.layers[0].equivalence.texels;
/// assert!((texels.unexplained.unwrap() - 0.02).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TexelEquivalence {
    /// √(Σ (e² − σ²) / Σ r²), zero if the sum is negative: the length of the difference, noise taken off,
    /// over the length of the reference. σ² is the variance of e; without error bars it is 0. `None` if the
    /// reference is dark and the other image is not.
    pub unexplained: Option<f64>,
    /// One-sided lower and upper bounds of `unexplained`, each with confidence 1 − α; `None` without bars.
    pub interval: Option<[f64; 2]>,
    /// True if there were bars to take off.
    #[doc(hidden)]
    pub has_bars: bool,
    /// The verdict by the interval; without bars, by `unexplained` itself.
    pub verdict: Verdict,
}

/// Sides of squares tried, largest first.
const SIDES: [usize; 4] = [8, 4, 2, 1];

/// Number of squares that makes a good standard error: its own error is then below 1/√(2·63) = 9 %.
const ENOUGH: usize = 64;

/// The side of squares for an image: the largest that gives enough squares.
///
/// Texels near each other often err together (reconstruction filters, photons shared); squares that hold such
/// neighbours do so less.
fn side(pair: &LayerPair) -> usize {
    let squares = |side: usize| pair.width.div_ceil(side) * pair.height.div_ceil(side);
    SIDES
        .into_iter()
        .find(|side| squares(*side) >= ENOUGH)
        .unwrap_or(1)
}

impl Equivalence {
    /// The verdicts of a layer at `margin`, each test at significance level `level`.
    pub(crate) fn of(pair: &LayerPair, difference: &Difference, margin: f64, level: f64) -> Self {
        let bias = MeanEquivalence::of(pair, difference, margin, level);
        let texels = TexelEquivalence::of(pair, difference, margin, level);
        Self {
            margin,
            level,
            verdict: bias.verdict.max(texels.verdict),
            bias,
            texels,
        }
    }
}

impl MeanEquivalence {
    /// The ratio estimator of Σ d / Σ r over squares. A factor common to all texels has no scatter, and
    /// errors that both images share cancel.
    fn of(pair: &LayerPair, difference: &Difference, margin: f64, level: f64) -> Self {
        let side = side(pair);
        let squares = square_sums([pair.width, pair.height], side, |texel| {
            pair.channels.iter().fold([0.0; 2], |[d, r], one| {
                let (reference, other) =
                    (f64::from(one.reference[texel]), f64::from(one.other[texel]));
                [d + (other - reference), r + reference]
            })
        });
        let ratio = Ratio::of(&squares);
        let samples = (pair.texels() * pair.channels.len()) as f64;
        let mut bias = Self {
            bias: ratio.numerator / samples,
            relative: None,
            standard_error: None,
            freedom: squares.len() - 1,
            square: side,
            interval: None,
            p: None,
            verdict: if difference.rmse == 0.0 {
                Verdict::Equivalent
            } else {
                Verdict::Undecided
            },
        };
        if ratio.denominator <= 0.0 {
            return bias;
        }
        let relative = ratio.value();
        bias.relative = Some(relative);
        let Some(standard_error) = ratio.standard_error else {
            return bias;
        };
        let freedom = bias.freedom as f64;
        let reach = critical_value(1.0 - level, freedom) * standard_error;
        // P(T >= t) for the distance of the estimate above a limit.
        let above = |limit: f64| tail(relative - limit, standard_error, freedom);
        let below = |limit: f64| tail(limit - relative, standard_error, freedom);
        let p = above(-margin).max(below(margin));
        bias.standard_error = Some(standard_error);
        bias.interval = Some([relative - reach, relative + reach]);
        bias.p = Some(p);
        bias.verdict = if p < level {
            Verdict::Equivalent
        } else if above(margin).min(below(-margin)) < level {
            Verdict::Different
        } else {
            Verdict::Undecided
        };
        bias
    }
}

impl TexelEquivalence {
    /// The verdict on a layer's texels.
    ///
    /// The interval is that of a normal number whose variance is the sum of the texels' variances
    /// ([`super::pair::TestPair::unexplained`]). Errors of different texels count as independent. Errors of a
    /// texel's channels count as one and the same, which makes the variance of C channels C times the sum of
    /// theirs.
    fn of(pair: &LayerPair, difference: &Difference, margin: f64, level: f64) -> Self {
        let has_bars = !pair.tests.is_empty();
        let mut texels = Self {
            unexplained: None,
            interval: None,
            has_bars,
            verdict: if has_bars {
                Verdict::Undecided
            } else {
                Verdict::Different
            },
        };
        // Equal images are equivalent in spite of all noise they share.
        if difference.rmse == 0.0 {
            texels.unexplained = Some(0.0);
            texels.verdict = Verdict::Equivalent;
            return texels;
        }
        let [unexplained, variance, light] = if has_bars {
            with_bars(pair)
        } else {
            without_bars(pair)
        };
        if light <= 0.0 {
            return texels;
        }
        let relative = |square: f64| (square.max(0.0) / light).sqrt();
        // Half a confidence interval; both tails together have 2 α.
        let standard_error = variance.max(0.0).sqrt();
        let reach = critical_value(1.0 - 2.0 * level, f64::INFINITY) * standard_error;
        let [low, high] = [-reach, reach].map(|reach| relative(unexplained + reach));
        texels.unexplained = Some(relative(unexplained));
        texels.interval = has_bars.then_some([low, high]);
        texels.verdict = if high <= margin {
            Verdict::Equivalent
        } else if low > margin {
            Verdict::Different
        } else {
            Verdict::Undecided
        };
        texels
    }
}

/// Sums of e² − σ², its variance, and r².
fn with_bars(pair: &LayerPair) -> [f64; 3] {
    let channels = pair.tests.len() as f64;
    sums(pair.texels(), |texel| {
        pair.tests
            .iter()
            .fold([0.0; 3], |[sum, spread, light], test| {
                let [unexplained, variance] = test.unexplained(texel);
                let r = f64::from(test.reference.values[texel]);
                [
                    sum + unexplained,
                    spread + channels * variance,
                    light + r * r,
                ]
            })
    })
}

/// Sums of d², zero, and r².
fn without_bars(pair: &LayerPair) -> [f64; 3] {
    sums(pair.texels(), |texel| {
        pair.channels.iter().fold([0.0; 3], |[sum, _, light], one| {
            let r = f64::from(one.reference[texel]);
            let d = f64::from(one.other[texel]) - r;
            [sum + d * d, 0.0, light + r * r]
        })
    })
}

/// A quotient of sums over squares of texels.
struct Ratio {
    numerator: f64,
    denominator: f64,
    /// Its standard error; `None` with fewer than two squares.
    standard_error: Option<f64>,
}

impl Ratio {
    /// The ratio estimator β = Σ D / Σ R of pairs (D, R), with its standard error from their scatter,
    ///
    /// ```text
    ///
    /// SE² = n/(n − 1) Σ (D − β R)² / (Σ R)²
    ///
    /// ```
    ///
    /// (Cochran, *Sampling Techniques*, 1977, section 6.4).
    fn of(squares: &[[f64; 2]]) -> Self {
        let [numerator, denominator] = squares
            .iter()
            .fold([0.0; 2], |[a, b], [d, r]| [a + d, b + r]);
        let ratio = numerator / denominator;
        let residual = |[d, r]: &[f64; 2]| (d - ratio * r) * (d - ratio * r);
        let scatter: f64 = squares.iter().map(residual).sum();
        let n = squares.len() as f64;
        Self {
            numerator,
            denominator,
            standard_error: (squares.len() > 1)
                .then(|| (scatter * n / (n - 1.0)).sqrt() / denominator),
        }
    }

    fn value(&self) -> f64 {
        self.numerator / self.denominator
    }
}

/// The probability that Student's t exceeds `distance` / `standard_error`.
fn tail(distance: f64, standard_error: f64, freedom: f64) -> f64 {
    if distance == 0.0 {
        return 0.5;
    }
    // Without scatter the quotient is infinite, and the answer certain.
    student_t_cdf(-distance / standard_error, freedom)
}
