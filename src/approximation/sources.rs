//! Lights without size, from which a technique renders its pictures, and the surfaces that show irradiance.

use crate::geometry::Bounds;
use crate::numeric::math;
use crate::run::Refusal;
use crate::scene::{Emitter, Material, Scene};
use crate::transport::chain_limits::{check_blends, check_clear, check_even};
use crate::transport::first_surface::Source;

/// The lights of a scene, which must all be points or directions that shine evenly; `technique` names the
/// technique in the plural.
///
/// # Errors
///
/// If a medium absorbs light, an interface has a texture, an emitter has a size or throws an image, or none
/// shines; if a mirror or glass is part of a blend.
pub fn sources(scene: &Scene, technique: &str) -> Result<Vec<Source>, Refusal> {
    check_clear(scene)
        .and_then(|()| check_even(scene))
        .and_then(|()| check_blends(scene))
        .map_err(|error| Refusal::new(error.to_string()))?;
    let mut shining = scene
        .emitters()
        .iter()
        .filter(|emitter| !emitter.strength().is_black());
    if let Some(emitter) = shining.clone().find(|emitter| emitter.slide().is_some()) {
        return Err(Refusal::new(format!(
            "an emitter of plugin {} throws an image: {technique} are rendered from one point or direction that \
             shines evenly",
            emitter.plugin()
        )));
    }
    let refused = shining.find(|emitter| !emitter.is_delta() || emitter.shape().is_some());
    if let Some(plugin) = refused.map(Emitter::plugin) {
        return Err(Refusal::new(format!(
            "an emitter is of plugin {plugin}: {technique} are rendered from one point or direction; emitters of \
             plugin point, spot and directional are allowed"
        )));
    }
    let sources = Source::all(scene);
    if sources.is_empty() {
        return Err(Refusal::new(format!(
            "no emitter shines: {technique} are rendered from one of plugin point, spot or directional"
        )));
    }
    Ok(sources)
}

/// A bound on the flux \[W\] that falls on a box.
pub fn flux_bound(source: &Source, bounds: &Bounds) -> f64 {
    let strength = source.strength().max_channel();
    match source {
        Source::Parallel { .. } => strength * 4.0 * math::powi(bounds.radius(), 2),
        Source::Point { .. } => strength * 4.0 * std::f64::consts::PI,
    }
}

/// True if a camera sees irradiance on the material.
pub fn is_diffuse(scene: &Scene, material: &Material) -> bool {
    material.holds(scene.materials(), &|it| {
        matches!(it, Material::Diffuse { .. })
    })
}
