//! Updates that take several frames (section 4): a share of the photons a frame, or some of the passes.
//!
//! `progressive` traces one of M shares of the photons in each frame, and shows the last M. `amortise` makes
//! some passes a frame, each with the scene of its own frame, and shows the last sweep that ended: the image
//! trails behind.

use super::photon::Landing;
use super::settings::Settings;
use super::sweep::Queue;
use crate::radiometry::Rgb;

/// What is underway between frames.
#[derive(Debug, Default)]
pub struct Frames {
    /// Frames so far.
    number: u64,
    /// Landings of each share, the last that were traced.
    shares: Vec<Vec<Landing>>,
    /// The sweep that has not ended: its photons, and its next pass.
    pub sweep: Option<(Queue, usize)>,
    /// The landings of the last sweep that ended.
    pub shown: Option<Vec<Landing>>,
}

impl Frames {
    /// The number of shares.
    fn count(settings: &Settings) -> u64 {
        (1.0 / settings.progressive).round() as u64
    }

    /// Drops a sweep that is underway, if the volume or the number of its slabs is another one now.
    pub fn keep_sweep_of(&mut self, slabs: usize, is_same_volume: bool) {
        let holds = |(queue, _): &(Queue, usize)| is_same_volume && queue.waiting.len() == slabs;
        self.sweep = self.sweep.take().filter(holds);
    }

    /// The share of this frame, of how many.
    pub fn share(&self, settings: &Settings) -> [u64; 2] {
        let count = Self::count(settings);
        [self.number % count, count]
    }

    /// The frame's landings: those of its share with those of others, as far as these were traced.
    #[must_use]
    pub fn with_others(&mut self, settings: &Settings, landed: Vec<Landing>) -> Vec<Landing> {
        let [share, count] = self.share(settings);
        self.number += 1;
        if count == 1 {
            return landed;
        }
        if self.shares.len() as u64 <= share {
            self.shares.push(landed);
        } else {
            self.shares[share as usize] = landed;
        }
        // Each share has the flux of all photons.
        let part = 1.0 / self.shares.len() as f64;
        let all = self.shares.iter().flatten();
        all.map(|landing| scaled(landing, part)).collect()
    }
}

/// A landing with a part of its flux.
fn scaled(landing: &Landing, part: f64) -> Landing {
    let flux: Rgb = landing.photon.flux * part;
    let mut scaled = *landing;
    scaled.photon.flux = flux;
    scaled
}
