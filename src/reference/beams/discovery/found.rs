//! Results of a discovery.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use glam::DVec2;

use super::look::LandedPath;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::transport::signature::Signature;

/// Part of the landed light on the film below which the light beside it does not count: errors are measured
/// on the film.
const MOSTLY_BESIDE: f64 = 1.0 / 16.0;

/// The light of one signature, as a discovery found it.
#[derive(Clone, Debug, Default)]
pub struct SignatureLight {
    /// Flux \[W\] that it brings, about, mean of channels.
    pub flux: f64,
    /// Largest part of the light that sets out which a path delivers.
    pub peak: f64,
    /// Flux \[W\] of it that falls on the film, not beside it.
    pub on_film: f64,
    /// Paths that landed on the film.
    pub landings: Vec<Landing>,
}

/// The end of a path on the film.
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// Film coordinates, in texels.
    pub at: DVec2,
    /// Flux \[W\] that the path stands for.
    pub flux: f64,
}

/// The result of a discovery.
#[derive(Clone, Debug, Default)]
pub struct Discovery {
    /// Light that each signature brings to the sensor's surface.
    pub signatures: BTreeMap<Signature, SignatureLight>,
    /// Flux \[W\], about, that lands on the film and beside it.
    pub landed: f64,
    /// Density of single paths from each light to each shape, by their indices.
    pub looked: BTreeMap<(usize, u32), Looked>,
}

/// The density of places on a shape.
#[derive(Clone, Copy, Debug, Default)]
pub struct Looked {
    /// Flux \[W\], about, that sets out to it.
    pub set_out: Rgb,
    /// Number of places on it.
    pub places: u64,
}

impl SignatureLight {
    /// True if no path was seen to bring light to the film.
    pub fn is_beside(&self) -> bool {
        self.on_film == 0.0
    }

    /// Flux \[W\], about, that it may bring to the film: all that landed beside it, if none was seen there.
    pub fn may_bring(&self) -> f64 {
        if self.is_beside() {
            self.flux
        } else {
            self.on_film
        }
    }
}

impl Discovery {
    /// Flux \[W\] that the discovery may have missed with a probability of `risk` a shape, if it saw none.
    ///
    /// Half of a shape's places are spread by light. With a probability of (1 − p/2)ⁿ at most, n of them miss
    /// a part p of the light that sets out to it. That holds as far as a first surface's corners tell how
    /// much light falls on it.
    pub fn unseen(&self, risk: f64) -> Rgb {
        let missed = self.looked.values().map(|one| {
            let part = 2.0 * (1.0 - math::powf(risk, 1.0 / one.places.max(1) as f64));
            one.set_out * part.min(1.0)
        });
        missed.sum()
    }

    /// True if nearly all light falls beside the film.
    pub(super) fn is_mostly_beside(&self) -> bool {
        let sum = |of: fn(&SignatureLight) -> f64| self.signatures.values().map(of).sum::<f64>();
        sum(|found| found.on_film) <= MOSTLY_BESIDE * sum(|found| found.flux)
    }

    /// Takes over signatures that were not known yet.
    pub(super) fn learn(&mut self, signatures: BTreeMap<Signature, SignatureLight>) {
        for (signature, found) in signatures {
            match self.signatures.entry(signature) {
                Entry::Vacant(entry) => {
                    entry.insert(found);
                }
                Entry::Occupied(mut entry) => {
                    let known = entry.get_mut();
                    known.peak = known.peak.max(found.peak);
                    if found.on_film > known.on_film {
                        (known.on_film, known.landings) = (found.on_film, found.landings);
                    }
                }
            }
        }
    }

    /// Adds a path. Floats are summed: always in the order of places, the same on any threads.
    pub(super) fn add(&mut self, sight: &LandedPath) {
        let one = self.signatures.entry(sight.signature).or_default();
        one.flux += sight.flux;
        one.peak = one.peak.max(sight.delivered);
        if sight.on_film {
            one.on_film += sight.flux;
            let (at, flux) = (sight.at, sight.flux);
            one.landings.push(Landing { at, flux });
        }
    }
}
