//! Reflectance of diffuse surfaces, bare or in wrappers.

use crate::radiometry::Rgb;
use crate::scene::{Color, Material, Scalar, Scene};

/// The share of light that a surface reflects diffusely on a side; `None` if it is not diffuse.
pub(crate) fn reflectance<'a>(
    scene: &'a Scene,
    mut material: &'a Material,
    front: bool,
) -> Option<Rgb> {
    let mut share = 1.0;
    // True on the front of a one-sided material, and on either side of a two-sided one.
    let mut is_lit = front;
    loop {
        match material {
            Material::Diffuse {
                reflectance: Color::Constant(reflectance),
            } => {
                return is_lit.then_some(*reflectance * share);
            }
            Material::Mask {
                opacity: Scalar::Constant(opacity),
                nested,
            } => {
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
            _ => return None,
        }
    }
}

/// True if a diffuse surface, perhaps in a wrapper, has a reflectance or an opacity that varies or is
/// unknown.
pub(super) fn has_unknown_reflectance(scene: &Scene, material: &Material) -> bool {
    let of = |id| has_unknown_reflectance(scene, scene.material(id));
    match material {
        Material::Diffuse { reflectance } => !matches!(reflectance, Color::Constant(_)),
        Material::Mask {
            opacity: Scalar::Texture(_),
            ..
        } => true,
        Material::Mask { .. } | Material::TwoSided { .. } => material.nested().any(of),
        _ => false,
    }
}
