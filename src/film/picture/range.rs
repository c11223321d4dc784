//! The values at the ends of the bar, and the steps between them.

use crate::numeric::math;

/// The meaning of equal steps of colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences.
    Linear,
    /// Equal ratios; zero and below have the colour of the bar's lower end.
    Logarithmic,
}

/// The values that have the first and the last colour.
///
/// The default suits the values:
///
/// - Linear: from 0, or from the lowest value if that is negative, to the highest.
/// - Signed: as far below zero as above it.
/// - Logarithmic: from the value that one positive texel in a hundred is below to the highest, but two
///   decades at least and six at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarRange {
    /// The value at the lower end.
    pub low: f64,
    /// The value at the upper end.
    pub high: f64,
}

impl BarRange {
    /// True if a bar can be drawn.
    pub(super) fn is_usable(&self, scale: Scale) -> bool {
        let Self { low, high } = *self;
        // The extent must be finite, too: a bar from -1e308 to 1e308 has none.
        low < high && (high - low).is_finite() && (scale == Scale::Linear || low > 0.0)
    }

    /// The position of a value on the bar, from 0 at the lower end to 1 at the upper; values beyond are at
    /// the ends.
    pub(super) fn position(&self, value: f64, scale: Scale) -> f64 {
        let position = match scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Logarithmic if value <= self.low => 0.0,
            Scale::Logarithmic => math::ln(value / self.low) / math::ln(self.high / self.low),
        };
        position.clamp(0.0, 1.0)
    }

    /// The value at a position on the bar.
    pub(super) fn value(&self, position: f64, scale: Scale) -> f64 {
        match scale {
            Scale::Linear => self.low + position * (self.high - self.low),
            Scale::Logarithmic => self.low * math::powf(self.high / self.low, position),
        }
    }
}
