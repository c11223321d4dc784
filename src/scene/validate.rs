//! Conditions on a scene as a whole.

use super::emitter::MAX_SHINING_TRIANGLES;
use super::material_check::{self, non_negative};
use super::{
    Boundary, Color, Emitter, Material, MediumId, SceneError, SceneParts, SensorKind, ShapeId,
    Texture, TextureId, Warning,
};
use crate::geometry::Shape;
use crate::radiometry::Rgb;

/// Checks that every index refers to something and every number is in its physical range.
pub(super) fn check(parts: &SceneParts) -> Result<(), SceneError> {
    let file = super::SourcePosition {
        file: parts.path.clone(),
        line: 0,
        column: 0,
    };
    let fail = |message: String| {
        Err(SceneError {
            at: file.clone(),
            message,
        })
    };
    if parts.shapes.len() != parts.objects.len() {
        return fail(format!(
            "{} shapes but {} descriptions of shapes",
            parts.shapes.len(),
            parts.objects.len()
        ));
    }
    if let Some((index, problem)) = material_check::first_problem(parts) {
        let at = parts
            .objects
            .iter()
            .find(|object| object.material.0 as usize == index)
            .map_or_else(|| file.clone(), |object| object.declared_at.clone());
        return Err(SceneError {
            at,
            message: problem,
        });
    }
    for object in &parts.objects {
        if object.material.0 as usize >= parts.materials.len() {
            return Err(SceneError {
                at: object.declared_at.clone(),
                message: format!(
                    "shape \"{}\" refers to material {} of {}",
                    object.id,
                    object.material.0,
                    parts.materials.len()
                ),
            });
        }
    }
    material_check::attributes(parts)?;
    check_media(parts, &file)?;
    let known = |shape: &ShapeId| (shape.0 as usize) < parts.shapes.len();
    check_emitters(parts, &file)?;
    let mut shining: Vec<ShapeId> = parts.emitters.iter().filter_map(Emitter::shape).collect();
    shining.sort_unstable();
    if let Some(pair) = shining.windows(2).find(|pair| pair[0] == pair[1]) {
        return fail(format!(
            "shape {} has two emitters; one is allowed",
            pair[0].0
        ));
    }
    let environments = parts.emitters.iter().filter(|it| it.is_environment());
    if environments.count() > 1 {
        return fail("there are two environments; one is allowed".to_owned());
    }
    for sensor in &parts.sensors {
        if let SensorKind::IrradianceMeter { shape } = &sensor.kind
            && !known(shape)
        {
            return fail(format!(
                "sensor \"{}\" refers to shape {}",
                sensor.id, shape.0
            ));
        }
        let film = &sensor.film;
        let fits = |offset: u32, size: u32, full: u32| {
            size > 0 && offset.checked_add(size).is_some_and(|end| end <= full)
        };
        if !fits(film.crop.offset_x, film.crop.width, film.width)
            || !fits(film.crop.offset_y, film.crop.height, film.height)
        {
            return fail(format!(
                "sensor \"{}\": the crop {:?} must be a non-empty part of the film, {} x {} pixels",
                sensor.id, film.crop, film.width, film.height
            ));
        }
    }
    Ok(())
}

/// Checks that media absorb, and that surfaces bound media that are there.
fn check_media(parts: &SceneParts, file: &super::SourcePosition) -> Result<(), SceneError> {
    let is_wrong = |medium: &&super::Medium| !non_negative(medium.absorption);
    if let Some(medium) = parts.media.iter().find(is_wrong) {
        return Err(SceneError {
            at: file.clone(),
            message: format!(
                "medium \"{}\": its absorption is {:?}; finite numbers >= 0 are allowed",
                medium.id, medium.absorption.0
            ),
        });
    }
    let is_known = |medium: MediumId| medium.index().is_none_or(|it| it < parts.media.len());
    let bounds_unknown = |object: &&super::Object| {
        let sides = object.boundary.map(|it| [it.interior, it.exterior]);
        !sides.into_iter().flatten().all(is_known)
    };
    let unknown = |at: super::SourcePosition, what: String| {
        let count = parts.media.len();
        let message = format!("{what} a medium that is not among the {count} there are");
        Err(SceneError { at, message })
    };
    if let Some(object) = parts.objects.iter().find(bounds_unknown) {
        let at = object.declared_at.clone();
        return unknown(at, format!("shape \"{}\" bounds", object.id));
    }
    let is_in_unknown = |sensor: &&super::Sensor| !sensor.medium.is_none_or(is_known);
    match parts.sensors.iter().find(is_in_unknown) {
        None => Ok(()),
        Some(sensor) => unknown(file.clone(), format!("sensor \"{}\" is in", sensor.id)),
    }
}

