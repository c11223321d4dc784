//! Pictures as PNG files.

use std::io::Write as _;
use std::path::Path;

use crate::film::atomic::{self, WriteError};

use super::content::PictureSpec;
use super::layout::PictureLayout;
use super::range::BarRange;

/// The largest number of texels each way.
const MAX_SIZE: usize = 8192;

/// Reason why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// Nothing to show, or more than an image viewer takes.
    #[error(
        "a picture of {width} x {height} texels: allowed are 1..={} each way",
        MAX_SIZE
    )]
    Size {
        /// Number of texels a row.
        width: usize,
        /// Number of rows.
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
    /// The encoder refused.
    #[error("cannot encode {path}: {message}")]
    Encode {
        /// The file that was to be written.
        path: String,
        /// The encoder's message.
        message: String,
    },
    /// The system refused.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Writes a picture as PNG, whole or not at all.
///
/// ```no_run
/// # use nephroid::internals::film::{Grid, picture::{self, Content, PictureSpec, Scale}};
/// let irradiance = Grid::filled(64, 64, 1.0f32);
/// let content = Content::FalseColour { values: &irradiance, scale: Scale::Logarithmic };
/// let spec = PictureSpec { title: "Irradiance", unit: "W/m²", content, range: None };
/// picture::write("floor.png".as_ref(), &spec)?;
/// # Ok::<(), picture::PictureError>(())
/// ```
///
/// # Errors
///
/// For an empty or too large map, a range that makes no bar, and a file that cannot be written.
pub fn write(path: &Path, spec: &PictureSpec) -> Result<(), PictureError> {
    let (width, height) = spec.content.size();
    if !(1..=MAX_SIZE).contains(&width) || !(1..=MAX_SIZE).contains(&height) {
        return Err(PictureError::Size { width, height });
    }
    let numbers = spec.content.numbers();
    let range = match spec.range {
        Some(range) if range.is_usable(spec.content.scale()) => range,
        Some(BarRange { low, high }) => return Err(PictureError::Range { low, high }),
        None => BarRange::of(&spec.content, &numbers),
    };
    let canvas = PictureLayout::new(spec, &range, &numbers).draw(spec, &range);
    let bytes = canvas.to_png().map_err(|error| PictureError::Encode {
        path: path.display().to_string(),
        message: error.to_string(),
    })?;
    Ok(atomic::write(path, |file| file.write_all(&bytes))?)
}
