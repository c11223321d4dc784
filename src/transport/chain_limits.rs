//! Limits of chains in a scene: photons go on from smooth and rough interfaces and from coats, all others
//! from smooth interfaces only.

use super::media;
use crate::scene::{Boundary, Emitter, Material, MaterialId, Object, Scalar, Scene};

/// Reason why chains cannot be followed in a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotFollowed {
    /// A mask that varies over its surface.
    #[error(
        "shape \"{shape}\" has a mask whose opacity is a texture: photons, beams and probes need one number; \
         paths from a camera do not"
    )]
    VaryingMask {
        /// The shape.
        shape: String,
    },
    /// A smooth interface whose factors vary over its surface.
    #[error(
        "shape \"{shape}\" has a {plugin} with a texture: beams, probes and techniques need one colour; use --method \
         photons or --method path"
    )]
    VaryingInterface {
        /// The shape.
        shape: String,
        /// Mitsuba's name of its material, or of that inside a wrapper.
        plugin: &'static str,
    },
    /// A medium whose border lets light pass straight on, or that an emitter is in: direct light is absorbed.
    #[error(
        "{what} absorbs direct light, {why}: direct light on a receiver is measured in the clear; a camera sees it \
         by --method path"
    )]
    AbsorbsDirect {
        /// The medium, in words.
        what: String,
        /// Where it does so.
        why: String,
    },
    /// A medium, to methods that know none.
    #[error(
        "medium \"{medium}\" absorbs light on its way: beams, probes, closed forms and techniques know clear media \
         only; use --method photons or --method path"
    )]
    Absorbs {
        /// Its id.
        medium: String,
    },
    /// A blend with a mirror or glass, of a weight or factor that varies.
    #[error(
        "shape \"{shape}\" has a blendbsdf with a mirror or glass, whose weight or factor is a texture: photons, \
         beams and probes need one number; paths from a camera do not"
    )]
    VaryingBlend {
        /// The shape.
        shape: String,
    },
    /// A blend of materials that refract light in several directions.
    #[error(
        "shape \"{shape}\" has a blendbsdf of several materials that transmit light without blur: photons, beams \
         and probes follow one; paths from a camera follow all"
    )]
    BlendedGlass {
        /// The shape.
        shape: String,
    },
    /// A blend with a mirror or glass, for methods that start from cells of light.
    #[error(
        "shape \"{shape}\" has a blendbsdf with a mirror or glass: beams, probes and techniques need a surface \
         that is one or the other; use --method photons or --method path"
    )]
    BlendedInterface {
        /// The shape.
        shape: String,
    },
    /// A surface that shines along its normals.
    #[error(
        "emitter {index} ({plugin}) shines along the normals of a surface: beams, probes and techniques start at \
         points and directions without a border; use --method photons or --method path"
    )]
    AlongNormals {
        /// Index of the emitter in the file's order, from 0.
        index: usize,
        /// Mitsuba's name of the emitter.
        plugin: &'static str,
    },
    /// A point that shines through an image.
    #[error(
        "emitter {index} ({plugin}) throws an image: beams, probes and techniques start at points and directions \
         that shine evenly; use --method photons or --method path"
    )]
    ThrowsImage {
        /// Index of the emitter in the file's order, from 0.
        index: usize,
        /// Mitsuba's name of the emitter.
        plugin: &'static str,
    },
    /// An emitter that is all round.
    #[error(
        "emitter {index} ({plugin}) shines from all round: beams, probes and techniques start at points and \
         directions; use --method photons or --method path"
    )]
    AllRound {
        /// Index of the emitter in the file's order, from 0.
        index: usize,
        /// Mitsuba's name of the emitter.
        plugin: &'static str,
    },
}

/// Fails if photons cannot be followed: see [`NotFollowed`].
///
/// # Errors
///
/// The first shape that light is not followed by.
pub fn check(scene: &Scene) -> Result<(), NotFollowed> {
    check_masks(scene)?;
    check_direct(scene)
}

fn check_masks(scene: &Scene) -> Result<(), NotFollowed> {
    let mut objects = scene.objects().iter();
    objects.try_for_each(|object| check_material(scene, &object.id, object.material))
}

/// The same for methods whose light starts in as few dimensions as a point's, and changes with nothing but
/// its falloff: no environments, no images, no surfaces that shine along their normals, no media, no textured
/// interfaces. Nor may light that goes on be a share of a surface's, in a blend.
///
/// # Errors
///
/// The first shape or emitter that is not followed.
pub fn check_starts(scene: &Scene) -> Result<(), NotFollowed> {
    check_masks(scene)?;
    check_clear(scene)?;
    check_even(scene)?;
    check_blends(scene)?;
    if let Some((index, plugin)) = emitter(scene, |it| it.slide().is_some()) {
        return Err(NotFollowed::ThrowsImage { index, plugin });
    }
    if let Some((index, plugin)) = emitter(scene, shines_along_normals) {
        return Err(NotFollowed::AlongNormals { index, plugin });
    }
    match emitter(scene, Emitter::is_environment) {
        Some((index, plugin)) => Err(NotFollowed::AllRound { index, plugin }),
        None => Ok(()),
    }
}

