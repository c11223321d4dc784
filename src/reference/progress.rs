//! How far a run has come.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// How far a run has come: written by the run, read by whoever shows it. Setting `stop` ends
/// the run soon, with what there is.
#[derive(Debug, Default)]
pub struct Progress {
    /// Photons, or paths from a camera, finished; of beams the pieces of light space (roots) that the pass has done.
    pub paths: AtomicU64,
    /// What `paths` is expected to come to; 0 while unknown.
    pub expected_paths: AtomicU64,
    /// The pass of beams under way, from 1; 0 for photons, and before the first.
    passes: AtomicU64,
    /// Whether `paths` counts paths from a camera.
    from_camera: AtomicBool,
    /// Bits of the relative error so far; zero while unknown.
    relative_error: AtomicU64,
    /// Ends the run.
    pub stop: AtomicBool,
}

impl Progress {
    /// Begins a pass of beams over so many roots.
    pub(crate) fn begin_pass(&self, roots: u64) {
        self.paths.store(0, Ordering::Relaxed);
        self.expected_paths.store(roots, Ordering::Relaxed);
        self.passes.fetch_add(1, Ordering::Relaxed);
    }

    /// Says that paths from a camera are counted.
    pub(super) fn count_camera_paths(&self) {
        self.from_camera.store(true, Ordering::Relaxed);
    }

    /// What is counted, in the plural.
    pub fn unit(&self) -> &'static str {
        match (self.pass(), self.from_camera.load(Ordering::Relaxed)) {
            (Some(_), _) => "roots",
            (None, true) => "paths",
            (None, false) => "photons",
        }
    }

    /// Begins the next of several runs, or methods that make one estimate.
    pub fn begin_part(&self) {
        for counter in [&self.paths, &self.expected_paths, &self.passes] {
            counter.store(0, Ordering::Relaxed);
        }
        self.from_camera.store(false, Ordering::Relaxed);
        self.set_relative_error(None);
    }

    /// The pass of beams under way, from 1; `None` where there is none.
    pub fn pass(&self) -> Option<u64> {
        let pass = self.passes.load(Ordering::Relaxed);
        (pass > 0).then_some(pass)
    }

    /// The relative error so far.
    pub fn relative_error(&self) -> Option<f64> {
        let error = f64::from_bits(self.relative_error.load(Ordering::Relaxed));
        (error > 0.0).then_some(error)
    }

    pub(crate) fn set_relative_error(&self, error: Option<f64>) {
        self.relative_error
            .store(error.unwrap_or(0.0).to_bits(), Ordering::Relaxed);
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