/// Checks the emitters, one by one.
fn check_emitters(parts: &SceneParts, file: &super::SourcePosition) -> Result<(), SceneError> {
    let fail = |message: String| {
        Err(SceneError {
            at: file.clone(),
            message,
        })
    };
    let known = |shape: &ShapeId| (shape.0 as usize) < parts.shapes.len();
    for emitter in &parts.emitters {
        if !non_negative(emitter.strength()) {
            return fail(format!(
                "emitter \"{}\": its strength is {:?}; finite numbers >= 0 are allowed",
                emitter.plugin(),
                emitter.strength().0
            ));
        }
        if let Some(shape) = emitter.shape() {
            let plugin = emitter.plugin();
            if !known(&shape) {
                return fail(format!("an {plugin} emitter refers to shape {}", shape.0));
            }
            if emitter
                .texture()
                .is_some_and(|id| id.0 as usize >= parts.textures.len())
            {
                return fail(format!(
                    "the {plugin} emitter on shape {} has no such texture",
                    shape.0
                ));
            }
            let index = shape.0 as usize;
            let texture = emitter.texture();
            if let Some(problem) = texture.and_then(|id| texture_problem(parts, id, index)) {
                let object = &parts.objects[index];
                return Err(SceneError {
                    at: object.declared_at.clone(),
                    message: format!(
                        "the {plugin} emitter on shape \"{}\" ({}) {problem}",
                        object.id, object.plugin
                    ),
                });
            }
            if let (Emitter::DirectionalArea { .. }, Some(reason)) =
                (emitter, bent(&parts.shapes[index]))
            {
                let object = &parts.objects[index];
                return Err(SceneError {
                    at: object.declared_at.clone(),
                    message: format!(
                        "a directionalarea emitter is on shape \"{}\" ({}), {reason}; rectangle, disk, sphere, cube \
                         and meshes of at most {MAX_SHINING_TRIANGLES} triangles with flat faces are allowed",
                        object.id, object.plugin
                    ),
                });
            }
        }
    }
    Ok(())
}

/// What is wrong with a texture as light of a shape; `None` if all its values are finite and not negative.
fn texture_problem(parts: &SceneParts, id: TextureId, shape: usize) -> Option<String> {
    let factor = |name: &str, value: Rgb| {
        (!non_negative(value)).then(|| {
            format!(
                "has the {name} {:?} in its texture; finite numbers >= 0 are allowed",
                value.0
            )
        })
    };
    let later =
        || Some("has a texture that refers to a later one; earlier ones are allowed".to_owned());
    let Some(texture) = parts.textures.get(id.0 as usize) else {
        return Some(format!("refers to texture {}, which is not there", id.0));
    };
    match texture {
        Texture::Bitmap(bitmap) => bitmap
            .image
            .range()
            .into_iter()
            .find_map(|bound| factor("texel", Rgb(bound))),
        Texture::Checkerboard { color0, color1, .. } => [("color0", color0), ("color1", color1)]
            .into_iter()
            .find_map(|(name, color)| match color {
                Color::Constant(value) => factor(name, *value),
                Color::Texture(nested) if nested.0 < id.0 => texture_problem(parts, *nested, shape),
                Color::Texture(_) => later(),
                Color::Unknown => Some(format!("has an unknown {name} in its texture")),
            }),
        Texture::MeshAttribute { name, scale } => {
            let range = match &parts.shapes[shape] {
                Shape::Mesh(mesh) => mesh.attribute_range(name),
                _ => None,
            };
            match range {
                None => Some(format!(
                    "needs the mesh attribute \"{name}\", which is not there"
                )),
                Some(range) => range
                    .into_iter()
                    .find_map(|bound| factor(name, Rgb::grey(bound * scale))),
            }
        }
        Texture::Scaled { nested, scale } => factor("scale", *scale).or_else(|| {
            if nested.0 < id.0 {
                texture_problem(parts, *nested, shape)
            } else {
                later()
            }
        }),
    }
}

/// The reason why a shape cannot shine along its normals; `None` if it can. Light that converges, or whose
/// direction changes over a face, has no closed form on a receiver.
fn bent(shape: &Shape) -> Option<&'static str> {
    match shape {
        Shape::Rectangle(_) | Shape::Disk(_) => None,
        Shape::Sphere(sphere) => sphere.is_inward().then_some("whose normals point inward"),
        Shape::Cylinder(_) => Some("which is bent"),
        Shape::Mesh(mesh) if mesh.triangle_count() > MAX_SHINING_TRIANGLES => {
            Some("which has too many triangles")
        }
        Shape::Mesh(mesh) => {
            let mut faces = 0..mesh.triangle_count() as u32;
            let is_bent = faces.any(|face| mesh.even_shading_normal(face).is_none());
            is_bent.then_some("whose vertex normals differ within a face")
        }
    }
}

