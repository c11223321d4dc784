//! Reflectance of diffuse surfaces, bare or in wrappers.

use crate::geometry::{Hit, SurfacePoint};
use crate::radiometry::Rgb;
use crate::scene::{Color, Material, MaterialId, Scalar, Scene, TexturePoint};
use crate::transport::chain_limits::is_unseen;

/// A diffuse surface as seen from one side.
enum DiffuseSide<'a> {
    Plain {
        color: &'a Color,
        /// The product of the opacities of masks over it, as far as they are the same everywhere.
        opacity: f64,
        /// The opacities of masks that vary.
        varying: Vec<Scalar>,
    },
    /// A blend of diffuse surfaces and smooth interfaces, perhaps in wrappers.
    Blend,
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
                return is_lit.then_some(DiffuseSide::Plain {
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
            Material::Blend { nested, .. } => {
                let is_seen = |id: &MaterialId| !is_unseen(scene, *id);
                let is_matt = |it: &Material| matches!(it, Material::Diffuse { .. });
                let is_diffuse =
                    nested.iter().all(is_seen) && material.holds(scene.materials(), &is_matt);
                return is_diffuse.then_some(DiffuseSide::Blend);
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
    let material = scene.material_of(hit.shape);
    let side = diffuse_side(scene, material, front)?;
    if let DiffuseSide::Plain {
        color: Color::Constant(color),
        opacity,
        varying,
    } = &side
        && varying.is_empty()
    {
        return Some(*color * *opacity);
    }
    let point = scene.world().with_uv(*point, hit);
    let at = TexturePoint::new(scene, hit, &point);
    let DiffuseSide::Plain {
        color,
        opacity,
        varying,
    } = side
    else {
        return Some(blended(scene, material, &at, (front, front)));
    };
    let varying = varying.iter();
    let share: f64 = varying
        .map(|mask| scene.scalar(*mask, &at).clamp(0.0, 1.0))
        .product();
    Some(scene.color(*color, &at) * (opacity * share))
}

/// The share of light that the diffuse parts of a material reflect on a side, `is_lit` if one-sided parts are
/// seen from their front.
fn blended(
    scene: &Scene,
    material: &Material,
    at: &TexturePoint,
    (front, is_lit): (bool, bool),
) -> Rgb {
    let of = |id: MaterialId, is_lit| blended(scene, scene.material(id), at, (front, is_lit));
    let share = |scalar: Scalar| scene.scalar(scalar, at).clamp(0.0, 1.0);
    match *material {
        Material::Diffuse { reflectance } if is_lit => scene.color(reflectance, at),
        Material::Mask { opacity, nested } => of(nested, is_lit) * share(opacity),
        Material::TwoSided {
            front: of_front,
            back,
        } => of(if front { of_front } else { back }, true),
        Material::Blend {
            weight,
            nested: [first, second],
        } => {
            let weight = share(weight);
            of(first, is_lit) * (1.0 - weight) + of(second, is_lit) * weight
        }
        _ => Rgb::BLACK,
    }
}

/// True if a surface is diffuse on a side, and not known to be black.
pub(super) fn may_reflect(scene: &Scene, shape: u32, front: bool) -> bool {
    match diffuse_side(scene, scene.material_of(shape), front) {
        None => false,
        Some(DiffuseSide::Blend) => true,
        Some(DiffuseSide::Plain { color, opacity, .. }) => {
            let is_dark = match color {
                Color::Constant(color) => color.is_black(),
                Color::Texture(_) => false,
                Color::Unknown => true,
            };
            !is_dark && opacity != 0.0
        }
    }
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
        }
        | Material::Blend {
            weight: Scalar::Texture(_),
            ..
        } => true,
        Material::Mask { .. } | Material::TwoSided { .. } | Material::Blend { .. } => {
            material.nested().any(of)
        }
        _ => false,
    }
}