/// Fails if the factors of a smooth interface vary over its surface.
///
/// # Errors
///
/// The first shape with such an interface.
pub fn check_even(scene: &Scene) -> Result<(), NotFollowed> {
    let mut objects = scene.objects().iter();
    let found = objects.find_map(|object| Some((object, varying(scene, object.material)?)));
    match found {
        None => Ok(()),
        Some((object, plugin)) => Err(NotFollowed::VaryingInterface {
            shape: object.id.clone(),
            plugin,
        }),
    }
}

/// The plugin of a smooth interface with a texture: a material, or one that it wraps. Chains end at turned
/// normals, with any material below them.
fn varying(scene: &Scene, id: MaterialId) -> Option<&'static str> {
    match scene.material(id) {
        material @ (Material::Dielectric { .. }
        | Material::ThinDielectric { .. }
        | Material::Conductor { .. }) => {
            let is_textured = material.colors().any(|color| color.texture().is_some());
            is_textured.then(|| material.plugin())
        }
        Material::Turned { .. } => None,
        material => material.nested().find_map(|nested| varying(scene, nested)),
    }
}

/// Fails if a medium absorbs light.
///
/// # Errors
///
/// The first medium.
pub fn check_clear(scene: &Scene) -> Result<(), NotFollowed> {
    match scene.media().first() {
        None => Ok(()),
        Some(medium) => Err(NotFollowed::Absorbs {
            medium: medium.id.clone(),
        }),
    }
}

/// Fails if a medium may absorb light on the straight way between an emitter and a surface.
fn check_direct(scene: &Scene) -> Result<(), NotFollowed> {
    let materials = scene.materials();
    let is_open = |object: &&Object| {
        let material = scene.material(object.material);
        object.boundary.is_some_and(Boundary::absorbs)
            && (material.is_passed(materials) || material.is_partly_passed(materials))
    };
    if let Some(object) = scene.objects().iter().find(is_open) {
        return Err(NotFollowed::AbsorbsDirect {
            what: format!("the medium at shape \"{}\"", object.id),
            why: "as light passes that straight on".to_owned(),
        });
    }
    match media::first_immersed(scene) {
        None => Ok(()),
        Some(index) => Err(NotFollowed::AbsorbsDirect {
            what: format!("the medium around emitter {index}"),
            why: format!("as the {} shines in it", scene.emitters()[index].plugin()),
        }),
    }
}

/// Fails if a shape blends a smooth interface with another material.
///
/// # Errors
///
/// The first such shape.
pub fn check_blends(scene: &Scene) -> Result<(), NotFollowed> {
    let is_one = |object: &&Object| {
        let material = scene.material(object.material);
        material.is_blended_interface(scene.materials())
    };
    match scene.objects().iter().find(is_one) {
        Some(object) => Err(NotFollowed::BlendedInterface {
            shape: object.id.clone(),
        }),
        None => Ok(()),
    }
}

fn shines_along_normals(emitter: &Emitter) -> bool {
    matches!(emitter, Emitter::DirectionalArea { .. })
}

/// The first emitter of a kind that is not black: its index and Mitsuba's name.
fn emitter(scene: &Scene, is_one: impl Fn(&Emitter) -> bool) -> Option<(usize, &'static str)> {
    let mut emitters = scene.emitters().iter().enumerate();
    let found = emitters.find(|(_, it)| is_one(it) && !it.strength().is_black())?;
    Some((found.0, found.1.plugin()))
}

/// Checks a material of a shape, and the materials it wraps.
fn check_material(scene: &Scene, shape: &str, id: MaterialId) -> Result<(), NotFollowed> {
    let material = scene.material(id);
    match material {
        Material::Mask {
            opacity: Scalar::Texture(_),
            ..
        } => {
            return Err(NotFollowed::VaryingMask {
                shape: shape.to_owned(),
            });
        }
        Material::Blend { weight, .. } if material.is_specular(scene.materials()) => {
            if weight.texture().is_some() || varying(scene, id).is_some() {
                return Err(NotFollowed::VaryingBlend {
                    shape: shape.to_owned(),
                });
            }
            let mut glasses = Vec::new();
            add_glasses(scene, id, &mut glasses);
            if glasses.len() > 1 {
                return Err(NotFollowed::BlendedGlass {
                    shape: shape.to_owned(),
                });
            }
        }
        // Chains end at turned normals, with any material below them.
        Material::Turned { .. } => return Ok(()),
        _ => {}
    }
    material
        .nested()
        .try_for_each(|nested| check_material(scene, shape, nested))
}

