//! Demands of a caustic map on a scene. Errors name what the scene does not have.

use super::buffers::{is_inside, is_open, takes_part};
use super::settings::Settings;
use super::variants::Mode;
use crate::run::Refusal;
use crate::scene::Scene;
use crate::setting::Words;
use crate::transport::first_surface::Source;

/// The plural of the technique, in errors.
pub(super) const MAPS: &str = "caustic maps";

/// The mode asked for. Without one: refraction where a closed shape refracts, through one interface where
/// only open ones do, reflection where nothing refracts.
pub fn mode(settings: &Settings, scene: &Scene) -> Result<Mode, Refusal> {
    let shapes_of = |mode| {
        let objects = (0_usize..).zip(scene.objects());
        objects.filter(move |(_, object)| takes_part(scene, scene.material(object.material), mode))
    };
    let has = |mode| shapes_of(mode).next().is_some();
    let is_closed = |shape: usize| !is_open(&scene.world().shapes()[shape]);
    let mode = settings.mode.unwrap_or_else(|| {
        if !has(Mode::Refraction) {
            Mode::Reflection
        } else if shapes_of(Mode::Refraction).any(|(shape, _)| is_closed(shape)) {
            Mode::Refraction
        } else {
            Mode::SingleRefraction
        }
    });
    let (does, plugins) = match mode {
        Mode::Refraction | Mode::SingleRefraction => ("refracts", "dielectric or thindielectric"),
        Mode::Reflection => ("mirrors", "conductor, dielectric or thindielectric"),
    };
    if has(mode) {
        Ok(mode)
    } else {
        Err(Refusal::new(format!(
            "no shape {does}: mode={} needs one of plugin {plugins}",
            mode.word()
        )))
    }
}

/// Refuses points inside a refractor: their light crosses one interface.
pub fn check_outside(scene: &Scene, sources: &[Source]) -> Result<(), Refusal> {
    for source in sources {
        let Source::Point { origin, .. } = *source else {
            continue;
        };
        let found = (0_u32..).zip(scene.objects()).find(|(shape, object)| {
            let material = scene.material(object.material);
            takes_part(scene, material, Mode::Refraction) && is_inside(scene, *shape, origin)
        });
        if let Some((_, object)) = found {
            return Err(Refusal::new(format!(
                "the emitter at ({}, {}, {}) is inside shape \"{}\": a caustic map's light crosses two interfaces, \
                 from outside in and out again",
                origin.x, origin.y, origin.z, object.id
            )));
        }
    }
    Ok(())
}
