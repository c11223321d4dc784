//! Stages by name.

/// One step of a technique. Its name is the key of the setting that chooses its variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// The name.
    pub name: &'static str,
    /// The variant without the stage's error.
    pub exact: &'static str,
}
