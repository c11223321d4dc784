//! What photons carry from stage to stage, and what they lose.

use std::ops::AddAssign;

use super::loss::Loss;
use crate::radiometry::Rgb;
use crate::setting::Words;

/// Photons, or corners of beams, with the flux \[W\] that they stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// How many.
    pub photons: u64,
    /// Their flux \[W\].
    pub flux: Rgb,
}

impl AddAssign for Share {
    fn add_assign(&mut self, other: Self) {
        self.photons += other.photons;
        self.flux += other.flux;
    }
}

/// Flux of a photon on its way, by what sets out exactly.
///
/// Sums are of `f64`: whoever adds tallies up does so in an order that does not depend on threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tally {
    /// All that sets out towards a specular object in the light's view.
    pub set_out: Share,
    /// What comes to nothing, by [`Loss`].
    lost: [Share; Loss::WORDS.len()],
    /// What interfaces take of photons that go on; negative.
    pub interfaces: Rgb,
    /// What stage `flux` adds to photons that land.
    pub normalised: Rgb,
    /// What lands, as it is drawn.
    pub landed: Share,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            set_out: Share::default(),
            lost: [Share::default(); Loss::WORDS.len()],
            interfaces: Rgb::BLACK,
            normalised: Rgb::BLACK,
            landed: Share::default(),
        }
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.set_out += other.set_out;
        for (sum, one) in self.lost.iter_mut().zip(other.lost) {
            *sum += one;
        }
        self.interfaces += other.interfaces;
        self.normalised += other.normalised;
        self.landed += other.landed;
    }
}

impl Tally {
    /// A photon of so much flux \[W\], of which `throughput` is left, comes to nothing.
    pub fn lose(&mut self, loss: Loss, sent: Rgb, throughput: Rgb) {
        let left = sent * throughput;
        self.set_out += Share {
            photons: 1,
            flux: sent,
        };
        self.interfaces += left - sent;
        self.lost[loss as usize] += Share {
            photons: 1,
            flux: left,
        };
    }

    /// A photon that set out with `sent` \[W\], of which `throughput` is left, lands and is drawn with
    /// `drawn` \[W\] by that throughput.
    pub fn land(&mut self, sent: Rgb, throughput: Rgb, drawn: Rgb) {
        self.set_out += Share {
            photons: 1,
            flux: sent,
        };
        self.interfaces += sent * throughput - sent;
        self.normalised += (drawn - sent) * throughput;
        self.landed += Share {
            photons: 1,
            flux: drawn * throughput,
        };
    }

    /// What came to nothing for a reason.
    pub fn lost(&self, loss: Loss) -> Share {
        self.lost[loss as usize]
    }
}
