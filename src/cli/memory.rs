//! Whether a film fits into memory, before anything is traced.

use anyhow::ensure;

use super::args::Method;
use super::sensor::is_camera;
use crate::film::Image;
use crate::scene::{Scene, Sensor, is_achromatic};
use crate::transport::path_class::PathClass;

/// Refuses films that no file or not this machine's free memory can hold.
///
/// `max_layers` is the most layers with a path signature of their own.
///
/// # Errors
///
/// With the size, what it takes, and what there is.
pub fn check_film(
    scene: &Scene,
    sensor: &Sensor,
    method: Method,
    max_layers: u32,
) -> anyhow::Result<()> {
    let film = &sensor.film;
    let most = Image::MAX_SIZE;
    ensure!(
        film.width.max(film.height) as usize <= most,
        "sensor \"{}\": a film of {} x {} texels; 1 to {most} each way are allowed",
        sensor.id,
        film.width,
        film.height
    );
    let needed = film_bytes(scene, sensor, method, max_layers);
    if let Some(available) = available_bytes() {
        ensure!(
            needed <= available,
            "sensor \"{}\": {} x {} texels with up to {max_layers} layers take about {:.1} GB of \
             memory, and {:.1} GB are free; a smaller film, a crop or fewer --layers take less",
            sensor.id,
            film.crop.width,
            film.crop.height,
            needed as f64 / 1e9,
            available as f64 / 1e9
        );
    }
    Ok(())
}

/// Memory \[bytes\] that a sensor's film takes when a run takes most, files and all; scene and program come on top.
///
/// `max_layers` is the most layers with a path signature of their own.
pub fn film_bytes(scene: &Scene, sensor: &Sensor, method: Method, max_layers: u32) -> u64 {
    let film = &sensor.film;
    let texels = u64::from(film.crop.width) * u64::from(film.crop.height);
    // A camera may see coloured surfaces.
    let is_grey = is_achromatic(scene) && !is_camera(sensor);
    let channels = if is_grey { 1 } else { 3 };
    let bytes_a_texel = match method {
        Method::Photons => photons(channels, u64::from(max_layers)),
        Method::Beams => beams(channels, u64::from(max_layers)),
        Method::Path => path(),
        // Each layer twice, for the two radii, and perhaps seen in two ways; the bias.
        Method::PhotonMap => 4 * photons(3, u64::from(max_layers)),
        Method::Full => full(),
        Method::CausticMap => caustic_map(),
    };
    texels.saturating_mul(bytes_a_texel)
}

/// Three `f64`.
const TRIPLE: u64 = 24;
/// Value and variance, or irradiance and standard error: two triples.
const PAIR: u64 = 2 * TRIPLE;

/// Memory \[bytes\] that a texel takes when a run of photons takes most.
fn photons(channels: u64, max_layers: u64) -> u64 {
    // The layers with a signature, the one for the others, and their total.
    let films = max_layers + 2;
    // While photons fly: exact sums (see `Accumulator`), counts, direct light; combined rounds.
    let rounds = films * PAIR;
    let tracing = films * 40 * channels + 8 + PAIR + rounds;
    // Then all layers, `LD` too, with rounds still there, ...
    let estimate = (films + 1) * PAIR + 8;
    // ... and as `f32`: in the image, in the encoder, and in the file's bytes.
    let files = 3 * ((films + 1) * PAIR / 2 + 4);
    tracing.max(rounds + PAIR + estimate).max(estimate + files)
}

