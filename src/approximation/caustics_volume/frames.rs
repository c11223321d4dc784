//! Updates that take several frames (section 4): a share of the photons a frame, or some of the passes.
//!
//! `shares` traces one of M shares of the photons in each frame, and shows the last M. `amortise` makes some
//! passes a frame, each with the scene of its own frame, and shows the last sweep that ended: the image
//! trails behind.

use super::ledger::Tally;
use super::photon::Landing;
use super::settings::Settings;
use super::sweep::Queue;
use crate::radiometry::Rgb;

/// Photons that landed, and what became of all of theirs.
pub type Landed = (Vec<Landing>, Tally);

/// What is underway between frames.
#[derive(Debug, Default)]
pub struct Frames {
    /// Frames so far.
    number: u64,
    /// The landings of each share, the last that were traced.
    shares: Vec<Landed>,
    /// The sweep that has not ended: its photons, and its next pass.
    pub sweep: Option<(Queue, usize)>,
    /// The landings of the last sweep that ended.
    pub shown: Option<Landed>,
}

impl Frames {
    /// Drops a sweep that is underway, if the volume or the number of its slabs is another one now.
    pub fn keep_sweep_of(&mut self, slabs: usize, is_same_volume: bool) {
        let holds = |(queue, _): &(Queue, usize)| is_same_volume && queue.waiting.len() == slabs;
        self.sweep = self.sweep.take().filter(holds);
    }

    /// The share of this frame, of how many.
    pub fn share(&self, settings: &Settings) -> [u64; 2] {
        let count = u64::from(settings.shares);
        [self.number % count, count]
    }

    /// True if a photon is of a share. Neighbours are of different ones.
    pub fn is_in(photon: u64, [share, shares]: [u64; 2]) -> bool {
        // 2^64 / φ, odd: its multiples are spread evenly (Knuth, section 6.4).
        const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
        (photon.wrapping_mul(STEP) >> 32) % shares == share
    }

    /// The frame's landings: those of its share with those of others, as far as these were traced.
    #[must_use]
    pub fn with_others(&mut self, settings: &Settings, landed: Landed) -> Landed {
        let [share, shares] = self.share(settings);
        self.number += 1;
        if shares == 1 {
            return landed;
        }
        if self.shares.len() as u64 <= share {
            self.shares.push(landed);
        } else {
            self.shares[share as usize] = landed;
        }
        // Each share has the flux of all photons.
        let part = Rgb::grey(1.0 / self.shares.len() as f64);
        let mut all = Landed::default();
        for (landed, tally) in &self.shares {
            all.0.extend(landed.iter().map(|landing| {
                let mut scaled = *landing;
                scaled.photon.flux = landing.photon.flux * part;
                scaled
            }));
            all.1.add_scaled(tally, part);
        }
        all
    }
}
