//! Parts and rounds of a run, by number.

use serde::{Deserialize, Serialize};

/// One of the parts that a run is made in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Index of the part, counted from 0.
    pub index: u32,
    /// Number of parts.
    pub count: u32,
}

impl Shard {
    /// The whole run.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Number of a run's replicates that the shard traces.
    pub fn replicates(&self, all: u32) -> u32 {
        if all > self.index {
            (all - 1 - self.index) / self.count + 1
        } else {
            0
        }
    }

    /// True if the shard has this one of things that are dealt by turns: replicates, or bands of an image.
    pub fn holds(&self, number: u32) -> bool {
        number % self.count == self.index
    }
}

/// A round of a run: all replicates, each with as much work. The unit of work is the method's: photons,
/// photon maps, or samples a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Round {
    /// Its number, from 0.
    pub number: u64,
    /// Number of replicates.
    pub replicates: u32,
    /// Work of each of them.
    pub each: u64,
    /// Work of each of them in the rounds before.
    pub before: u64,
}

impl Round {
    /// Work of so many of its replicates.
    pub fn work_of(&self, replicates: u32) -> u64 {
        self.each.saturating_mul(replicates.into())
    }

    /// Work of all replicates.
    pub fn work(&self) -> u64 {
        self.work_of(self.replicates)
    }
}
