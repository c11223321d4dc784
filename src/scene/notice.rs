//! What a reader of the scene should know beside its contents.

use std::fmt;
use std::path::PathBuf;

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct SourcePosition {
    /// The file, as it was opened.
    pub file: PathBuf,
    /// Counted from 1; 0 where the file has no lines.
    pub line: u32,
    /// Counted from 1; 0 where the file has no lines.
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

/// Something odd that does not stop a run, but belongs into its report.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Warning {
    /// Where it was found, if that is known.
    pub at: Option<SourcePosition>,
    /// What was found, with counts and an example.
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

/// A part of the file that this program has no use for, and why.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Ignored {
    /// Where the file holds it.
    pub at: SourcePosition,
    /// What it is: tag and plugin.
    pub what: String,
    /// Why it makes no difference.
    pub why: String,
}
