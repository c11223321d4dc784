//! Stages by name, and the work they do.

use std::ops::{Add, AddAssign};

use crate::geometry::TraversalCounters;

/// One step of a technique.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stage {
    /// Its name, which is also the key of the setting that chooses its variant.
    pub name: &'static str,
    /// The variant that runs.
    pub variant: String,
    /// The variant without the stage's error.
    pub exact: &'static str,
}

impl Stage {
    /// Whether it has no error of its own.
    pub fn is_exact(&self) -> bool {
        self.variant == self.exact
    }
}

/// Work in units that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Work {
    /// Rays traced against the scene: what a device rasterises or traces.
    pub rays: u64,
    /// Steps of marches along rays through a depth map.
    pub steps: u64,
    /// Photons that went into the stage.
    pub photons: u64,
    /// Photons that came to nothing in it: the technique does not model where they go.
    pub dropped: u64,
    /// Splats drawn.
    pub splats: u64,
    /// Texels that splats covered, each blended once.
    pub fragments: u64,
    /// Texels read.
    pub fetches: u64,
    /// Bytes of the buffers that the stage writes for others.
    pub bytes: u64,
}

impl Add for Work {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.steps += other.steps;
        self.photons += other.photons;
        self.dropped += other.dropped;
        self.splats += other.splats;
        self.fragments += other.fragments;
        self.fetches += other.fetches;
        self.bytes += other.bytes;
    }
}

impl Work {
    /// Counts the rays of a search.
    pub fn add_rays(&mut self, counters: TraversalCounters) {
        self.rays += counters.rays;
    }
}

/// What one stage did.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct StageWork {
    /// The stage.
    pub name: &'static str,
    /// Counted.
    pub work: Work,
    /// Timed \[s\]: of this machine, and its other users.
    pub seconds: f64,
}
