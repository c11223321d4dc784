//! The flux of a frame, from the light to the image.

use std::ops::AddAssign;

use super::variants::Step;
use crate::radiometry::Rgb;
use crate::run::FluxEntry;
use crate::setting::Words;
use crate::setting::words::words;

words! {
    /// What becomes of photons.
    Fate {
        /// Emission
        SetsOut = "enters the volume",
        /// Interface
        Taken = "taken by interfaces",
        /// Interface
        Unmodelled = "of that not modelled",
        /// Interface
        TotalReflection = "ends in total reflection",
        /// Interface
        Behind = "meets the back of a mirror",
        /// Interface
        TooDeep = "has too many events, or hardly any light",
        /// Sweep
        Backward = "goes back towards the entry",
        /// Sweep
        Culled = "leaves by a face that culls",
        /// Sweep
        Straight = "meets nothing that mirrors or refracts",
        /// Projector
        BesidePictures = "leaves the projectors' pictures",
        /// Projector
        NoReceiver = "meets no surface",
        /// Projector
        Specular = "meets a mirror or glass outside",
        /// Splat
        Landed = "lands",
    }
}

impl Fate {
    /// The stage in which it comes to that.
    fn step(self) -> Step {
        match self {
            Self::SetsOut => Step::Emission,
            Self::Taken
            | Self::Unmodelled
            | Self::TotalReflection
            | Self::Behind
            | Self::TooDeep => Step::Interface,
            Self::Backward | Self::Culled | Self::Straight => Step::Sweep,
            Self::BesidePictures | Self::NoReceiver | Self::Specular => Step::Projector,
            Self::Landed => Step::Splat,
        }
    }
}

/// Flux \[W\] and photons by what became of them.
///
/// Sums are of `f64`: whoever adds tallies up does so in an order that does not depend on threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tally {
    flux: [Rgb; Fate::WORDS.len()],
    photons: [u64; Fate::WORDS.len()],
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            flux: [Rgb::BLACK; Fate::WORDS.len()],
            photons: [0; Fate::WORDS.len()],
        }
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        for (sum, one) in self.flux.iter_mut().zip(other.flux) {
            *sum += one;
        }
        for (sum, one) in self.photons.iter_mut().zip(other.photons) {
            *sum += one;
        }
    }
}

impl Tally {
    /// Books a photon with some flux \[W\].
    #[inline]
    pub fn add(&mut self, fate: Fate, flux: Rgb) {
        self.flux[fate as usize] += flux;
        self.photons[fate as usize] += 1;
    }

    /// Books a change of flux \[W\] of photons that go on.
    #[inline]
    pub fn change(&mut self, fate: Fate, flux: Rgb) {
        self.flux[fate as usize] += flux;
    }

    /// Books what another tally has by its flux, which is by a unit, and by a number of photons of its own.
    pub fn add_scaled(&mut self, other: &Self, flux: Rgb) {
        for (sum, one) in self.flux.iter_mut().zip(other.flux) {
            *sum += one * flux;
        }
        for (sum, one) in self.photons.iter_mut().zip(other.photons) {
            *sum += one;
        }
    }

    /// Flux \[W\] by what became of it.
    pub fn flux(&self, fate: Fate) -> Rgb {
        self.flux[fate as usize]
    }

    /// Photons by what became of them.
    pub fn photons(&self, fate: Fate) -> u64 {
        self.photons[fate as usize]
    }
}

/// The flux of a frame \[W\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Flow {
    /// Up to where photons land.
    pub tally: Tally,
    /// All that the image has before the film is filtered.
    pub drawn: Rgb,
    /// All that it has in the end.
    pub image: Rgb,
}

impl Flow {
    /// The entries, in the order of stages: together what the image has.
    pub fn entries(&self) -> Vec<FluxEntry> {
        /// What sums of a million photons differ by if they are the same, relative to them.
        const ROUNDING: f64 = 1e-12;
        let tally = &self.tally;
        let fates = Fate::WORDS.iter();
        let mut all: Vec<(Step, &'static str, Rgb, u64)> = fates
            .filter(|(_, fate, _)| *fate != Fate::Landed)
            .map(|&(reason, fate, _)| {
                let flux = tally.flux(fate);
                let sign = match fate {
                    Fate::SetsOut | Fate::Taken | Fate::Unmodelled => 1.0,
                    _ => -1.0,
                };
                (fate.step(), reason, flux * sign, tally.photons(fate))
            })
            .collect();
        let landed = tally.flux(Fate::Landed);
        let beside = self.drawn - landed;
        all.push((
            Step::Splat,
            "beside the sensor, and the form of splats",
            beside,
            0,
        ));
        let filtered = self.image - self.drawn;
        all.push((Step::Smooth, "the filter of the film", filtered, 0));
        let rounding = ROUNDING * tally.flux(Fate::SetsOut).max_channel();
        let is_there = |flux: &Rgb| flux.0.iter().any(|watts| watts.abs() > rounding);
        all.retain(|(.., flux, photons)| is_there(flux) || *photons > 0);
        all.into_iter()
            .map(|(step, reason, flux, photons)| FluxEntry {
                stage: step.word(),
                reason,
                flux,
                photons,
            })
            .collect()
    }
}
