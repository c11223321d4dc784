//! Warnings of runs: the one place where they are written.

use crate::run::{Estimate, LayerName, Quantity};
use crate::scene::{Emitter, Scene, Sensor};
use crate::transport::chain_limits::{left_out, left_out_by_photons, left_out_of_image};
use crate::transport::signature::Signature;

/// The warning of a run that was stopped before anything was known; `what` is the light that it was to
/// measure.
pub(super) fn ended_before(first: &str, what: &str) -> String {
    format!("the run ended before the first {first} did: nothing is known of the {what}")
}

/// The warning of a run that used its budget without reaching the error asked for.
pub(super) const NOT_REACHED: &str = "the error asked for was not reached";

/// The warning of beams that ended by themselves.
pub(super) const BEAMS_GAVE_UP: &str = "beams ended: their first pass took far more work than its forecast. \
    Photons measure such light (--method photons). With --chaotic beams, beams go on";

/// The warning of closed forms that were stopped.
pub(super) const NOT_ALL_LAYERS: &str =
    "the run ended before its last layer did: layers are exact, and nothing is known of their sum";

/// Warnings of methods that follow light along specular chains: no caustic, and light that they leave out.
pub(super) fn of_chains(scene: &Scene, is_dark: bool) -> Vec<String> {
    let mut warnings = of_dark(is_dark);
    warnings.extend(left_out(scene));
    warnings
}

/// The same of photons, which go on from rough interfaces.
pub(super) fn of_photons(scene: &Scene, is_dark: bool) -> Vec<String> {
    let mut warnings = of_dark(is_dark);
    warnings.extend(left_out_by_photons(scene));
    warnings
}

fn of_dark(is_dark: bool) -> Vec<String> {
    let no_caustic = "no light was found that meets a surface which mirrors or refracts, and gets to the sensor: no \
                      caustic, only direct light";
    is_dark.then(|| no_caustic.to_owned()).into_iter().collect()
}

/// The warning of direct light that was not measured.
pub(super) fn unknown_direct(estimate: &Estimate) -> Option<String> {
    let direct = LayerName::Path(Signature::DIRECT);
    let is_unknown = estimate
        .layers
        .iter()
        .any(|layer| layer.name == direct && layer.is_unknown());
    is_unknown.then(|| {
        "the run ended before direct light (LD) was measured: nothing is known of it".to_owned()
    })
}

/// Warnings of methods that measure only light by way of mirrors and glass, on a camera. `is_everywhere` if
/// surfaces of any kind show it: photon maps are looked up wherever light scatters.
pub(super) fn of_camera(
    scene: &Scene,
    estimate: &Estimate,
    methods: &str,
    is_everywhere: bool,
) -> Vec<String> {
    if estimate.quantity != Quantity::Radiance {
        return Vec::new();
    }
    let mut warnings = if is_everywhere {
        Vec::new()
    } else {
        left_out_of_image(scene)
    };
    warnings.push(format!(
        "{methods} on a camera measure light by way of mirrors and glass only: direct light (LD) is not in the image"
    ));
    warnings
}

/// The warning of caustics that paths from a camera cannot find.
pub(super) fn out_of_reach(scene: &Scene) -> Option<String> {
    let has_specular = scene.objects().iter().any(|object| {
        let material = scene.material(object.material);
        material.has_delta(scene.materials())
    });
    let has_delta = scene.emitters().iter().any(Emitter::is_delta);
    (has_specular && has_delta).then(|| {
        "paths from a camera never find the caustics of lights that are a point or a direction: those are black in \
         this image, as in Mitsuba's `path`"
            .to_owned()
    })
}

/// The warning of a scene in which nothing shines.
pub(super) fn no_emitter(scene: &Scene) -> Option<String> {
    scene
        .emitters()
        .is_empty()
        .then(|| "the scene has no emitter: its image is black".to_owned())
}

/// The warning of paths that did not come to their end.
pub(super) fn cut_off(paths: u64) -> Option<String> {
    (paths > 0).then(|| {
        format!(
            "{paths} paths were cut off after 65536 surfaces: give a --max-depth, or a lower --rr-depth"
        )
    })
}

/// The refusal of a sensor that is no camera, in the words of methods that start there.
pub(super) fn no_camera(sensor: &Sensor) -> Option<String> {
    (!sensor.is_camera()).then(|| {
        format!(
            "sensor \"{}\" ({}): paths start at cameras; an irradiancemeter is filled by --method beams or photons",
            sensor.id,
            sensor.plugin()
        )
    })
}
