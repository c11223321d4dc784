//! Memory of films, texel by texel, before anything is traced.
//!
//! Each function says the bytes that a texel takes when a run takes most; scene and program come on top.
//! Files take next to nothing: their samples are computed while they are written.

use crate::reference::beams::scratch_bytes;
use crate::reference::path::KEPT_PIXELS;
use crate::run::cost::TRIPLE;
pub(super) use crate::run::cost::{texels, written};
use crate::scene::{Scene, Sensor, is_achromatic};
use crate::transport::signature::Signature;

/// Value and variance, or irradiance and standard error: two triples.
const PAIR: u64 = 2 * TRIPLE;
/// Value and bounds. The standard errors of a bounded layer are zero, in memory that nobody touches if it is
/// new.
const BOUNDED: u64 = 3 * TRIPLE;

/// Flux and bar of beams; a variance (see `Sums`).
const SUMS: u64 = 2 * TRIPLE + 8;

/// Bytes of a sensor's film, from those of a texel.
pub(super) fn film(sensor: &Sensor, bytes_a_texel: u64) -> u64 {
    texels(sensor).saturating_mul(bytes_a_texel)
}

/// Channels that light has on a sensor: 1 if all is grey. A camera may see coloured surfaces.
pub(super) fn channels(scene: &Scene, sensor: &Sensor) -> u64 {
    if is_achromatic(scene) && !sensor.is_camera() {
        1
    } else {
        3
    }
}

/// The layers of one path signature each, and whether there is one of all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layers {
    pub named: u64,
    pub has_others: bool,
}

impl Layers {
    /// As many as there can be.
    pub fn most(named: u64) -> Self {
        Self {
            named,
            has_others: true,
        }
    }

    /// Those that a pilot found, of at most so many. Where it found as many, there may be others, and where
    /// light goes to and fro in glass: there is no last of its signatures.
    pub fn found(named: &[Signature], most: usize) -> Self {
        let is_endless = named.iter().any(|signature| signature.len() > 2);
        Self {
            named: named.len() as u64,
            has_others: named.len() >= most || is_endless,
        }
    }

    /// Their number.
    pub fn count(self) -> u64 {
        self.named + u64::from(self.has_others)
    }
}

/// Photons.
pub(super) fn photons(channels: u64, layers: Layers) -> u64 {
    // Combined rounds of the layers, of the one for the others, lit or not, and of their total.
    let rounds = (layers.named + 2) * PAIR;
    // While photons fly: exact sums (see `Accumulator`) of what is lit and of the total, counts, direct
    // light.
    let tracing = (layers.count() + 1) * 40 * channels + 8 + PAIR + rounds;
    // Then the lit layers, `LD`, and the total: value, standard error and bounds; counts, and factors of
    // texels. The rounds of each go as it comes: the first comes beside all, the last beside the total's.
    let layer = 2 * PAIR;
    let first = rounds + layer;
    let last = (layers.count() + 1) * layer + PAIR;
    let all = (layers.count() + 2) * layer;
    tracing.max(first.max(last).max(all) + PAIR + 16)
}

/// Photon maps of so many layers, the one for the others included, of which some are lit, on a part of the
/// pixels.
pub(super) fn photon_maps(layers: u64, lit: u64, part: f64) -> u64 {
    // Combined rounds of all layers and their total, each with the other radius.
    let rounds = (layers + 1) * 2 * PAIR;
    // While photons fly: exact sums of three channels for both radii, in memory that is taken where light is.
    let sums = (lit + 1) * 2 * 3 * 40;
    // Then the layers and their total with bounds, one layer of differences at a time, the bias, and counts.
    let estimate = (lit + 1) * 2 * PAIR + PAIR + PAIR + 8;
    rounds + estimate.max((sums as f64 * part).ceil() as u64)
}

/// Largest vector \[bytes\] that the allocator may make of memory that was freed to it: glibc's largest
/// threshold (`M_MMAP_THRESHOLD`). Larger ones are new from the system, and back to it.
const RECYCLED: u64 = 32 << 20;

/// Beams on a film of so many texels. So many films of signatures are filled together.
pub(super) fn beams(channels: u64, layers: Layers, texels: u64, together: u64) -> u64 {
    // One signature's exact sums (three kinds by channel, and on coarser levels a third as many) and
    // uncertain flux (channels and spread), see `BeamFilm`; read as `FilmTexel`s, from which its `Sums` come.
    let film = 8 * (4 * channels) + 8 * (channels + 1);
    let reading = 8 * (4 * channels + 2) + SUMS;
    // A layer stays until it is made anew. That of the others is the sum of its signatures: of it there are
    // the last pass's sums, and the sum so far beside the next signature's. Direct light.
    let tracing =
        (layers.count() + u64::from(layers.has_others)) * SUMS + together * film + reading + PAIR;
    // Then all layers, `LD` too, and their total: the sums of each go as it comes. The first layer comes
    // beside the sums of all, the last one beside its own. A bound on light that is not followed.
    let first = layers.count() * SUMS + 3 * BOUNDED;
    let last = SUMS + (layers.count() + 2) * BOUNDED;
    let last = last + cleared(layers.count() + 2, texels).min(film + reading);
    tracing.max(first.max(last) + PAIR + 8)
}

/// Beams of so many layers, which take so many bytes, and photons for some of the light, with at most so many
/// named layers.
pub(super) fn beams_and_photons(channels: u64, layers: u64, beams: u64, named: u64) -> u64 {
    // It may be all of the light that photons measure, if time or a guard ends beams.
    let rest = Layers::most(named);
    // Photons come after beams. What is left of them, value, standard error and bounds of their layers and
    // total, and counts, is beside the end of beams; and a total with standard errors.
    let tracing = layers * SUMS + PAIR + photons(channels, rest);
    let finishing = beams + (rest.count() + 1) * 2 * PAIR + TRIPLE + 8;
    tracing.max(finishing)
}

