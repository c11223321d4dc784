//! Conditions on materials and textures.

use super::{
    Coat, Color, Material, NormalTurn, Principled, PrincipledThin, Roughness, Scalar, SceneError,
    SceneParts, Texture, TextureId,
};
use crate::geometry::{Mesh, Shape};
use crate::radiometry::Rgb;

/// The first material that is wrong, by index, and its problem.
pub(super) fn first_problem(parts: &SceneParts) -> Option<(usize, String)> {
    let textures = parts.textures.iter().enumerate();
    if let Some((index, _)) = textures.into_iter().find(|(index, texture)| {
        matches!(texture, Texture::Scaled { nested, .. } if nested.0 as usize >= *index)
    }) {
        let message = format!("texture {index} scales a texture that does not come before it");
        return Some((usize::MAX, message));
    }
    parts
        .materials
        .iter()
        .enumerate()
        .find_map(|(index, material)| {
            let fail = |problem: String| Some((index, problem));
            // Wrappers refer only to materials declared before them, so there are no cycles.
            if let Some(id) = material.nested().find(|id| id.0 as usize >= index) {
                return fail(format!(
                    "material {index} ({}) wraps material {}, which must come before it",
                    material.plugin(),
                    id.0
                ));
            }
            let known = |id: &TextureId| (id.0 as usize) < parts.textures.len();
            if let Some(id) = textures_of(material).find(|id| !known(id)) {
                return fail(format!(
                    "bsdf \"{}\" refers to texture {} of {}",
                    material.plugin(),
                    id.0,
                    parts.textures.len()
                ));
            }
            let problem = problem_of(material)?;
            fail(format!("bsdf \"{}\": {problem}", material.plugin()))
        })
}

/// Checks that each shape has the mesh attributes that its material asks for.
pub(super) fn attributes(parts: &SceneParts) -> Result<(), SceneError> {
    for (shape, object) in parts.shapes.iter().zip(&parts.objects) {
        let mut materials = vec![object.material];
        while let Some(id) = materials.pop() {
            let material = &parts.materials[id.0 as usize];
            materials.extend(material.nested());
            for texture in textures_of(material) {
                let mut texture = &parts.textures[texture.0 as usize];
                while let Texture::Scaled { nested, .. } = texture {
                    texture = &parts.textures[nested.0 as usize];
                }
                let Texture::MeshAttribute { name, scale } = texture else {
                    continue;
                };
                let mesh = match shape {
                    Shape::Mesh(mesh) => Some(mesh),
                    _ => None,
                };
                let problem = match mesh.and_then(|mesh| mesh.attribute_range(name)) {
                    None => {
                        let there = mesh.into_iter().flat_map(Mesh::attribute_names);
                        let there: Vec<&str> = there.collect();
                        let there = if there.is_empty() {
                            "it has no attributes; a PLY file gives them, e.g. a vertex_color as r, g and b, \
                             or a vertex_heat as heat_0"
                                .to_owned()
                        } else {
                            format!("it has {}", there.join(", "))
                        };
                        format!("has no \"{name}\": {there}")
                    }
                    Some(range) if range.iter().all(|x| (0.0..=1.0).contains(&(x * scale))) => {
                        continue;
                    }
                    Some([low, high]) => format!(
                        "has numbers from {low} to {high} for \"{name}\" (scaled by {scale}); 0..=1 is allowed"
                    ),
                };
                return Err(SceneError {
                    at: object.declared_at.clone(),
                    message: format!("{} \"{}\" {problem}", object.plugin, object.id),
                });
            }
        }
    }
    Ok(())
}

/// The textures that a material itself refers to.
fn textures_of(material: &Material) -> impl Iterator<Item = TextureId> {
    let height = match material {
        Material::Turned {
            by: NormalTurn::Height { texture, .. },
            ..
        } => Some(*texture),
        _ => None,
    };
    let colors = material.colors().filter_map(|color| color.texture());
    let scalars = material.scalars().filter_map(|scalar| scalar.texture());
    colors.chain(scalars).chain(height)
}

/// True if finite and not below zero in every channel.
pub(super) fn non_negative(value: Rgb) -> bool {
    value.is_finite() && value.min_channel() >= 0.0
}

fn ior(name: &str, value: f64) -> Option<String> {
    // Beyond this, squared ratios of two indices would leave the range of f64.
    (!(1e-70..=1e70).contains(&value))
        .then(|| format!("{name} is {value}; numbers from 1e-70 to 1e70 are allowed"))
}

fn factor(name: &str, value: Rgb) -> Option<String> {
    (!(non_negative(value) && value.max_channel() <= 1.0))
        .then(|| format!("{name} is {:?}; numbers in 0..=1 are allowed", value.0))
}

