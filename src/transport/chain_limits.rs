//! What of a scene specular chains leave out: photons, beams and probes follow smooth interfaces only.

use crate::scene::{Emitter, Material, MaterialId, Object, Scalar, Scene};

/// A scene that chains cannot be followed in.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "shape \"{shape}\" has a mask whose opacity is a texture: photons, beams and probes need one number; \
     paths from a camera do not"
)]
pub struct VaryingMask {
    /// The shape.
    pub shape: String,
}

/// Fails where a mask varies over its surface, which chains do not follow.
///
/// # Errors
///
/// The first such shape.
pub fn check_masks(scene: &Scene) -> Result<(), VaryingMask> {
    let varies = |material: &Material| {
        matches!(
            material,
            Material::Mask {
                opacity: Scalar::Texture(_),
                ..
            }
        )
    };
    match scene
        .objects()
        .iter()
        .find(|object| any(scene, object.material, &varies))
    {
        None => Ok(()),
        Some(object) => Err(VaryingMask {
            shape: object.id.clone(),
        }),
    }
}

/// An emitter that chains cannot start at.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "emitter {index} ({plugin}) {what}: photons, beams and probes start at points, directions and surfaces \
     that shine evenly; use --method path"
)]
pub struct UnfollowedLight {
    /// Which, in the file's order, from 0.
    pub index: usize,
    /// Mitsuba's name of the emitter.
    pub plugin: &'static str,
    /// What it does.
    pub what: &'static str,
}

/// Fails where light comes from all round, infinitely far away, or varies over a surface.
///
/// # Errors
///
/// The first such emitter that is not black.
pub fn check_emitters(scene: &Scene) -> Result<(), UnfollowedLight> {
    for (index, emitter) in scene.emitters().iter().enumerate() {
        let what = match emitter {
            _ if emitter.strength().is_black() => continue,
            Emitter::Constant { .. } | Emitter::Envmap(_) => "shines from all round",
            Emitter::Area {
                texture: Some(_), ..
            } => "has a texture",
            _ => continue,
        };
        return Err(UnfollowedLight {
            index,
            plugin: emitter.plugin(),
            what,
        });
    }
    Ok(())
}

/// What to warn of where light is followed along specular chains only: rough interfaces, and smooth ones
/// whose normals a texture turns. They receive and block light; what they reflect and
/// refract is left out.
pub fn left_out(scene: &Scene) -> Vec<String> {
    let is_rough = |object: &&Object| {
        scene
            .material(object.material)
            .is_rough_interface(scene.materials())
    };
    let shapes: Vec<String> = scene
        .objects()
        .iter()
        .filter(is_rough)
        .map(|object| named(scene, object))
        .collect();
    if shapes.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "light by way of {} is left out: rough interfaces and turned normals are no part of specular chains",
        listed(&shapes)
    )]
}

/// What to warn of where light on diffuse surfaces is connected to a camera: surfaces that scatter light
/// otherwise look black.
pub fn left_out_of_image(scene: &Scene) -> Vec<String> {
    let scatters = |material: &Material| {
        matches!(
            material,
            Material::Plastic(_)
                | Material::RoughPlastic { .. }
                | Material::RoughConductor { .. }
                | Material::RoughDielectric { .. }
                | Material::Turned { .. }
        )
    };
    let shapes: Vec<String> = scene
        .objects()
        .iter()
        .filter(|object| any(scene, object.material, &scatters))
        .map(|object| named(scene, object))
        .collect();
    if shapes.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "light on {} is not in the image: only light on diffuse surfaces is connected to the camera",
        listed(&shapes)
    )]
}

/// The first few, and how many more.
fn listed(shapes: &[String]) -> String {
    const NAMED: usize = 4;
    if shapes.len() <= NAMED {
        shapes.join(", ")
    } else {
        format!(
            "{} and {} more",
            shapes[..NAMED].join(", "),
            shapes.len() - NAMED
        )
    }
}

fn named(scene: &Scene, object: &Object) -> String {
    format!(
        "{} ({})",
        object.id,
        scene.material(object.material).plugin()
    )
}

/// Whether `test` holds for a material or anything it wraps.
fn any(scene: &Scene, id: MaterialId, test: &impl Fn(&Material) -> bool) -> bool {
    let material = scene.material(id);
    test(material) || material.nested().any(|id| any(scene, id, test))
}
