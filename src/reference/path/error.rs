//! Why paths come to nothing.

use crate::transport::bsdf::UnknownColor;
use crate::transport::camera::CameraError;

/// Why a run cannot start or came to nothing.
#[derive(Debug, thiserror::Error)]
pub enum PathError {
    /// The sensor is no camera.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// What a surface scatters is not known.
    #[error(transparent)]
    Color(#[from] UnknownColor),
    /// A setting outside its range.
    #[error("{name} is {value}; {allowed} are allowed")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: u64,
        /// What it may be.
        allowed: &'static str,
    },
    /// Numbers that are none.
    #[error(
        "{count} samples are infinite or not a number, the first at film coordinates ({x}, {y}): the scene's \
         numbers are too large or too small to be multiplied"
    )]
    NotFinite {
        /// How many.
        count: u64,
        /// In pixels.
        x: f64,
        /// In pixels.
        y: f64,
    },
}
