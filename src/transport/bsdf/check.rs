//! A check that the colours of all surfaces are known.

use crate::scene::{Color, MaterialId, Scene};

/// A surface whose colour is not known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "shape \"{shape}\" has a {plugin} whose colour is not known: its image is missing, or it is a spectrum \
     from a file, which is not modelled; give an image, an rgb or a float"
)]
pub struct UnknownColor {
    /// The shape.
    pub shape: String,
    /// Mitsuba's name of its material, or of that inside a wrapper.
    pub plugin: &'static str,
}

/// Fails if a surface has an unknown colour, which a [`Bsdf`](super::Bsdf) would take for black.
///
/// # Errors
///
/// The first shape with such a surface.
pub fn check_colors(scene: &Scene) -> Result<(), UnknownColor> {
    for object in scene.objects() {
        if let Some(plugin) = unknown(scene, object.material) {
            return Err(UnknownColor {
                shape: object.id.clone(),
                plugin,
            });
        }
    }
    Ok(())
}

/// The material, or the one it wraps, that has an unknown colour.
fn unknown(scene: &Scene, id: MaterialId) -> Option<&'static str> {
    let material = scene.material(id);
    if material.colors().any(|color| color == Color::Unknown) {
        return Some(material.plugin());
    }
    material.nested().find_map(|id| unknown(scene, id))
}
