//! What a discovery found.

use std::collections::BTreeMap;

use super::look::LandedPath;
use crate::radiometry::Rgb;
use crate::transport::signature::Signature;

/// Where less than this part of the light that lands is on the film, the rest is not what errors are measured by.
const MOSTLY_BESIDE: f64 = 1.0 / 16.0;

/// What a discovery saw of one signature.
#[derive(Clone, Copy, Debug, Default)]
pub struct SignatureLight {
    /// About how much flux it brings \[W\], mean of channels.
    pub flux: f64,
    /// The most that a path delivers of what sets out.
    pub peak: f64,
    /// What of it falls on the film, not beside it \[W\].
    pub on_film: f64,
}

/// What a discovery saw.
#[derive(Clone, Debug, Default)]
pub struct Discovery {
    /// What each signature brings to the sensor's surface.
    pub signatures: BTreeMap<Signature, SignatureLight>,
    /// About the flux that lands on the film and beside it \[W\].
    pub landed: f64,
    /// How closely single paths were followed from each light to each shape, by their indices.
    pub looked: BTreeMap<(usize, u32), Looked>,
}

/// How closely a shape was looked at.
#[derive(Clone, Copy, Debug, Default)]
pub struct Looked {
    /// About the flux that sets out to it \[W\].
    pub set_out: Rgb,
    /// How many places on it.
    pub places: u64,
}

impl Discovery {
    /// The flux \[W\] that the discovery may have missed with a probability of `risk` a shape, where it saw none.
    ///
    /// Half of a shape's places are spread by light: a part p of what sets out to it is missed by n of them with a probability of
    /// (1 − p/2)ⁿ at most, as far as a first surface's corners say how much light falls on it.
    pub fn unseen(&self, risk: f64) -> Rgb {
        let missed = self.looked.values().map(|one| {
            let part = 2.0 * (1.0 - risk.powf(1.0 / one.places.max(1) as f64));
            one.set_out * part.min(1.0)
        });
        missed.sum()
    }

    /// Whether nearly all light falls beside the film.
    pub(super) fn is_mostly_beside(&self) -> bool {
        let sum = |of: fn(&SignatureLight) -> f64| self.signatures.values().map(of).sum::<f64>();
        sum(|found| found.on_film) <= MOSTLY_BESIDE * sum(|found| found.flux)
    }

    /// Takes over what was not known yet.
    pub(super) fn learn(&mut self, signatures: BTreeMap<Signature, SignatureLight>) {
        for (signature, found) in signatures {
            let known = self.signatures.entry(signature).or_insert(found);
            known.peak = known.peak.max(found.peak);
            known.on_film = known.on_film.max(found.on_film);
        }
    }

    /// Floats are summed: always in the order of places, the same on any threads.
    pub(super) fn add(&mut self, sight: &LandedPath) {
        let one = self.signatures.entry(sight.signature).or_default();
        one.flux += sight.flux;
        one.peak = one.peak.max(sight.delivered);
        one.on_film += if sight.on_film { sight.flux } else { 0.0 };
    }
}
