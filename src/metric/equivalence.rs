//! Are two images the same within a margin?
//!
//! That a test finds no difference does not show that there is none. Two one-sided tests (TOST;
//! Schuirmann 1987) do: an image is *equivalent* where a difference as large as the margin is
//! refuted, *different* where a difference within the margin is refuted, else *undecided*.

use serde::Serialize;

use super::difference::Difference;
use super::pair::Pair;
use super::sums::square_sums;
use crate::numeric::distributions::{critical_value, student_t_cdf};

/// What is known about a margin.
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
    pub const fn name(self) -> &'static str {
        match self {
            Self::Equivalent => "equivalent",
            Self::Undecided => "undecided",
            Self::Different => "different",
        }
    }
}

/// A layer's verdicts at a margin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Equivalence {
    /// The margin, as a fraction of the reference's mean.
    pub margin: f64,
    /// The significance level of each one-sided test.
    pub level: f64,
    /// Of the mean.
    pub bias: Bias,
    /// Of the texels.
    pub texels: Texels,
    /// The worse of both.
    pub verdict: Verdict,
}

/// How far the means are apart. Relative figures are `None` where the reference is dark.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bias {
    /// Mean of the other image less that of the reference, in the image's unit.
    pub bias: f64,
    /// That over the reference's mean.
    pub relative: Option<f64>,
    /// Standard error of `relative`; `None` with fewer than two squares.
    pub standard_error: Option<f64>,
    /// Its degrees of freedom: squares less one.
    pub freedom: usize,
    /// Texels a side of the squares that its scatter is taken over.
    pub square: usize,
    /// The interval that covers the true `relative` with probability 1 − α.
    pub interval: Option<[f64; 2]>,
    /// The larger p-value of the two one-sided tests: below α shows equivalence.
    pub p: Option<f64>,
    /// What they say.
    pub verdict: Verdict,
}

/// How far texels are apart, beyond what the bars explain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Texels {
    /// √(mean (e² − σ²)) / mean r over lit texels, σ² being the variance of e, zero where that is negative: the relative RMSE
    /// that remains when noise is taken off. Without error bars the relative RMSE itself.
    pub unexplained: Option<f64>,
    /// One-sided lower and upper bounds of it, each with confidence 1 − α; `None` without bars.
    pub interval: Option<[f64; 2]>,
    /// Whether bars were there to take off.
    pub has_bars: bool,
    /// What the interval says; without bars, what the number itself says.
    pub verdict: Verdict,
}

/// Sides of squares tried, largest first.
const SIDES: [usize; 4] = [8, 4, 2, 1];

/// Squares that make a good standard error: its own error is then below 1/√(2·63) = 9 %.
const ENOUGH: usize = 64;

/// The side of squares for an image: the largest of which there are enough.
///
/// Texels near each other often err together (reconstruction filters, photons shared); squares
/// that hold such neighbours do so less.
fn side(pair: &Pair) -> usize {
    let squares = |side: usize| pair.width.div_ceil(side) * pair.height.div_ceil(side);
    SIDES
        .into_iter()
        .find(|side| squares(*side) >= ENOUGH)
        .unwrap_or(1)
}

impl Equivalence {
    /// The verdicts of a layer at `margin`, each test at significance level `level`.
    pub fn of(pair: &Pair, difference: &Difference, margin: f64, level: f64) -> Self {
        let bias = Bias::of(pair, difference, margin, level);
        let texels = Texels::of(pair, difference, margin, level);
        Self {
            margin,
            level,
            verdict: bias.verdict.max(texels.verdict),
            bias,
            texels,
        }
    }
}

