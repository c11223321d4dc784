//! What a caustic map demands of a scene, and what it is of the scene that it needs.
//!
//! # Errors
//!
//! Of each function: where the scene does not have it, by name.

use super::buffers::{is_inside, takes_part};
use super::settings::{Mode, Settings};
use crate::approximation::ApproximationError;
use crate::geometry::Bounds;
use crate::scene::{Emitter, Material, Scene};
use crate::transport::first_surface::Source;

/// The mode asked for, or refraction where something refracts.
pub fn mode(settings: &Settings, scene: &Scene) -> Result<Mode, ApproximationError> {
    let has = |mode| {
        scene
            .objects()
            .iter()
            .any(|object| takes_part(scene, scene.material(object.material), mode))
    };
    let mode = settings.mode.unwrap_or(if has(Mode::Refraction) {
        Mode::Refraction
    } else {
        Mode::Reflection
    });
    let (does, plugins) = match mode {
        Mode::Refraction => ("refracts", "dielectric or thindielectric"),
        Mode::Reflection => ("mirrors", "conductor, dielectric or thindielectric"),
    };
    if has(mode) {
        Ok(mode)
    } else {
        Err(ApproximationError::NoSpecular {
            mode: mode.name(),
            does,
            plugins,
        })
    }
}

/// The lights, which must all be points or directions.
pub fn sources(scene: &Scene) -> Result<Vec<Source>, ApproximationError> {
    let refused = scene
        .emitters()
        .iter()
        .find(|emitter| !emitter.is_delta() && !emitter.strength().is_black());
    if let Some(emitter) = refused.map(Emitter::plugin) {
        return Err(ApproximationError::Emitter { plugin: emitter });
    }
    let sources = Source::all(scene);
    if sources.is_empty() {
        return Err(ApproximationError::NoEmitter);
    }
    Ok(sources)
}

/// Refuses points inside a refractor: their light crosses one interface.
pub fn check_outside(scene: &Scene, sources: &[Source]) -> Result<(), ApproximationError> {
    for source in sources {
        let Source::Point { origin, .. } = *source else {
            continue;
        };
        let found = (0_u32..).zip(scene.objects()).find(|(shape, object)| {
            let material = scene.material(object.material);
            takes_part(scene, material, Mode::Refraction) && is_inside(scene, *shape, origin)
        });
        if let Some((_, object)) = found {
            return Err(ApproximationError::LightInside {
                position: origin.to_array(),
                shape: object.id.clone(),
            });
        }
    }
    Ok(())
}

/// A bound on the flux \[W\] that falls on a box.
pub fn flux_bound(source: &Source, bounds: &Bounds) -> f64 {
    let strength = source.strength().max_channel();
    match source {
        Source::Parallel { .. } => strength * 4.0 * bounds.radius().powi(2),
        _ => strength * 4.0 * std::f64::consts::PI,
    }
}

/// Whether a camera sees irradiance on it.
pub fn is_diffuse(scene: &Scene, material: &Material) -> bool {
    matches!(material, Material::Diffuse { .. })
        || material
            .nested()
            .any(|id| is_diffuse(scene, scene.material(id)))
}
