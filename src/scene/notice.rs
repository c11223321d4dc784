//! Notices for a reader of the scene: warnings, and contents that are ignored.

use std::fmt;
use std::path::PathBuf;

/// A place in a file.
///
/// # Example: the line to correct
///
/// ```
/// let error = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "x")]).unwrap_err();
/// assert!(error.at.file.ends_with("glass-ball.xml") && error.at.line > 1);
/// ```
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct SourcePosition {
    /// The file, as it was opened.
    pub file: PathBuf,
    /// Counted from 1; 0 for a file as a whole.
    pub line: u32,
    /// Counted from 1; 0 for a file as a whole.
    pub column: u32,
}

impl fmt::Display for SourcePosition {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.file.display())?;
        if self.line > 0 {
            write!(formatter, ":{}:{}", self.line, self.column)?;
        }
        Ok(())
    }
}

/// An oddity that does not stop a run, but belongs in its report.
///
/// # Example: all warnings of a file
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// for warning in scene.warnings() {
///     println!("{warning}");
/// }
/// assert!(scene.warnings().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Warning {
    /// The place, if it is known.
    pub at: Option<SourcePosition>,
    /// The oddity, with counts and an example.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(at) = &self.at {
            write!(formatter, "{at}: ")?;
        }
        formatter.write_str(&self.message)
    }
}

/// A part of the file that this program has no use for, and the reason.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Ignored {
    /// The place in the file.
    pub at: SourcePosition,
    /// Tag and plugin.
    pub what: String,
    /// The reason why it makes no difference.
    pub why: String,
}