fn color(name: &str, value: Color) -> Option<String> {
    match value {
        Color::Constant(value) => factor(name, value),
        Color::Texture(_) | Color::Unknown => None,
    }
}

fn roughness(roughness: &Roughness) -> Option<String> {
    [roughness.alpha_u, roughness.alpha_v]
        .into_iter()
        .find_map(|alpha| match alpha {
            // Beyond this, the fourth power would leave the range of f64.
            Scalar::Constant(alpha) if !(0.0..=1e70).contains(&alpha) => Some(format!(
                "alpha is {alpha}; numbers from 0 to 1e70 are allowed"
            )),
            _ => None,
        })
}

fn coat(coat: &Coat) -> Option<String> {
    ior("int_ior", coat.interior_ior)
        .or_else(|| ior("ext_ior", coat.exterior_ior))
        .or_else(|| color("diffuse_reflectance", coat.diffuse_reflectance))
        .or_else(|| color("specular_reflectance", coat.specular_reflectance))
}

fn share((name, share): (&str, Scalar)) -> Option<String> {
    match share {
        Scalar::Constant(number) => factor(name, Rgb::grey(number)),
        Scalar::Texture(_) => None,
    }
}

fn principled(material: &Principled) -> Option<String> {
    color("base_color", material.base_color)
        .or_else(|| ior("eta", material.eta))
        .or_else(|| material.scalars().into_iter().find_map(share))
}

fn principled_thin(sheet: &PrincipledThin) -> Option<String> {
    color("base_color", sheet.base_color)
        .or_else(|| ior("eta", sheet.eta))
        .or_else(|| sheet.shares().into_iter().find_map(share))
        .or_else(|| match sheet.diff_trans {
            Scalar::Constant(number) if !(0.0..=2.0).contains(&number) => Some(format!(
                "diff_trans is {number}; numbers in 0..=2 are allowed"
            )),
            _ => None,
        })
}

fn metal(eta: Rgb, k: Rgb) -> Option<String> {
    (!(non_negative(eta) && non_negative(k))).then(|| {
        format!(
            "eta is {:?} and k is {:?}; finite numbers >= 0 are allowed",
            eta.0, k.0
        )
    })
}

/// The unphysical property of a material, if there is one.
fn problem_of(material: &Material) -> Option<String> {
    match material {
        Material::Diffuse { reflectance } => color("reflectance", *reflectance),
        Material::Dielectric {
            interior_ior,
            exterior_ior,
            specular_reflectance,
            specular_transmittance,
        }
        | Material::ThinDielectric {
            interior_ior,
            exterior_ior,
            specular_reflectance,
            specular_transmittance,
        } => ior("int_ior", *interior_ior)
            .or_else(|| ior("ext_ior", *exterior_ior))
            .or_else(|| color("specular_reflectance", *specular_reflectance))
            .or_else(|| color("specular_transmittance", *specular_transmittance)),
        Material::RoughDielectric {
            interior_ior,
            exterior_ior,
            specular_reflectance,
            specular_transmittance,
            roughness: alpha,
        } => ior("int_ior", *interior_ior)
            .or_else(|| ior("ext_ior", *exterior_ior))
            .or_else(|| color("specular_reflectance", *specular_reflectance))
            .or_else(|| color("specular_transmittance", *specular_transmittance))
            .or_else(|| roughness(alpha)),
        Material::Conductor {
            eta,
            k,
            specular_reflectance,
        } => metal(*eta, *k).or_else(|| color("specular_reflectance", *specular_reflectance)),
        Material::RoughConductor {
            eta,
            k,
            specular_reflectance,
            roughness: alpha,
        } => metal(*eta, *k)
            .or_else(|| color("specular_reflectance", *specular_reflectance))
            .or_else(|| roughness(alpha)),
        Material::Plastic(plastic) => coat(plastic),
        Material::RoughPlastic {
            coat: plastic,
            alpha,
            ..
        } => coat(plastic).or_else(|| {
            (!(*alpha > 0.0 && *alpha <= 1e70))
                .then(|| format!("alpha is {alpha}; numbers above 0, up to 1e70, are allowed"))
        }),
        Material::Principled(material) => principled(material),
        Material::PrincipledThin(sheet) => principled_thin(sheet),
        Material::Blend { weight, .. } => share(("weight", *weight)),
        Material::Mask { opacity, .. } => match opacity {
            Scalar::Constant(opacity) if !(0.0..=1.0).contains(opacity) => Some(format!(
                "opacity is {opacity}; numbers in 0..=1 are allowed"
            )),
            _ => None,
        },
        Material::Turned {
            by: NormalTurn::Height { scale, .. },
            ..
        } => (!scale.is_finite()).then(|| format!("scale is {scale}; it must be finite")),
        Material::Null | Material::TwoSided { .. } | Material::Turned { .. } => None,
    }
}
