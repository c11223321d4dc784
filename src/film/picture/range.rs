//! The values at the ends of the bar.

use super::{Content, Scale};

/// The values that have the first and the last colour.
///
/// Where nobody chooses one, it suits the values:
///
/// - Linear: from 0, or from the lowest value where that is negative, to the highest.
/// - Signed: as far below zero as above it.
/// - Logarithmic: from the value that one positive texel in a hundred is below to the
///   highest, but two decades at least and six at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The value at the lower end.
    pub low: f64,
    /// The value at the upper end.
    pub high: f64,
}

/// Decades that a logarithmic bar shows where nobody chose: enough for a caustic beside the
/// light that surrounds it, and no fewer than two, so that noise does not look like an image.
const DECADES: std::ops::RangeInclusive<f64> = 2.0..=6.0;

impl Range {
    /// A range that suits the values.
    pub(super) fn of(content: &Content, numbers: &[f64]) -> Self {
        let finite = || numbers.iter().copied().filter(|value| value.is_finite());
        let highest = finite().fold(f64::NEG_INFINITY, f64::max);
        let lowest = finite().fold(f64::INFINITY, f64::min);
        let range = match (content, content.scale()) {
            (Content::Signed { .. }, _) => {
                let extreme = highest.abs().max(lowest.abs());
                Self {
                    low: -extreme,
                    high: extreme,
                }
            }
            (_, Scale::Linear) => Self {
                low: lowest.min(0.0),
                high: highest,
            },
            (_, Scale::Logarithmic) => {
                let mut positive: Vec<f64> = finite().filter(|&value| value > 0.0).collect();
                let hundredth = positive.len() / 100;
                let low = if positive.is_empty() {
                    f64::NAN
                } else {
                    *positive.select_nth_unstable_by(hundredth, f64::total_cmp).1
                };
                let decades = (highest / low)
                    .log10()
                    .clamp(*DECADES.start(), *DECADES.end());
                Self {
                    low: highest * 10f64.powf(-decades),
                    high: highest,
                }
            }
        };
        if range.is_usable(content.scale()) {
            return range;
        }
        // Nothing finite, or all the same: there is no contrast to show.
        match (content, content.scale()) {
            (Content::Signed { .. }, _) => Self {
                low: -1.0,
                high: 1.0,
            },
            (_, Scale::Linear) => Self {
                low: 0.0,
                high: 1.0,
            },
            (_, Scale::Logarithmic) => Self {
                low: 0.01,
                high: 1.0,
            },
        }
    }

    /// Whether a bar can be drawn.
    pub(super) fn is_usable(&self, scale: Scale) -> bool {
        let Self { low, high } = *self;
        // The extent, too: a bar from -1e308 to 1e308 has none.
        low < high && (high - low).is_finite() && (scale == Scale::Linear || low > 0.0)
    }

    /// Where a value is on the bar, from 0 at the lower end to 1 at the upper; values beyond
    /// are at the ends.
    pub(super) fn position(&self, value: f64, scale: Scale) -> f64 {
        let position = match scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Logarithmic if value <= self.low => 0.0,
            Scale::Logarithmic => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        position.clamp(0.0, 1.0)
    }

    /// The value at a position on the bar.
    pub(super) fn value(&self, position: f64, scale: Scale) -> f64 {
        match scale {
            Scale::Linear => self.low + position * (self.high - self.low),
            Scale::Logarithmic => self.low * (self.high / self.low).powf(position),
        }
    }
}
