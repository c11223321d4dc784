//! What diffuse surfaces, bare or in wrappers, make of light.

use crate::radiometry::Rgb;
use crate::scene::{Material, Scene};

/// The share of light that a surface reflects diffusely on a side; `None` where it is not diffuse.
pub(super) fn reflectance<'a>(
    scene: &'a Scene,
    mut material: &'a Material,
    front: bool,
) -> Option<Rgb> {
    let mut share = 1.0;
    // On the front of a one-sided material, or on any side of a two-sided one.
    let mut is_lit = front;
    loop {
        match material {
            Material::Diffuse { reflectance } => {
                return is_lit.then_some((*reflectance)? * share);
            }
            Material::Mask { opacity, nested } => {
                share *= opacity;
                material = scene.material(*nested);
            }
            Material::TwoSided {
                front: of_front,
                back,
            } => {
                material = scene.material(if front { *of_front } else { *back });
                is_lit = true;
            }
            Material::Dielectric { .. }
            | Material::ThinDielectric { .. }
            | Material::Conductor { .. }
            | Material::Null => return None,
        }
    }
}

/// Whether a diffuse surface, perhaps in a wrapper, has a reflectance that is not modelled.
pub(super) fn has_unknown_reflectance(scene: &Scene, material: &Material) -> bool {
    let of = |id| has_unknown_reflectance(scene, scene.material(id));
    match *material {
        Material::Diffuse { reflectance } => reflectance.is_none(),
        Material::Mask { nested, .. } => of(nested),
        Material::TwoSided { front, back } => of(front) || of(back),
        _ => false,
    }
}
