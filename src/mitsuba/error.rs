//! The error of a file that does not become a scene.

use std::path::Path;

use crate::scene::{SceneError, SourcePosition};

/// Reason why a file does not become a scene: the place, the problem, and what is allowed there.
///
/// It displays as `scene.xml:12:5: bsdf "roughplastic" is not modelled; ...`. A problem inside a mesh file is
/// reported at the XML element that asked for the file, and names the place inside it.
///
/// # Example: a size that is no number
///
/// ```
/// let error = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "x")]).unwrap_err();
/// assert!(error.message.contains("not a whole number"));
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{at}: {message}")]
pub struct LoadError {
    /// The element or file that is to blame.
    pub at: SourcePosition,
    /// The problem, and what is allowed.
    pub message: String,
}

impl LoadError {
    /// An error at a known place.
    pub(super) fn new(at: SourcePosition, message: impl Into<String>) -> Self {
        Self {
            at,
            message: message.into(),
        }
    }

    /// An error about a file as a whole.
    pub(super) fn of_file(file: &Path, message: impl Into<String>) -> Self {
        let at = SourcePosition {
            file: file.to_owned(),
            line: 0,
            column: 0,
        };
        Self::new(at, message)
    }
}

impl From<SceneError> for LoadError {
    fn from(error: SceneError) -> Self {
        Self::new(error.at, error.message)
    }
}
