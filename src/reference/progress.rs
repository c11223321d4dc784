//! How far a run has come.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// How far a run has come: written by the run, read by whoever shows it. Setting `stop` ends
/// the run soon, with what there is.
#[derive(Debug, Default)]
pub struct Progress {
    /// Light paths (photons, nodes of beams) finished.
    pub paths: AtomicU64,
    /// Paths the run now expects to follow in all; 0 while unknown.
    pub expected_paths: AtomicU64,
    /// Bits of the relative error so far; NaN's while unknown.
    relative_error: AtomicU64,
    /// Ends the run.
    pub stop: AtomicBool,
}

impl Progress {
    /// The relative error so far.
    pub fn relative_error(&self) -> Option<f64> {
        let error = f64::from_bits(self.relative_error.load(Ordering::Relaxed));
        (error > 0.0).then_some(error)
    }

    pub(super) fn set_relative_error(&self, error: Option<f64>) {
        self.relative_error
            .store(error.unwrap_or(0.0).to_bits(), Ordering::Relaxed);
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
