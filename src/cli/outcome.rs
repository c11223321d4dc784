//! The outcome of a command that did not fail.

/// The outcome of a command that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It did what was asked.
    Complete,
    /// It was stopped early; what there was is marked incomplete.
    Incomplete,
    /// It compared two images, and they are further apart than they may be.
    Apart,
}
