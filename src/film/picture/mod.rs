//! PNG pictures of maps: a title, the map, and a bar that says what its colours mean.
//!
//! ```text
//!   title                        unit
//!  +---------------------------+ +-+
//!  |                           | | |- 12
//!  |            map            | | |- 10
//!  |     row 0 is the top      | | |- 8
//!  |                           | | |- ...
//!  +---------------------------+ +-+
//! ```
//!
//! A triangle above or below the bar says that values go on beyond it; magenta is what is
//! no number. Maps smaller than 256 texels are enlarged by a whole factor, texels kept square.

mod canvas;
mod layout;
mod palette;
mod range;
mod ticks;

use std::io::Write as _;
use std::path::Path;

use super::Grid;
use super::atomic::{self, WriteError};
use layout::Layout;
pub use range::Range;

/// What a picture shows.
#[derive(Clone, Copy, Debug)]
pub struct PictureSpec<'a> {
    /// One line above the map; broken where it is wider.
    pub title: &'a str,
    /// The unit of the values, above the bar: `W/m²`.
    pub unit: &'a str,
    /// The values and how they become colours.
    pub content: Content<'a>,
    /// The values at the ends of the bar; `None` chooses them, as [`Range`] says.
    pub range: Option<Range>,
}

/// Values, and how they become colours. Row 0 is the top.
#[derive(Clone, Copy, Debug)]
pub enum Content<'a> {
    /// One number a texel, in perceptually even steps of colour (*inferno*: dark to bright).
    FalseColour {
        /// The numbers.
        values: &'a Grid<f32>,
        /// Even steps of what.
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

/// What equal steps of colour mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences.
    Linear,
    /// Equal ratios; zero and below have the colour of the bar's lower end.
    Logarithmic,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// Nothing to show, or more than an image viewer takes.
    #[error(
        "a picture of {width} x {height} texels: allowed are 1..={} each way",
        MAX_SIZE
    )]
    Size {
        /// Texels a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// Ends that make no bar.
    #[error(
        "a range of {low}..{high}: allowed are finite numbers, low < high, and 0 < low on a logarithmic scale"
    )]
    Range {
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// The encoder said no.
    #[error("cannot encode {path}: {message}")]
    Encode {
        /// The file that was to be.
        path: String,
        /// What the encoder said.
        message: String,
    },
    /// The system said no.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// The most texels each way.
const MAX_SIZE: usize = 8192;

impl Content<'_> {
    fn size(&self) -> (usize, usize) {
        match self {
            Self::FalseColour { values, .. } | Self::Signed { values } => {
                (values.width(), values.height())
            }
            Self::ToneMapped { values } => (values.width(), values.height()),
        }
    }

    const fn scale(&self) -> Scale {
        match self {
            Self::FalseColour { scale, .. } => *scale,
            Self::Signed { .. } | Self::ToneMapped { .. } => Scale::Linear,
        }
    }

    /// The colour of a texel.
    fn colour(&self, x: usize, y: usize, range: &Range) -> [u8; 3] {
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
    fn colour_of(&self, value: f64, range: &Range) -> Option<[u8; 3]> {
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
    fn numbers(&self) -> Vec<f64> {
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

/// Writes a picture as PNG, whole or not at all.
///
/// ```no_run
/// # use nephroid::film::{Grid, picture::{self, Content, PictureSpec, Scale}};
/// let irradiance = Grid::filled(64, 64, 1.0f32);
/// let content = Content::FalseColour { values: &irradiance, scale: Scale::Logarithmic };
/// let spec = PictureSpec { title: "Irradiance", unit: "W/m²", content, range: None };
/// picture::write("floor.png".as_ref(), &spec)?;
/// # Ok::<(), picture::PictureError>(())
/// ```
///
/// # Errors
///
/// For an empty or too large map, a range that makes no bar, and where the file cannot be written.
pub fn write(path: &Path, spec: &PictureSpec) -> Result<(), PictureError> {
    let (width, height) = spec.content.size();
    if !(1..=MAX_SIZE).contains(&width) || !(1..=MAX_SIZE).contains(&height) {
        return Err(PictureError::Size { width, height });
    }
    let numbers = spec.content.numbers();
    let range = match spec.range {
        Some(range) if range.is_usable(spec.content.scale()) => range,
        Some(Range { low, high }) => return Err(PictureError::Range { low, high }),
        None => Range::of(&spec.content, &numbers),
    };
    let canvas = Layout::new(spec, &range, &numbers).draw(spec, &range);
    let bytes = canvas.to_png().map_err(|error| PictureError::Encode {
        path: path.display().to_string(),
        message: error.to_string(),
    })?;
    Ok(atomic::write(path, |file| file.write_all(&bytes))?)
}
