//! The values that figures can have with any truth within the truth's bars.
//!
//! T' is another truth, T that of the file, bᵢ the bar of a texel: |T'ᵢ − Tᵢ| <= bᵢ. Sums go over texels and
//! channels, by area. β = Σ b / Σ T, and β₂ = √(Σ b² / Σ T²). Then, by the triangle inequality,
//!
//! ```text
//! energy     e / (1 + Σ(hi − T)/ΣT) .. e / (1 − Σ(T − lo)/ΣT)
//! L1         (l − β) / (1 + β) .. (l + β) / (1 − β)
//! L2         (l − β₂) / (1 + β₂) .. (l + β₂) / (1 − β₂)
//! misplaced  m − β / (1 − β) .. m + β / (1 − β)
//! displaced  w − δ .. w + δ,   δ = Σ (bᵢ + β Tᵢ) |xᵢ − c| / ((1 − β) ΣT)
//! ```
//!
//! The last takes all that differs by way of one point c, the centre of light. If a truth has bounds, the
//! intervals hold as surely as these. If it has standard errors σ, b is the mean deviation of a normal
//! number, √(2/π) σ, of energy and L2 σ itself, and all texels may be off to one side: the intervals hold
//! most of the time.

use super::super::bars::Bars;
use super::super::pair::LayerPair;
use super::super::sums::{square_sums, sums};
use super::bounded::Bounded;
use super::measure::Measure;

/// The truth's bars of a layer.
pub(super) struct TruthBars {
    known: Option<Known>,
}

/// Bars that are known, channels summed.
struct Known {
    /// Texels a row and rows.
    size: [usize; 2],
    /// The area of each texel, relative.
    weights: Vec<f64>,
    /// bᵢ by area.
    bars: Vec<f64>,
    /// Σ T.
    truth: f64,
    /// Σ (hi − T) and Σ (T − lo).
    beyond: [f64; 2],
    /// Square roots of bᵢ²'s and Tᵢ²'s sums at each scale are taken channel by channel.
    channels: Vec<ChannelBars>,
}

/// One channel.
struct ChannelBars {
    truth: Vec<f64>,
    /// The largest deviation, or a standard error.
    bars: Vec<f64>,
}

/// The mean of |x| for a standard normal x: √(2/π).
const MEAN_DEVIATION: f64 = 0.797_884_560_802_865_4;

impl TruthBars {
    pub(super) fn of(pair: &LayerPair) -> Self {
        let texels = pair.texels();
        let tests = &pair.tests;
        let is_tested = |one: &super::super::pair::ChannelPair| {
            let mut named = tests.iter().map(|test| test.name.as_str());
            named.any(|name| name == one.name)
        };
        // Bars of X, Y and Z say too little of red, green and blue.
        let are_alike = !tests.is_empty() && pair.channels.iter().all(is_tested);
        if !are_alike || !tests.iter().all(|test| test.reference.has_any()) {
            return Self { known: None };
        }
        let channels: Vec<ChannelBars> = tests
            .iter()
            .map(|test| ChannelBars {
                truth: (0..texels)
                    .map(|i| f64::from(test.reference.values[i]))
                    .collect(),
                bars: (0..texels)
                    .map(|i| ends(&test.reference, i).into_iter().fold(0.0, f64::max))
                    .collect(),
            })
            .collect();
        let weights: Vec<f64> = (0..texels).map(|i| pair.grid.weight(i)).collect();
        let [truth, above, below] = sums(texels, |i| {
            let mut terms = [0.0; 3];
            for test in tests {
                let [up, down] = ends(&test.reference, i);
                terms[0] += f64::from(test.reference.values[i]);
                terms[1] += up;
                terms[2] += down;
            }
            terms.map(|term| weights[i] * term)
        });
        let bars = (0..texels).map(|i| {
            let bar = |(test, one): (&super::super::pair::TestPair, &ChannelBars)| {
                if test.reference.bounds.is_some() {
                    one.bars[i]
                } else {
                    MEAN_DEVIATION * one.bars[i]
                }
            };
            weights[i] * tests.iter().zip(&channels).map(bar).sum::<f64>()
        });
        let known = Known {
            size: [pair.width, pair.height],
            bars: bars.collect(),
            weights,
            truth,
            beyond: [above, below],
            channels,
        };
        Self {
            known: (truth > 0.0).then_some(known),
        }
    }