/// Memory \[bytes\] that a texel takes when a run of beams takes most.
fn beams(channels: u64, max_layers: u64) -> u64 {
    /// Mean, deviations and bar; two variances (see `Average`).
    const AVERAGE: u64 = 3 * TRIPLE + 2 * 8;
    /// Flux and bar; a variance (see `Sums`).
    const SUMS: u64 = 2 * TRIPLE + 8;
    /// Value, standard error and bounds.
    const LAYER: u64 = 4 * TRIPLE;
    // The layers with a signature, the one for the others, and their total.
    let layers = max_layers + 2;
    // One signature's exact sums (three kinds by channel) and uncertain flux (channels and spread), see
    // `BeamFilm`; read as `Texel`s, from which `BoundedFlux` comes and then its `Sums`.
    let film = 8 * (3 * channels) + 8 * (channels + 1);
    let bounded = 8 * (2 * channels + 1);
    let reading = bounded + SUMS.max(8 * (4 * channels + 1));
    // The pass before stays until the one under way is done: averages twice. Sums of all signatures, and of
    // those without a layer; direct light.
    let tracing = 2 * layers * AVERAGE + 2 * SUMS + film + reading + PAIR;
    // Then all layers, `LD` too, beside the last pass, ...
    let estimate = (layers + 2) * LAYER + 8;
    let finishing = layers * AVERAGE + PAIR + estimate;
    // ... and as `f32`: in the image, in the encoder, and in the file's bytes.
    let files = 3 * (layers + 1) * LAYER / 2;
    tracing.max(finishing).max(estimate + files)
}

/// Memory \[bytes\] that a texel takes when a run of paths takes most: all classes of paths lit.
fn path() -> u64 {
    const CLASSES: u64 = PathClass::ALL.len() as u64;
    // A replicate's sums: three channels a class, and weights. Tiles come on top, a few at a time.
    let image = CLASSES * TRIPLE + 8;
    // A round's moments of each class and of their sum, and of the weights; rounds combined.
    let tracing = image + (CLASSES + 1) * (3 * TRIPLE + PAIR) + 2 * 8;
    let estimate = (CLASSES + 1) * PAIR + 8;
    let finishing = (CLASSES + 1) * PAIR + estimate;
    let files = 3 * (CLASSES + 1) * PAIR / 2;
    tracing.max(finishing).max(estimate + files)
}

/// Memory \[bytes\] that a texel takes when a run of all methods takes most: one after the other, beside what was measured
/// before, and in the end files.
fn full() -> u64 {
    // Each class and their sum: value, standard error and bounds.
    const LAYERS: u64 = (PathClass::ALL.len() as u64 + 1) * 4 * TRIPLE;
    // Of two runs of photon maps: the bias and its standard error.
    let reports = 2 * PAIR;
    let largest = path().max(beams(3, 0)).max(4 * photons(3, 0));
    LAYERS + reports + largest.max(3 * LAYERS / 2)
}

/// Memory \[bytes\] that a texel takes when a caustic map is looked up: exact sums, values of two frames, the estimate's two layers
/// and files. The map itself is not the film's.
fn caustic_map() -> u64 {
    TRIPLE + 2 * TRIPLE + 2 * PAIR + 3 * PAIR
}

/// Memory that can be had without swapping, where the system says (Linux).
fn available_bytes() -> Option<u64> {
    parse_available(&std::fs::read_to_string("/proc/meminfo").ok()?)
}

fn parse_available(meminfo: &str) -> Option<u64> {
    let line = meminfo
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_word_on_free_memory_is_understood() {
        let text = "MemTotal:       16000000 kB\nMemAvailable:    8000000 kB\n";
        assert_eq!(parse_available(text), Some(8_000_000 * 1024));
        for text in ["", "MemAvailable: x kB", "MemAvailable: 5", "MemFree: 1 kB"] {
            assert_eq!(parse_available(text), None, "{text}");
        }
    }

    #[test]
    fn sums_alone_take_less_than_is_said() {
        // 40 bytes a texel and channel in each of the ten films of eight layers.
        assert!(photons(3, 8) > 10 * 120);
        assert!(photons(1, 8) > 10 * 40);
    }

    #[test]
    fn beams_take_two_passes_averages_and_a_film() {
        // 88 bytes a texel in each of the ten averages, of two passes; 12 and 4 integers.
        assert!(beams(3, 8) > 2 * 10 * 88 + 8 * (9 + 4));
        assert!(beams(1, 8) > 2 * 10 * 88 + 8 * (3 + 2));
        // What photons take is no measure of it.
        assert!(
            beams(1, 8) > 3 * photons(1, 8) / 2,
            "{} {}",
            beams(1, 8),
            photons(1, 8)
        );
    }
}
