//! The features that a scene needs modelled, with reasons: methods skip the rest.

use super::{Boundary, Color, Emitter, Material, MaterialId, Object, Scene};
use crate::geometry::Shape;

/// One feature that a scene does or does not need modelled.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Requirement {
    /// Its name.
    pub feature: &'static str,
    /// True if the scene needs it.
    pub needed: bool,
    /// The cause in the scene.
    pub reason: String,
}

/// All features, always in the same order: for each, if the scene needs it, and why.
pub fn requirements(scene: &Scene) -> Vec<Requirement> {
    let specular = names(scene, |object| is_specular(scene, object));
    let opaque = names(scene, |object| {
        !is_specular(scene, object) && *scene.material(object.material) != Material::Null
    });
    let rough = names(scene, |object| {
        scene.material(object.material).is_glossy(scene.materials())
    });
    let coats = coats(scene);
    let may_refract = |object: &Object| {
        let material = scene.material(object.material);
        material.is_rough_interface(scene.materials())
    };
    let no_chain = if coats.needed {
        "nothing but coats or rough interfaces mirrors or refracts"
    } else if scene.objects().iter().any(may_refract) {
        "nothing mirrors or refracts without blur"
    } else {
        "nothing mirrors or refracts: there is no caustic"
    };
    let mut list = vec![
        item(
            "specular chains",
            &specular,
            "mirrors or refracts",
            no_chain,
        ),
        item(
            "rough interfaces",
            &rough,
            "mirrors or refracts with a blur: for photons and paths",
            "no interface is rough",
        ),
        coats,
        colour(scene),
        area_lights(scene),
        normal_lights(scene),
        environments(scene),
        item(
            "opaque surfaces",
            &opaque,
            "ends light paths and casts shadows",
            "nothing casts a shadow",
        ),
        item(
            "shading normals",
            &meshes(scene, crate::geometry::Mesh::has_vertex_normals),
            "is a specular mesh with interpolated normals",
            "every specular surface has its true normal",
        ),
        item(
            "filters at interfaces",
            &names(scene, |object| is_filtering(scene, object.material)),
            "scales light by specular_reflectance or specular_transmittance",
            "interfaces keep all light but what Fresnel's equations split",
        ),
        item(
            "metals",
            &names(scene, |object| {
                contains(
                    scene,
                    object.material,
                    &|material| matches!(material, Material::Conductor { eta, .. } if !eta.is_black()),
                )
            }),
            "absorbs part of the light it reflects",
            "no mirror absorbs",
        ),
        media(scene),
        item(
            "turned normals",
            &names(scene, |object| {
                let material = scene.material(object.material);
                material.is_turned_interface(scene.materials())
            }),
            "mirrors or refracts by normals of a texture: paths from a camera follow it, chains end there",
            "no texture turns the normals of what mirrors or refracts",
        ),
        item(
            "principled interfaces",
            &names(scene, |object| {
                let material = scene.material(object.material);
                material.is_principled_interface(scene.materials())
            }),
            "may mirror or refract: paths from a camera follow it, chains end there",
            "no principled material has metal or glass",
        ),
        blends(scene),
        masks(scene),
    ];
    list.push(dispersion(scene));
    list
}

fn masks(scene: &Scene) -> Requirement {
    let is_partial = |material: &Material| matches!(material, Material::Mask { opacity, .. } if opacity.is_partial());
    item(
        "partial masks",
        &names(scene, |object| {
            contains(scene, object.material, &is_partial)
        }),
        "lets part of the light pass",
        "surfaces are whole or absent",
    )
}

fn coats(scene: &Scene) -> Requirement {
    let is_one = |object: &Object| {
        let material = scene.material(object.material);
        material.has_coat(scene.materials())
    };
    item(
        "coats",
        &names(scene, is_one),
        "mirrors some percent over a matt base: for photons and paths",
        "no matt surface has a coat",
    )
}

fn blends(scene: &Scene) -> Requirement {
    let is_blend = |material: &Material| matches!(material, Material::Blend { .. });
    item(
        "blends",
        &names(scene, |object| contains(scene, object.material, &is_blend)),
        "blends materials: photons go on from its mirrors and glass, not from its rough parts",
        "no material is a blend",
    )
}

fn media(scene: &Scene) -> Requirement {
    let is_border = |object: &Object| object.boundary.is_some_and(Boundary::absorbs);
    item(
        "absorbing media",
        &names(scene, is_border),
        "bounds a medium that absorbs light on its way: for photons and paths",
        "no medium absorbs",
    )
}

fn dispersion(scene: &Scene) -> Requirement {
    let mut glasses: Vec<String> = scene
        .dispersion()
        .iter()
        .map(|one| format!("{} is {}", one.id, one.glass))
        .collect();
    glasses.dedup();
    Requirement {
        feature: "dispersion",
        needed: !glasses.is_empty(),
        reason: if glasses.is_empty() {
            "indices are given as one number each".to_owned()
        } else {
            format!(
                "{}: each photon has one wavelength, and three channels of any sign; for photons alone",
                glasses.join("; ")
            )
        },
    }
}