    pub(super) fn of_ratio(&self, value: f64) -> Bounded {
        self.bounded(value, |known| {
            let [above, below] = known.beyond.map(|sum| sum / known.truth);
            let (more, less) = (Some(value / (1.0 + above)), over(value, below));
            // An image of negative sum is nearer to zero if there is more of the truth.
            if value < 0.0 {
                [less, more]
            } else {
                [more, less]
            }
        })
    }

    pub(super) fn of_l1(&self, value: f64) -> Bounded {
        self.bounded(value, |known| relative(value, known.beta()))
    }

    pub(super) fn of_misplaced(&self, value: f64) -> Bounded {
        let mut found = self.bounded(value, |known| {
            let beta = known.beta();
            let off = over(beta, beta);
            [
                Some(off.map_or(0.0, |off| (value - off).max(0.0))),
                Some(off.map_or(1.0, |off| value + off)),
            ]
        });
        // Of an image with values below zero more than all light may be misplaced.
        found.high = found.high.map(|high| high.min(value.max(1.0)));
        found
    }

    /// L2 of means over squares: their bars are means of bars at most.
    pub(super) fn of_l2_at(&self, value: f64, side: usize) -> Bounded {
        self.bounded(value, |known| {
            let (mut bars, mut truth) = (0.0, 0.0);
            for one in &known.channels {
                let sums = square_sums(known.size, side, |i| {
                    [1.0, one.bars[i], one.truth[i]].map(|term| known.weights[i] * term)
                });
                for [n, b, t] in sums.into_iter().filter(|[n, ..]| *n > 0.0) {
                    bars += b * b / n;
                    truth += t * t / n;
                }
            }
            relative(value, (bars / truth).sqrt())
        })
    }

    /// A displacement between two bounds, in the unit of `spacing`.
    pub(super) fn of_displacement(
        &self,
        truth: &Measure,
        spacing: [f64; 2],
        lower: f64,
        upper: f64,
    ) -> Bounded {
        let Some(known) = &self.known else {
            return Bounded {
                value: lower,
                low: Some(lower),
                high: Some(upper),
            };
        };
        let centre = truth.centre(spacing);
        let beta = known.beta();
        let [reach] = sums(truth.shares.len(), |i| {
            let share = known.bars[i] / known.truth + beta * truth.shares[i];
            [share * truth.place(i, spacing).distance(centre)]
        });
        let off = over(reach, beta);
        Bounded {
            value: lower,
            low: Some(off.map_or(0.0, |off| (lower - off).max(0.0))),
            high: off.map(|off| upper + off),
        }
    }

    fn bounded(&self, value: f64, ends: impl Fn(&Known) -> [Option<f64>; 2]) -> Bounded {
        let [low, high] = self.known.as_ref().map_or([None; 2], ends);
        Bounded { value, low, high }
    }
}

impl Known {
    fn beta(&self) -> f64 {
        self.bars.iter().sum::<f64>() / self.truth
    }
}

/// The ends of a relative length whose reference is known to the part beta of itself.
fn relative(value: f64, beta: f64) -> [Option<f64>; 2] {
    let low = (value - beta).max(0.0) / (1.0 + beta);
    [Some(low), over(value + beta, beta)]
}

/// value / (1 − part); `None` if the part is all or more.
fn over(value: f64, part: f64) -> Option<f64> {
    (part < 1.0).then(|| value / (1.0 - part))
}

/// How far the truth of a texel may be above and below its value.
fn ends(bars: &Bars, texel: usize) -> [f64; 2] {
    let value = f64::from(bars.values[texel]);
    match &bars.bounds {
        Some([low, high]) => [
            (f64::from(high[texel]) - value).max(0.0),
            (value - f64::from(low[texel])).max(0.0),
        ],
        None => [bars.variance(texel).sqrt(); 2],
    }
}
