//! Reflectance of diffuse surfaces, bare or in wrappers.

use crate::geometry::{Hit, SurfacePoint};
use crate::radiometry::Rgb;
use crate::scene::{Color, Material, Scalar, Scene, TexturePoint};

/// A diffuse surface as seen from one side.
struct DiffuseSide<'a> {
    color: &'a Color,
    /// The product of the opacities of masks over it, as far as they are the same everywhere.
    opacity: f64,
    /// The opacities of masks that vary.
    varying: Vec<Scalar>,
}

/// The diffuse surface that a material has on a side; `None` if it has none.
fn diffuse_side<'a>(
    scene: &'a Scene,
    mut material: &'a Material,
    front: bool,
) -> Option<DiffuseSide<'a>> {
    let (mut share, mut varying) = (1.0, Vec::new());
    // True on the front of a one-sided material, and on either side of a two-sided one.
    let mut is_lit = front;
    loop {
        match material {
            Material::Diffuse { reflectance } => {
                return is_lit.then_some(DiffuseSide {
                    color: reflectance,
                    opacity: share,
                    varying,
                });
            }
            Material::Mask { opacity, nested } => {
                match opacity {
                    Scalar::Constant(opacity) => share *= opacity,
                    Scalar::Texture(_) => varying.push(*opacity),
                }
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

/// The share of light that a surface reflects diffusely on a side, at a point of it; `None` if it is not
/// diffuse there. Unknown colours are black.
///
/// `point` may be without `uv`, as [`World::bounce_point`](crate::geometry::World::bounce_point) is.
pub(crate) fn reflectance(
    scene: &Scene,
    hit: &Hit,
    point: &SurfacePoint,
    front: bool,
) -> Option<Rgb> {
    let side = diffuse_side(scene, scene.material_of(hit.shape), front)?;
    if let (Color::Constant(color), []) = (side.color, side.varying.as_slice()) {
        return Some(*color * side.opacity);
    }
    let point = scene.world().with_uv(*point, hit);
    let at = TexturePoint::new(scene, hit, &point);
    let varying = side.varying.iter();
    let share: f64 = varying
        .map(|mask| scene.scalar(*mask, &at).clamp(0.0, 1.0))
        .product();
    Some(scene.color(*side.color, &at) * (side.opacity * share))
}

/// True if a surface is diffuse on a side, and not known to be black.
pub(super) fn may_reflect(scene: &Scene, shape: u32, front: bool) -> bool {
    diffuse_side(scene, scene.material_of(shape), front).is_some_and(|side| {
        let is_dark = match side.color {
            Color::Constant(color) => color.is_black(),
            Color::Texture(_) => false,
            Color::Unknown => true,
        };
        !is_dark && side.opacity != 0.0
    })
}

/// True if a diffuse surface, perhaps in a wrapper, has a reflectance or an opacity that varies or is
/// unknown.
pub(super) fn has_varying_reflectance(scene: &Scene, material: &Material) -> bool {
    let of = |id| has_varying_reflectance(scene, scene.material(id));
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