/// Warnings about meshes, given their materials, and about surfaces that bound media.
///
/// Degenerate and doubled faces matter on any surface. Open edges and inward orientation matter if a material
/// needs to know inside from outside: on a dielectric. The side of vertex normals matters if the mesh shines.
pub(super) fn mesh_warnings(parts: &SceneParts) -> Vec<Warning> {
    let mut warnings = open_borders(parts);
    let shines_at = |index: usize| {
        let is_its_own = |one: &Emitter| one.shape().is_some_and(|shape| shape.0 as usize == index);
        parts.emitters.iter().any(is_its_own)
    };
    for (index, (shape, object)) in parts.shapes.iter().zip(&parts.objects).enumerate() {
        let Shape::Mesh(mesh) = shape else { continue };
        let diagnostics = mesh.diagnose();
        let material = &parts.materials[object.material.0 as usize];
        let refracts = needs_inside(material, &parts.materials);
        let faces = if shines_at(index) {
            0..mesh.triangle_count() as u32
        } else {
            0..0
        };
        let opposed = faces.filter(|face| mesh.shining_side(*face) < 0.0).count();
        let turned = (opposed > 0).then(|| {
            format!("{opposed} of its faces shine to the side of their vertex normals, against the winding, as in Mitsuba")
        });
        warnings.extend(
            diagnostics
                .warnings(refracts)
                .into_iter()
                .chain(turned)
                .map(|message| Warning {
                    at: Some(object.declared_at.clone()),
                    message: format!("{} \"{}\": {message}", object.plugin, object.id),
                }),
        );
    }
    warnings
}

/// Warnings about surfaces that bound media and have an edge.
fn open_borders(parts: &SceneParts) -> Vec<Warning> {
    let is_open = |shape: &Shape| match shape {
        Shape::Sphere(_) => false,
        Shape::Rectangle(_) | Shape::Disk(_) | Shape::Cylinder(_) => true,
        Shape::Mesh(mesh) => !mesh.border().is_empty(),
    };
    let objects = parts.shapes.iter().zip(&parts.objects);
    let open = objects
        .filter(|(shape, object)| object.boundary.is_some_and(Boundary::absorbs) && is_open(shape));
    open.map(|(_, object)| Warning {
        at: Some(object.declared_at.clone()),
        message: format!(
            "{} \"{}\": bounds a medium and has an edge: light that gets round it is in the wrong medium",
            object.plugin, object.id
        ),
    })
    .collect()
}

/// True if a material means different things inside and outside a solid.
pub(super) fn needs_inside(material: &Material, all: &[Material]) -> bool {
    match material {
        Material::Dielectric {
            interior_ior,
            exterior_ior,
            ..
        }
        | Material::RoughDielectric {
            interior_ior,
            exterior_ior,
            ..
        } => interior_ior != exterior_ior,
        _ => material
            .nested()
            .any(|id| needs_inside(&all[id.0 as usize], all)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{MaterialId, Scene};
    use super::*;

    /// The parts of a shipped scene.
    fn parts() -> SceneParts {
        let scene = crate::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")]).unwrap();
        SceneParts {
            path: scene.path().to_owned(),
            shapes: scene.world().shapes().to_vec(),
            objects: scene.objects().to_vec(),
            materials: scene.materials().to_vec(),
            emitters: scene.emitters().to_vec(),
            sensors: scene.sensors().to_vec(),
            ..SceneParts::default()
        }
    }

    #[test]
    fn what_refers_to_something_that_is_not_there_is_refused() {
        type Break = fn(&mut SceneParts, MediumId);
        assert!(Scene::new(parts()).is_ok());
        let nowhere = MediumId::new(0);
        let broken: [(Break, &str); 6] = [
            (
                |parts, _| drop(parts.objects.pop()),
                "descriptions of shapes",
            ),
            (
                |parts, _| parts.objects[0].material = MaterialId(9),
                "refers to material 9 of",
            ),
            (
                |parts, interior| {
                    let exterior = MediumId::CLEAR;
                    parts.objects[0].boundary = Some(Boundary { interior, exterior });
                },
                "bounds a medium that is not among the 0 there are",
            ),
            (
                |parts, medium| parts.sensors[0].medium = Some(medium),
                "is in a medium that is not among the 0 there are",
            ),
            (
                |parts, _| {
                    let shape = ShapeId(9);
                    parts.sensors[0].kind = SensorKind::IrradianceMeter { shape };
                },
                "refers to shape 9",
            ),
            (
                |parts, _| parts.sensors[0].film.crop.width += 1,
                "must be a non-empty part of the film",
            ),
        ];
        for (broken, says) in broken {
            let mut parts = parts();
            broken(&mut parts, nowhere);
            let error = Scene::new(parts).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
