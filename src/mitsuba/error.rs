//! The error of a file that does not become a scene.

use std::collections::HashSet;
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
/// # Example: all problems of a file
///
/// ```no_run
/// let error = nephroid::load("scene.xml".as_ref(), &[]).unwrap_err();
/// for one in error.all() {
///     println!("{}: {}", one.at, one.message);
/// }
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{at}: {message}{}", counted(.others))]
pub struct LoadError {
    /// The element or file that is to blame.
    pub at: SourcePosition,
    /// The problem, and what is allowed.
    pub message: String,
    /// Further problems of the same scene, in the order found: the first of each object. They have none of
    /// their own.
    pub others: Vec<LoadError>,
}

/// A remark on further problems.
fn counted(others: &[LoadError]) -> String {
    match others.len() {
        0 => String::new(),
        more => format!(" (and {more} more: nephroid inspect lists them)"),
    }
}

impl LoadError {
    /// An error at a known place.
    pub(super) fn new(at: SourcePosition, message: impl Into<String>) -> Self {
        Self {
            at,
            message: message.into(),
            others: Vec::new(),
        }
    }

    /// One error of several, each problem once; `None` of none.
    pub(super) fn of_all(errors: impl IntoIterator<Item = Self>) -> Option<Self> {
        let (mut list, mut seen) = (Vec::new(), HashSet::new());
        for mut error in errors {
            let others = std::mem::take(&mut error.others);
            for one in std::iter::once(error).chain(others) {
                if seen.insert(one.to_string()) {
                    list.push(one);
                }
            }
        }
        let mut list = list.into_iter();
        let mut first = list.next()?;
        first.others = list.collect();
        Some(first)
    }

    /// All problems of the scene: itself, and the others.
    pub fn all(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.others)
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
