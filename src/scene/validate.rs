//! What must hold of a scene as a whole.

use super::{Emitter, Material, Object, SceneError, SceneParts, SensorKind, ShapeId, Warning};
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
    for (index, material) in parts.materials.iter().enumerate() {
        // Wrappers refer only to materials declared before them, so there are no cycles.
        let nested = match material {
            Material::Mask { nested, .. } => vec![*nested],
            Material::TwoSided { front, back } => vec![*front, *back],
            _ => Vec::new(),
        };
        if let Some(id) = nested.iter().find(|id| id.0 as usize >= index) {
            return fail(format!(
                "material {index} ({}) wraps material {}, which must come before it",
                material.plugin(),
                id.0
            ));
        }
        if let Some(problem) = material_problem(material) {
            let at = parts
                .objects
                .iter()
                .find(|object| object.material.0 as usize == index)
                .map_or_else(|| file.clone(), |object| object.declared_at.clone());
            return Err(SceneError {
                at,
                message: format!("bsdf \"{}\": {problem}", material.plugin()),
            });
        }
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
    let known = |shape: &ShapeId| (shape.0 as usize) < parts.shapes.len();
    for emitter in &parts.emitters {
        if !non_negative(emitter.strength()) {
            return fail(format!(
                "emitter \"{}\": its strength is {:?}; finite numbers >= 0 are allowed",
                emitter.plugin(),
                emitter.strength().0
            ));
        }
        if let Emitter::Area { shape, .. } = emitter
            && !known(shape)
        {
            return fail(format!("an area emitter refers to shape {}", shape.0));
        }
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

/// Finite and not below zero in every channel.
fn non_negative(value: Rgb) -> bool {
    value.is_finite() && value.min_channel() >= 0.0
}

/// What is unphysical about a material, if anything.
fn material_problem(material: &Material) -> Option<String> {
    let ior = |name: &str, value: f64| {
        // Beyond this, squared ratios of two indices would leave the range of f64.
        (!(1e-70..=1e70).contains(&value))
            .then(|| format!("{name} is {value}; numbers from 1e-70 to 1e70 are allowed"))
    };
    let factor = |name: &str, value: Rgb| {
        (!(non_negative(value) && value.max_channel() <= 1.0))
            .then(|| format!("{name} is {:?}; numbers in 0..=1 are allowed", value.0))
    };
    match *material {
        Material::Diffuse { reflectance } => {
            reflectance.and_then(|reflectance| factor("reflectance", reflectance))
        }
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
        } => ior("int_ior", interior_ior)
            .or_else(|| ior("ext_ior", exterior_ior))
            .or_else(|| factor("specular_reflectance", specular_reflectance))
            .or_else(|| factor("specular_transmittance", specular_transmittance)),
        Material::Conductor {
            eta,
            k,
            specular_reflectance,
        } => (!(non_negative(eta) && non_negative(k)))
            .then(|| {
                format!(
                    "eta is {:?} and k is {:?}; finite numbers >= 0 are allowed",
                    eta.0, k.0
                )
            })
            .or_else(|| factor("specular_reflectance", specular_reflectance)),
        Material::Mask { opacity, .. } => (!(0.0..=1.0).contains(&opacity))
            .then(|| format!("opacity is {opacity}; numbers in 0..=1 are allowed")),
        Material::Null | Material::TwoSided { .. } => None,
    }
}

/// What is odd about the meshes, given what they are made of.
///
/// Degenerate and doubled faces matter on any surface. Open edges and inward orientation
/// matter where a material needs to know inside from outside: on a dielectric.
pub(super) fn mesh_warnings(
    shapes: &[Shape],
    objects: &[Object],
    materials: &[Material],
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for (shape, object) in shapes.iter().zip(objects) {
        let Shape::Mesh(mesh) = shape else { continue };
        let diagnostics = mesh.diagnose();
        let refracts = needs_inside(&materials[object.material.0 as usize], materials);
        warnings.extend(
            diagnostics
                .warnings(refracts)
                .into_iter()
                .map(|message| Warning {
                    at: Some(object.declared_at.clone()),
                    message: format!("{} \"{}\": {message}", object.plugin, object.id),
                }),
        );
    }
    warnings
}

/// Whether a material means different things inside and outside a solid.
fn needs_inside(material: &Material, all: &[Material]) -> bool {
    let of = |id: &super::MaterialId| needs_inside(&all[id.0 as usize], all);
    match material {
        Material::Dielectric {
            interior_ior,
            exterior_ior,
            ..
        } => interior_ior != exterior_ior,
        Material::Mask { nested, .. } => of(nested),
        Material::TwoSided { front, back } => of(front) || of(back),
        _ => false,
    }
}
