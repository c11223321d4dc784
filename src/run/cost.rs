//! The cost of a run, before anything is traced.

use serde::Serialize;

use super::Counter;

/// The cost of a run, before anything is traced: a bound on its memory, and the work that is known.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Cost {
    /// Memory \[bytes\] that the run takes at most, beside the scene and the program.
    pub bytes: u64,
    /// Work that its settings fix; empty if time or an error ends the run.
    pub work: Vec<Counter>,
}
