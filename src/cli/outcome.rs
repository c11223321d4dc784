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

impl Outcome {
    /// The worse of two: images that are apart, then what is incomplete.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        match (self, other) {
            (Self::Apart, _) | (_, Self::Apart) => Self::Apart,
            (Self::Incomplete, _) | (_, Self::Incomplete) => Self::Incomplete,
            (Self::Complete, Self::Complete) => Self::Complete,
        }
    }
}