/// Adds the materials of a blend that transmit light without blur, each once.
fn add_glasses(scene: &Scene, id: MaterialId, glasses: &mut Vec<MaterialId>) {
    match scene.material(id) {
        Material::Dielectric { .. } | Material::ThinDielectric { .. } => {
            if !glasses.contains(&id) {
                glasses.push(id);
            }
        }
        Material::Turned { .. } => {}
        material => material
            .nested()
            .for_each(|nested| add_glasses(scene, nested, glasses)),
    }
}

/// Warnings for methods that follow light along specular chains only.
///
/// They name rough interfaces, and smooth ones whose normals a texture turns. These receive and block light,
/// but light that they reflect and refract is left out.
pub fn left_out(scene: &Scene) -> Vec<String> {
    let reason = "rough interfaces, coats and turned normals are no part of specular chains";
    let is_one = |it: &Material, all: &[Material]| {
        it.is_rough_interface(all) || it.holds(all, &Material::is_coat)
    };
    left_out_where(scene, is_one, reason)
}

/// The same for photons, which go on from rough interfaces and coats, but neither where a texture turns the
/// normal, nor from `principled`, nor from a rough part or a coat of a blend.
pub fn left_out_by_photons(scene: &Scene) -> Vec<String> {
    let reason = "photons do not go on where a texture turns the normal";
    let mut warnings = left_out_where(scene, Material::is_turned_interface, reason);
    let reason = "photons do not go on from principled; dielectric, roughdielectric and conductor send them on";
    warnings.extend(left_out_where(
        scene,
        Material::is_principled_interface,
        reason,
    ));
    let reason = "photons do not go on from the rough parts and coats of a blendbsdf, but from its conductor, \
                  dielectric and thindielectric";
    let is_one =
        |it: &Material, all: &[Material]| it.is_blended_gloss(all) || it.is_blended_coat(all);
    warnings.extend(left_out_where(scene, is_one, reason));
    warnings
}

/// The first shape with a rough interface, in words; `None` if there is none.
pub fn first_rough(scene: &Scene) -> Option<String> {
    first(scene, |it| it.is_glossy(scene.materials()))
}

/// The first shape with a coat that photons go on from, in words; `None` if there is none.
pub fn first_coat(scene: &Scene) -> Option<String> {
    first(scene, |it| it.has_coat(scene.materials()))
}

fn first(scene: &Scene, is_one: impl Fn(&Material) -> bool) -> Option<String> {
    let mut objects = scene.objects().iter();
    let object = objects.find(|object| is_one(scene.material(object.material)))?;
    Some(named(scene, object))
}

fn left_out_where(
    scene: &Scene,
    is_one: impl Fn(&Material, &[Material]) -> bool,
    reason: &str,
) -> Vec<String> {
    let shapes: Vec<String> = scene
        .objects()
        .iter()
        .filter(|object| is_one(scene.material(object.material), scene.materials()))
        .map(|object| named(scene, object))
        .collect();
    if shapes.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "light by way of {} is left out: {reason}",
        listed(&shapes)
    )]
}

/// Warnings for methods that connect light on diffuse surfaces to a camera: surfaces that scatter light in
/// another way look black.
pub fn left_out_of_image(scene: &Scene) -> Vec<String> {
    let shapes = scattering(scene, |material| {
        is_rough(material) || is_coated_or_turned(material)
    });
    if shapes.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "light on {} is not in the image: only light on diffuse surfaces is connected to the camera",
        listed(&shapes)
    )]
}

/// The shapes that scatter light in another way than diffuse ones, but for rough interfaces that are no part
/// of a blend.
pub fn unseen_but_rough(scene: &Scene) -> Vec<String> {
    let all = scene.materials();
    scattering(scene, |material| {
        is_coated_or_turned(material) || material.is_blended_gloss(all)
    })
}

fn is_rough(material: &Material) -> bool {
    matches!(
        material,
        Material::RoughConductor { .. } | Material::RoughDielectric { .. }
    )
}

/// True if any part of a material scatters light in another way than diffuse ones.
pub(super) fn is_unseen(scene: &Scene, id: MaterialId) -> bool {
    let test = |it: &Material| is_rough(it) || is_coated_or_turned(it);
    scene.material(id).holds(scene.materials(), &test)
}

/// What reflects by more than a matt surface or one interface: coats, `principled`, and turned normals.
fn is_coated_or_turned(material: &Material) -> bool {
    matches!(
        material,
        Material::Plastic(_)
            | Material::RoughPlastic { .. }
            | Material::Principled(_)
            | Material::PrincipledThin(_)
            | Material::Turned { .. }
    )
}

/// The shapes with a material for which `test` holds, or that wrap one.
fn scattering(scene: &Scene, test: impl Fn(&Material) -> bool) -> Vec<String> {
    let objects = scene.objects().iter();
    objects
        .filter(|object| {
            let material = scene.material(object.material);
            material.holds(scene.materials(), &test)
        })
        .map(|object| named(scene, object))
        .collect()
}

/// The first few shapes, and the number of the others.
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