/// True if one channel can stand for red, green and blue.
pub fn is_achromatic(scene: &Scene) -> bool {
    scene.dispersion().is_empty() && is_grey(scene)
}

/// True if no emitter, no interface and no medium has a colour.
pub fn is_grey(scene: &Scene) -> bool {
    scene.emitters().iter().all(Emitter::is_grey)
        && scene.media().iter().all(|it| it.absorption.is_grey())
        && scene.objects().iter().all(|object| {
            scene
                .material(object.material)
                .is_achromatic(scene.materials())
        })
}

fn area_lights(scene: &Scene) -> Requirement {
    let areas = scene.emitters().iter().filter(|it| !it.is_delta());
    item(
        "area lights",
        &shapes_of(scene, areas),
        "shines from a surface: two more dimensions",
        "no emitter is a surface",
    )
}

fn normal_lights(scene: &Scene) -> Requirement {
    let along = scene.emitters().iter().filter(|it| it.is_delta());
    item(
        "light along normals",
        &shapes_of(scene, along),
        "shines along its normals: for photons and paths",
        "no surface shines along its normals",
    )
}

/// The ids of the shapes that shine, of some emitters.
fn shapes_of<'a>(scene: &'a Scene, emitters: impl Iterator<Item = &'a Emitter>) -> Vec<&'a str> {
    let shapes = emitters.filter_map(Emitter::shape);
    shapes
        .map(|shape| scene.objects()[shape.0 as usize].id.as_str())
        .collect()
}

fn environments(scene: &Scene) -> Requirement {
    let emitters = scene.emitters().iter();
    let plugins: Vec<&str> = emitters
        .filter(|emitter| emitter.is_environment())
        .map(Emitter::plugin)
        .collect();
    item(
        "environments",
        &plugins,
        "shines from all round: for photons and paths",
        "no light comes from all round",
    )
}

fn colour(scene: &Scene) -> Requirement {
    let coloured = names(scene, |object| {
        !scene
            .material(object.material)
            .is_achromatic(scene.materials())
    });
    let emitters = scene
        .emitters()
        .iter()
        .filter(|emitter| !emitter.is_grey())
        .count();
    let media = scene.media().iter();
    let media = media.filter(|it| !it.absorption.is_grey()).count();
    let counted =
        |count: usize, what: &str| (count > 0).then(|| format!("{count} coloured {what}"));
    let surfaces = item("", &coloured, "colours light", "").reason;
    let reasons = [
        (!surfaces.is_empty()).then_some(surfaces),
        counted(emitters, "emitter(s)"),
        counted(media, "medium(s)"),
        (!scene.dispersion().is_empty()).then(|| "wavelengths have colours".to_owned()),
    ];
    let reason = reasons.into_iter().flatten().collect::<Vec<_>>().join("; ");
    Requirement {
        feature: "colour",
        needed: !is_achromatic(scene),
        reason: if reason.is_empty() {
            "red, green and blue are the same: one channel is computed".to_owned()
        } else {
            reason
        },
    }
}

fn item(feature: &'static str, ids: &[&str], because: &str, otherwise: &str) -> Requirement {
    const NAMED: usize = 4;
    let reason = match ids.len() {
        0 => otherwise.to_owned(),
        n if n <= NAMED => format!("{} {because}", ids.join(", ")),
        n => format!(
            "{} and {} more: each {because}",
            ids[..NAMED].join(", "),
            n - NAMED
        ),
    };
    Requirement {
        feature,
        needed: !ids.is_empty(),
        reason,
    }
}

fn names(scene: &Scene, chosen: impl Fn(&Object) -> bool) -> Vec<&str> {
    scene
        .objects()
        .iter()
        .filter(|object| chosen(object))
        .map(|object| object.id.as_str())
        .collect()
}

fn meshes(scene: &Scene, chosen: impl Fn(&crate::geometry::Mesh) -> bool) -> Vec<&str> {
    scene
        .world()
        .shapes()
        .iter()
        .zip(scene.objects())
        .filter(|(shape, object)| {
            matches!(shape, Shape::Mesh(mesh) if chosen(mesh)) && is_specular(scene, object)
        })
        .map(|(_, object)| object.id.as_str())
        .collect()
}

fn is_specular(scene: &Scene, object: &Object) -> bool {
    scene
        .material(object.material)
        .is_specular(scene.materials())
}

fn is_filtering(scene: &Scene, id: MaterialId) -> bool {
    contains(scene, id, &|material| match material {
        Material::Dielectric {
            specular_reflectance,
            specular_transmittance,
            ..
        }
        | Material::ThinDielectric {
            specular_reflectance,
            specular_transmittance,
            ..
        } => *specular_reflectance != Color::WHITE || *specular_transmittance != Color::WHITE,
        Material::Conductor {
            specular_reflectance,
            ..
        } => *specular_reflectance != Color::WHITE,
        _ => false,
    })
}

/// True if `test` holds for a material or anything it wraps.
fn contains(scene: &Scene, id: MaterialId, test: &impl Fn(&Material) -> bool) -> bool {
    scene.material(id).holds(scene.materials(), test)
}