/// Memory a texel of the standard errors of so many layers by beams, which are zero: new memory is zero
/// untouched, and that in which a film was is cleared for them.
fn cleared(layers: u64, texels: u64) -> u64 {
    if texels.saturating_mul(TRIPLE) < RECYCLED {
        layers * TRIPLE
    } else {
        0
    }
}

/// Memory that beams work in \[bytes\], for signatures of at most so many events.
pub(super) fn beam_scratch(channels: u64, events: u64) -> u64 {
    let each = if channels == 1 {
        scratch_bytes::<1>(events as usize)
    } else {
        scratch_bytes::<3>(events as usize)
    };
    rayon::current_num_threads() as u64 * each as u64
}

/// Paths of which so many classes are lit, in one round or in several.
pub(super) fn path(classes: u64, is_in_one: bool) -> u64 {
    // A replicate's sums: three channels a class, and weights.
    let image = classes * TRIPLE + 8;
    // A round's moments of each class and of their sum, and of the weights; rounds combined.
    let round = (classes + 1) * 3 * TRIPLE + 16;
    let rounds = (classes + 1) * PAIR;
    let estimate = (classes + 1) * PAIR + 8;
    // Before the first round ends there are none to be combined with.
    let tracing = image + round + if is_in_one { 0 } else { rounds };
    tracing.max(round + rounds).max(rounds + estimate)
}

/// The tiles' sums \[bytes\] that paths of so many classes keep until they are added to an image of so many
/// pixels.
pub(super) fn path_tiles(classes: u64, pixels: u64) -> u64 {
    pixels.min(KEPT_PIXELS as u64) * (classes * TRIPLE + 8)
}

/// The way in which a part of an image by all methods is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// By beams.
    Beams,
    /// By photons.
    Photons,
    /// By photon maps.
    PhotonMap,
}

/// All methods, one after the other: of the parts that are followed from emitters, by beams so many
/// signatures at once, and of so many classes by paths.
pub(super) fn full(
    followed: &[Part],
    together: u64,
    classes: u64,
    is_in_one: bool,
    texels: u64,
) -> u64 {
    // Value, standard error and bounds.
    const LAYER: u64 = 2 * PAIR;
    let all = Layers::most(0);
    let (mut kept, mut most) = (0, 0);
    for part in followed {
        // What the run takes; and what stays of it: its class and its total, counts. Of photon maps the bias
        // stays, too.
        let (run, stays) = match part {
            Part::Beams => (
                beams(3, all, texels, together),
                2 * BOUNDED + cleared(2, texels) + 8,
            ),
            Part::Photons => (photons(3, all), 2 * LAYER + 8),
            Part::PhotonMap => (photon_maps(1, 1, 1.0), 2 * LAYER + 8 + PAIR),
        };
        most = most.max(kept + run);
        kept += stays;
    }
    // Layers of paths with bounds, counts, and a copy of the total from which its error is found.
    let finishing = (classes + 2) * LAYER + 8;
    most.max(kept + path(classes, is_in_one).max(finishing))
}

/// Layers with bounds, computed in place: `layers` of them with their sum.
pub(super) fn bounded_layers(layers: u64) -> u64 {
    (layers + 1) * BOUNDED
}

/// Memory \[bytes\] of a run that takes so much, or of its files: layers with their total, of so many bytes a
/// texel and so many channels each, and counts.
pub(super) fn with_files(
    run: u64,
    sensor: &Sensor,
    layers: u64,
    [each, channels]: [u64; 2],
) -> u64 {
    run.max(written(sensor, layers * each + 8, layers * channels + 1))
}

/// Values with standard errors and bounds: bytes of a texel, and channels.
pub(super) const BOTH: [u64; 2] = [2 * PAIR, 12];
/// Values with bounds.
pub(super) const BOUNDS: [u64; 2] = [BOUNDED, 9];
/// Values with standard errors.
pub(super) const ERRORS: [u64; 2] = [PAIR, 6];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_alone_take_less_than_is_said() {
        // 40 bytes a texel and channel in each of the ten films of eight layers.
        assert!(photons(3, Layers::most(8)) > 10 * 120);
        assert!(photons(1, Layers::most(8)) > 10 * 40);
    }

    #[test]
    fn beams_take_their_sums_and_a_film() {
        // 56 bytes a texel in each of the nine sums, and of the one under way; 12 and 4 integers.
        assert!(beams(3, Layers::most(8), 1, 1) > 10 * 56 + 8 * (12 + 4));
        assert!(beams(1, Layers::most(8), 1, 1) > 10 * 56 + 8 * (4 + 2));
    }

    #[test]
    fn a_layer_less_takes_less_by_every_method() {
        let of = |named: u64| Layers {
            named,
            has_others: false,
        };
        for named in 0..8 {
            assert!(photons(1, of(named)) < photons(1, of(named + 1)));
            assert!(beams(1, of(named), 1, 1) < beams(1, of(named + 1), 1, 1));
            assert!(path(named, true) < path(named + 1, true));
            assert!(photon_maps(named, named, 0.0) < photon_maps(named + 1, named + 1, 0.0));
        }
        assert!(path(2, true) < path(2, false));
        assert!(
            full(&[Part::Beams], 1, 2, true, 1)
                < full(&[Part::Beams, Part::PhotonMap], 1, 2, true, 1)
        );
    }
}
