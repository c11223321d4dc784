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

/// The share of a photon's flux that interfaces have let through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// As it is modelled.
    pub throughput: Rgb,
    /// By Fresnel's equations, at the same angles.
    pub by_fresnel: Rgb,
}

impl Left {
    /// Before all interfaces.
    pub const ALL: Self = Self {
        throughput: Rgb::WHITE,
        by_fresnel: Rgb::WHITE,
    };
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
    /// What interfaces take by Fresnel's equations and by their colour, of photons that go on; negative.
    pub interfaces: Rgb,
    /// What of that is not modelled.
    pub unmodelled: Rgb,
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
            unmodelled: Rgb::BLACK,
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
        self.unmodelled += other.unmodelled;
        self.normalised += other.normalised;
        self.landed += other.landed;
    }
}

impl Tally {
    /// A photon of so much flux \[W\] comes to nothing, with what interfaces have left of it.
    pub fn lose(&mut self, loss: Loss, sent: Rgb, left: Left) {
        let flux = self.pass(sent, left);
        self.lost[loss as usize] += Share { photons: 1, flux };
    }

    /// A photon that set out with `sent` \[W\] lands, and is drawn as if `drawn` \[W\] had set out.
    pub fn land(&mut self, sent: Rgb, left: Left, drawn: Rgb) {
        self.pass(sent, left);
        self.normalised += (drawn - sent) * left.throughput;
        self.landed += Share {
            photons: 1,
            flux: drawn * left.throughput,
        };
    }

    /// A photon of so much flux \[W\] sets out and passes interfaces: what goes on.
    fn pass(&mut self, sent: Rgb, left: Left) -> Rgb {
        self.set_out += Share {
            photons: 1,
            flux: sent,
        };
        let (modelled, by_fresnel) = (sent * left.throughput, sent * left.by_fresnel);
        self.interfaces += by_fresnel - sent;
        self.unmodelled += modelled - by_fresnel;
        modelled
    }

    /// What came to nothing for a reason.
    pub fn lost(&self, loss: Loss) -> Share {
        self.lost[loss as usize]
    }
}