impl Bias {
    /// The ratio estimator β = Σ d / Σ r with its standard error from the scatter of squares s,
    ///
    /// ```text
    /// SE² = n/(n − 1) Σ_s (D_s − β R_s)² / (Σ r)²
    /// ```
    ///
    /// (Cochran, *Sampling Techniques*, 1977, section 6.4), D and R being the sums of d and r over a
    /// square. A factor common to all texels has no scatter; and errors that both images share cancel.
    fn of(pair: &Pair, difference: &Difference, margin: f64, level: f64) -> Self {
        let side = side(pair);
        let squares = square_sums([pair.width, pair.height], side, |texel| {
            pair.channels.iter().fold([0.0; 2], |[d, r], one| {
                let (reference, other) =
                    (f64::from(one.reference[texel]), f64::from(one.other[texel]));
                [d + (other - reference), r + reference]
            })
        });
        let [differences, light] = squares
            .iter()
            .fold([0.0; 2], |[a, b], [d, r]| [a + d, b + r]);
        let samples = (pair.texels() * pair.channels.len()) as f64;
        let mut bias = Self {
            bias: differences / samples,
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
        if light <= 0.0 {
            return bias;
        }
        let relative = differences / light;
        bias.relative = Some(relative);
        if squares.len() < 2 {
            return bias;
        }
        let residuals = squares.iter().map(|[d, r]| d - relative * r);
        let standard_error = standard_error(residuals, squares.len()) / light;
        let freedom = bias.freedom as f64;
        let reach = critical_value(1.0 - level, freedom) * standard_error;
        // P(T >= t) for how far the estimate is above a limit.
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

impl Texels {
    fn of(pair: &Pair, difference: &Difference, margin: f64, level: f64) -> Self {
        let judged = |value: f64| {
            if value <= margin {
                Verdict::Equivalent
            } else {
                Verdict::Different
            }
        };
        let has_bars = !pair.tests.is_empty();
        let Some(relative_rmse) = difference.relative_rmse.filter(|_| difference.rmse > 0.0) else {
            // Equal images, or light where the reference has none at all.
            return Self {
                unexplained: (difference.rmse == 0.0).then_some(0.0),
                interval: None,
                has_bars,
                verdict: match (difference.rmse == 0.0, has_bars) {
                    (true, _) => Verdict::Equivalent,
                    (false, true) => Verdict::Undecided,
                    (false, false) => Verdict::Different,
                },
            };
        };
        if !has_bars {
            return Self {
                unexplained: Some(relative_rmse),
                interval: None,
                has_bars,
                verdict: judged(relative_rmse),
            };
        }
        let is_lit = |texel: usize| {
            let light = pair
                .channels
                .iter()
                .map(|one| f64::from(one.reference[texel]));
            light.sum::<f64>() > 0.0
        };
        let squares = square_sums([pair.width, pair.height], side(pair), |texel| {
            if !is_lit(texel) {
                return [0.0; 2];
            }
            pair.tests.iter().fold([0.0; 2], |[sum, count], test| {
                [sum + test.unexplained(texel), count + 1.0]
            })
        });
        let [sum, count] = squares
            .iter()
            .fold([0.0; 2], |[a, b], [v, n]| [a + v, b + n]);
        // Relative to the mean of the channels tested, which may be X, Y and Z.
        let level_of_light = mean_lit(pair, &is_lit);
        let mean = sum / count;
        let residuals = squares.iter().map(|[v, n]| v - mean * n);
        let standard_error = standard_error(residuals, squares.len()) / count;
        let relative = |square: f64| square.max(0.0).sqrt() / level_of_light;
        if squares.len() < 2 || level_of_light <= 0.0 {
            return Self {
                unexplained: (level_of_light > 0.0).then(|| relative(mean)),
                interval: None,
                has_bars,
                verdict: Verdict::Undecided,
            };
        }
        let freedom = (squares.len() - 1) as f64;
        // One-sided: both tails together have 2 α.
        let reach = critical_value(1.0 - 2.0 * level, freedom) * standard_error;
        let interval = [relative(mean - reach), relative(mean + reach)];
        Self {
            unexplained: Some(relative(mean)),
            interval: Some(interval),
            has_bars,
            verdict: if interval[1] <= margin {
                Verdict::Equivalent
            } else if interval[0] > margin {
                Verdict::Different
            } else {
                Verdict::Undecided
            },
        }
    }
}

/// The mean of the reference over lit texels, in the channels that are tested.
fn mean_lit(pair: &Pair, is_lit: &(impl Fn(usize) -> bool + Sync)) -> f64 {
    let [sum, count] = super::sums::sums(pair.texels(), |texel| {
        if !is_lit(texel) {
            return [0.0; 2];
        }
        let values = pair
            .tests
            .iter()
            .map(|test| f64::from(test.reference.values[texel]));
        [values.sum(), pair.tests.len() as f64]
    });
    sum / count
}

/// √(n/(n − 1) Σ residual²): the standard error of a sum of n terms.
fn standard_error(residuals: impl Iterator<Item = f64>, count: usize) -> f64 {
    let squares: f64 = residuals.map(|residual| residual * residual).sum();
    let n = count as f64;
    (squares * n / (n - 1.0)).sqrt()
}

/// The probability that Student's t exceeds `distance` / `standard_error`.
fn tail(distance: f64, standard_error: f64, freedom: f64) -> f64 {
    if distance == 0.0 {
        return 0.5;
    }
    // Without scatter the quotient is infinite, and the answer certain.
    student_t_cdf(-distance / standard_error, freedom)
}
