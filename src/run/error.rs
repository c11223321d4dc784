//! The errors that end a run.

use crate::film::AccumulatorError;
use crate::setting::SettingError;
use crate::transport::bsdf::UnknownColor;
use crate::transport::camera::CameraError;
use crate::transport::chain_limits::NotFollowed;
use crate::transport::domain::LightSpaceError;
use crate::transport::receiver::ReceiverError;

use super::CombineError;

/// An error that ends a run without a result.
///
/// # Example: a setting that does not exist
///
/// ```
/// let given = [("fotons".to_owned(), "7".to_owned())].into();
/// let error = nephroid::Method::new("photons", &given).unwrap_err();
/// assert!(error.to_string().contains("did you mean \"photons\"?"));
/// ```
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A setting that does not exist, or that cannot have its value.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A scene or sensor that the method cannot work on.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// Numbers that cannot be summed: infinite, NaN, or far beyond the emitters' flux.
    #[error("{0}")]
    NotRepresentable(String),
    /// Parts of an image that cannot be added.
    #[error(transparent)]
    Combine(
        #[doc(hidden)]
        #[from]
        CombineError,
    ),
    /// The threads asked for cannot be started.
    #[error("cannot start the threads: {0}")]
    Threads(String),
}

/// The reason for which a method cannot work on a scene or a sensor, with what would be allowed.
///
/// # Example
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let scene = nephroid::load("scenes/cornell-glass.xml".as_ref(), &[])?;
/// let method = nephroid::Method::new("closed-form", &Default::default())?;
/// let refusal = method.supports(&scene, &scene.sensors()[0]).unwrap_err();
/// assert!(!refusal.reason().is_empty());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct Refusal {
    reason: String,
}

impl Refusal {
    /// A refusal for a reason: one sentence that names what cannot be, and what can.
    #[doc(hidden)]
    pub fn new(reason: impl Into<String>) -> Self {
        Self {
            reason: reason.into(),
        }
    }

    /// The reason.
    pub fn reason(&self) -> &str {
        &self.reason
    }
}

/// Lets `?` turn the errors of lower floors into refusals and errors.
macro_rules! refusals {
    ($($error:ty),*) => {$(
        impl From<$error> for Refusal {
            fn from(error: $error) -> Self {
                Self::new(error.to_string())
            }
        }

        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::Refused(error.into())
            }
        }
    )*};
}

refusals!(
    CameraError,
    LightSpaceError,
    NotFollowed,
    ReceiverError,
    UnknownColor
);

impl From<AccumulatorError> for Error {
    fn from(error: AccumulatorError) -> Self {
        Self::NotRepresentable(error.to_string())
    }
}
