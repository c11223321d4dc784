//! Work of a stage, in units that do not depend on the machine.

use std::ops::{Add, AddAssign};

use crate::geometry::TraversalCounters;
use crate::run::Counters;

/// Work of a stage: plain fields, since the innermost loops count in them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

    /// Counts photons that went into the stage, by what became of them.
    pub fn count_results<T, E>(&mut self, results: &[Result<T, E>]) {
        self.photons += results.len() as u64;
        self.dropped += results.iter().filter(|result| result.is_err()).count() as u64;
    }

    /// The work by name.
    pub fn counters(&self) -> Counters {
        Counters::of([
            ("rays", self.rays),
            ("steps", self.steps),
            ("photons", self.photons),
            ("dropped", self.dropped),
            ("splats", self.splats),
            ("fragments", self.fragments),
            ("fetches", self.fetches),
            ("bytes", self.bytes),
        ])
    }

    /// The work of a whole frame by name, in the order of importance; `photons` are those that the frame
    /// began with.
    pub fn of_frame(stages: &[Self]) -> Counters {
        let sum = stages.iter().fold(Self::default(), |sum, one| sum + *one);
        Counters::of([
            ("rays", sum.rays),
            ("march steps", sum.steps),
            ("splats", sum.splats),
            ("fragments", sum.fragments),
            ("texture fetches", sum.fetches),
            ("bytes", sum.bytes),
            ("photons", stages.first().map_or(0, |first| first.photons)),
        ])
    }
}
