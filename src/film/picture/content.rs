//! The content of a picture.

use crate::film::Grid;
use crate::numeric::math;

use super::palette;
use super::range::{BarRange, Scale};

/// The content of a picture, and its labels.
#[derive(Clone, Copy, Debug)]
pub struct PictureSpec<'a> {
    /// One line above the map; broken if it is wider.
    pub title: &'a str,
    /// The unit of the values, above the bar: `W/m²`.
    pub unit: &'a str,
    /// The values and their colours.
    pub content: Content<'a>,
    /// The values at the ends of the bar; `None` chooses them, as described at [`BarRange`].
    pub range: Option<BarRange>,
}

/// Values, and the rule for their colours. Row 0 is the top.
#[derive(Clone, Copy, Debug)]
pub enum Content<'a> {
    /// One number a texel, in perceptually even steps of colour (*inferno*: dark to bright).
    FalseColour {
        /// The numbers.
        values: &'a Grid<f32>,
        /// The quantity that has even steps.
        scale: Scale,
    },
    /// Differences: blue below zero, white at zero, red above. Linear.
    Signed {
        /// The numbers.
        values: &'a Grid<f32>,
    },
    /// Linear sRGB, divided by the range's upper end, with the transfer function of sRGB
    /// (IEC 61966-2-1). The bar shows greys.
    ToneMapped {
        /// Red, green and blue.
        values: &'a Grid<[f32; 3]>,
    },
}

/// Number of decades that a logarithmic bar shows by default: enough for a caustic beside the light that
/// surrounds it, and no fewer than two, so that noise does not look like an image.
const DECADES: std::ops::RangeInclusive<f64> = 2.0..=6.0;

impl Content<'_> {
    pub(super) fn size(&self) -> (usize, usize) {
        match self {
            Self::FalseColour { values, .. } | Self::Signed { values } => {
                (values.width(), values.height())
            }
            Self::ToneMapped { values } => (values.width(), values.height()),
        }
    }

    pub(super) const fn scale(&self) -> Scale {
        match self {
            Self::FalseColour { scale, .. } => *scale,
            Self::Signed { .. } | Self::ToneMapped { .. } => Scale::Linear,
        }
    }

    /// The colour of a texel.
    pub(super) fn colour(&self, x: usize, y: usize, range: &BarRange) -> [u8; 3] {
        let colour = match self {
            Self::FalseColour { values, .. } | Self::Signed { values } => values
                .get(x, y)
                .and_then(|&value| self.colour_of(f64::from(value), range)),
            Self::ToneMapped { values } => values
                .get(x, y)
                .filter(|rgb| !rgb.iter().any(|value| value.is_nan()))
                .map(|rgb| {
                    rgb.map(|value| palette::srgb(range.position(f64::from(value), Scale::Linear)))
                }),
        };
        colour.unwrap_or(palette::NOT_A_NUMBER)
    }

    /// The colour of a value, on the bar and on the map of numbers; `None` for NaN.
    pub(super) fn colour_of(&self, value: f64, range: &BarRange) -> Option<[u8; 3]> {
        if value.is_nan() {
            return None;
        }
        let position = range.position(value, self.scale());
        Some(match self {
            Self::FalseColour { .. } => palette::inferno(position),
            Self::Signed { .. } => palette::diverging(position),
            Self::ToneMapped { .. } => [palette::srgb(position); 3],
        })
    }

    /// All numbers, in no special order.
    pub(super) fn numbers(&self) -> Vec<f64> {
        match self {
            Self::FalseColour { values, .. } | Self::Signed { values } => {
                values.iter().map(|&value| f64::from(value)).collect()
            }
            Self::ToneMapped { values } => values
                .iter()
                .flatten()
                .map(|&value| f64::from(value))
                .collect(),
        }
    }
}

impl BarRange {
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
                let decades = math::log10(highest / low).clamp(*DECADES.start(), *DECADES.end());
                Self {
                    low: highest * math::powf(10f64, -decades),
                    high: highest,
                }
            }
        };
        if range.is_usable(content.scale()) {
            return range;
        }
        // Nothing is finite, or all values are the same: there is no contrast to show.
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
}
