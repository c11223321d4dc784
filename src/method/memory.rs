//! Memory of films, texel by texel, before anything is traced.
//!
//! Each function says the bytes that a texel takes when a run takes most; scene and program come on top.
//! Files take next to nothing: their samples are computed while they are written.

use crate::scene::{Scene, Sensor, is_achromatic};
use crate::transport::path_class::PathClass;

/// Three `f64`.
const TRIPLE: u64 = 24;
/// Value and variance, or irradiance and standard error: two triples.
const PAIR: u64 = 2 * TRIPLE;
/// Value and bounds. The standard errors of a bounded layer are zero, in memory that nobody touches.
const BOUNDED: u64 = 3 * TRIPLE;
/// A picture's values as `f32`, its pixels, and the bytes of its file.
const PICTURE: u64 = 4 + 4 + 3;

/// Texels or pixels of a sensor's film.
pub(super) fn texels(sensor: &Sensor) -> u64 {
    u64::from(sensor.film.crop.width) * u64::from(sensor.film.crop.height)
}

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

/// Photons, with at most `max_layers` layers of one path signature.
pub(super) fn photons(channels: u64, max_layers: u64) -> u64 {
    // The layers with a signature, the one for the others, and their total.
    let films = max_layers + 2;
    // While photons fly: exact sums (see `Accumulator`), counts, direct light; combined rounds.
    let rounds = films * PAIR;
    let tracing = films * 40 * channels + 8 + PAIR + rounds;
    // Then all layers, `LD` too: value, standard error and bounds; counts, and factors of texels. Rounds are
    // still there.
    let estimate = (films + 1) * 2 * PAIR + 16;
    tracing.max(rounds + PAIR + estimate)
}

/// Photon maps: each layer twice, for the two radii, and perhaps seen in two ways; the bias.
pub(super) fn photon_maps(max_layers: u64) -> u64 {
    4 * photons(3, max_layers)
}

/// Beams, with at most `max_layers` layers of one path signature.
pub(super) fn beams(channels: u64, max_layers: u64) -> u64 {
    /// Flux and bar; a variance (see `Sums`).
    const SUMS: u64 = 2 * TRIPLE + 8;
    // The layers with a signature, the one for the others, and their total.
    let layers = max_layers + 2;
    // One signature's exact sums (three kinds by channel, and on coarser levels a third as many) and
    // uncertain flux (channels and spread), see `BeamFilm`; read as `Texel`s, from which `BoundedFlux` comes
    // and then its `Sums`.
    let film = 8 * (4 * channels) + 8 * (channels + 1);
    let bounded = 8 * (2 * channels + 1);
    let reading = bounded + SUMS.max(8 * (4 * channels + 1));
    // A layer stays until it is made anew. That of the others is the sum of its signatures: of it there are
    // the last pass's sums, the sum so far, and the next signature's. Direct light.
    let tracing = (layers + 2) * SUMS + film + reading + PAIR;
    // Then all layers, `LD` too, and their total: the sums of each go as it comes. The first layer comes
    // beside the sums of all. A bound on light that is not followed.
    let estimate = (layers + 1) * BOUNDED;
    let finishing = (layers - 1) * SUMS + 3 * BOUNDED + PAIR + 8;
    tracing.max(finishing).max(estimate + PAIR + 8 + PICTURE)
}

/// Paths: all classes lit.
pub(super) fn path() -> u64 {
    const CLASSES: u64 = PathClass::ALL.len() as u64;
    // A replicate's sums: three channels a class, and weights. Tiles come on top, a few at a time.
    let image = CLASSES * TRIPLE + 8;
    // A round's moments of each class and of their sum, and of the weights; rounds combined.
    let tracing = image + (CLASSES + 1) * (3 * TRIPLE + PAIR) + 2 * 8;
    let estimate = (CLASSES + 1) * PAIR + 8;
    let finishing = (CLASSES + 1) * PAIR + estimate;
    tracing.max(finishing)
}

/// All methods, one after the other, beside what was measured before.
pub(super) fn full() -> u64 {
    // Each class and their sum: value, standard error and bounds.
    const LAYERS: u64 = (PathClass::ALL.len() as u64 + 1) * 4 * TRIPLE;
    // Of two runs of photon maps: the bias and its standard error.
    let reports = 2 * PAIR;
    let largest = path().max(beams(3, 0)).max(photon_maps(0));
    LAYERS + reports + largest
}

/// Layers with bounds, computed in place: `layers` of them with their sum, and the picture.
pub(super) fn bounded_layers(layers: u64) -> u64 {
    (layers + 1) * BOUNDED + PICTURE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_alone_take_less_than_is_said() {
        // 40 bytes a texel and channel in each of the ten films of eight layers.
        assert!(photons(3, 8) > 10 * 120);
        assert!(photons(1, 8) > 10 * 40);
    }

    #[test]
    fn beams_take_their_sums_and_a_film() {
        // 56 bytes a texel in each of the ten sums, and of the one under way; 12 and 4 integers.
        assert!(beams(3, 8) > 11 * 56 + 8 * (12 + 4));
        assert!(beams(1, 8) > 11 * 56 + 8 * (4 + 2));
    }
}
