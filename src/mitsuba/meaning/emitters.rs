//! The meaning of `<emitter>`, which becomes an [`Emitter`].

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::field_of_view::{horizontal_fov, must_be_rigid};
use super::plugin::Plugin;
use super::spectra::{self, Role};
use super::sunsky;
use super::textures::Textures;
use crate::film::bitmap::{Bitmap, BitmapEncoding};
use crate::geometry::Transform;
use crate::mitsuba::error::LoadError;
use crate::mitsuba::files::Files;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Tree};
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::scene::{BitmapTexture, Emitter, Envmap, EnvmapError, ShapeId, Slide, Texture, Warning};
use crate::setting::did_you_mean;

/// Every plugin that becomes an emitter.
const MODELLED: [&str; 9] = [
    "area",
    "constant",
    "directional",
    "directionalarea",
    "envmap",
    "point",
    "projector",
    "spot",
    "sunsky",
];

/// The half angle of a `spot` if the file gives none, in degrees.
const DEFAULT_CUTOFF: f64 = 20.0;

/// An emitter that belongs to the scene.
pub fn read(
    tree: &Tree,
    emitter: ObjectIndex,
    textures: &mut Textures,
    files: &mut Files,
    warnings: &mut Vec<Warning>,
) -> Result<Emitter, LoadError> {
    let plugin = Plugin::new(tree, emitter);
    let result = match plugin.name() {
        "point" => point(tree, &plugin)?,
        "spot" => spot(tree, &plugin, textures, files)?,
        "projector" => projector(tree, &plugin, textures, files)?,
        "directional" => directional(tree, &plugin)?,
        "constant" => constant(tree, &plugin)?,
        "envmap" => envmap(&plugin, files, warnings)?,
        "sunsky" => sunsky::read(tree, &plugin, warnings)?,
        "area" | "directionalarea" => {
            return Err(plugin.error("must be inside the shape that shines"));
        }
        _ => return Err(not_modelled(&plugin)),
    };
    finish(plugin)?;
    Ok(result)
}

/// An emitter that belongs to a shape.
///
/// Its `radiance` may be a texture. That of a `directionalarea` is a radiant exitance: Mitsuba multiplies it
/// by the shape's area, without the π of light in all directions.
pub fn read_area(
    tree: &Tree,
    emitter: ObjectIndex,
    shape: ShapeId,
    textures: &mut Textures,
    files: &mut Files,
) -> Result<Emitter, LoadError> {
    let plugin = Plugin::new(tree, emitter);
    let is_parallel = match plugin.name() {
        "area" => false,
        "directionalarea" => true,
        name if MODELLED.contains(&name) => {
            return Err(plugin.error("cannot be inside a shape; only area and directionalarea can"));
        }
        _ => return Err(not_modelled(&plugin)),
    };
    let texture = textures.emission(tree, &plugin, "radiance", files)?;
    let radiance = match texture {
        Some(_) => Rgb::WHITE,
        None => strength(tree, &plugin, "radiance")?,
    };
    finish(plugin)?;
    Ok(if is_parallel {
        Emitter::DirectionalArea {
            shape,
            exitance: radiance,
            texture,
        }
    } else {
        Emitter::Area {
            shape,
            radiance,
            texture,
        }
    })
}

fn not_modelled(plugin: &Plugin) -> LoadError {
    let hint = did_you_mean(plugin.name(), MODELLED);
    plugin.error(format!(
        "is not modelled{hint}; modelled emitters are: {}",
        MODELLED.join(", ")
    ))
}

fn finish(plugin: Plugin) -> Result<(), LoadError> {
    // The weight changes no expected value, only how often an emitter is sampled. With weight 0, a point or a
    // direction would be dark in Mitsuba.
    plugin.positive_or("sampling_weight", 1.0)?;
    // Read with the scene's media.
    plugin.children(ObjectKind::Medium);
    plugin.finish()
}

/// The strength of an emitter; 1 in every channel if the file gives none, as in Mitsuba.
fn strength(tree: &Tree, plugin: &Plugin, name: &str) -> Result<Rgb, LoadError> {
    spectra::read_or(tree, plugin, name, Role::Emission, 1.0)
}

fn point(tree: &Tree, plugin: &Plugin) -> Result<Emitter, LoadError> {
    let position = plugin.vector("position")?;
    let to_world = plugin.transform("to_world")?;
    if let (Some(_), Some((_, at))) = (position, to_world) {
        return Err(plugin.parameter_error(at, "to_world", "and \"position\" exclude each other"));
    }
    let position = match (position, to_world) {
        (Some((position, _)), _) => position,
        (None, Some((to_world, _))) => to_world.point(DVec3::ZERO),
        (None, None) => DVec3::ZERO,
    };
    Ok(Emitter::Point {
        position,
        intensity: strength(tree, plugin, "intensity")?,
    })
}

/// A spot light. `cutoff_angle` defaults to 20 degrees and `beam_width` to three quarters of it. An image as
/// `texture` is a factor: it reaches from side to side of the cone on the plane at unit distance.
fn spot(
    tree: &Tree,
    plugin: &Plugin,
    textures: &mut Textures,
    files: &mut Files,
) -> Result<Emitter, LoadError> {
    let to_world = plugin.to_world()?;
    let mut intensity = strength(tree, plugin, "intensity")?;
    let cutoff = plugin.float_at("cutoff_angle")?;
    let cutoff_degrees = cutoff.map_or(DEFAULT_CUTOFF, |(degrees, _)| degrees);
    if let Some((degrees, at)) = cutoff
        && !(degrees > 0.0 && degrees <= 180.0)
    {
        return Err(plugin.parameter_error(
            at,
            "cutoff_angle",
            format!("must be above 0 and at most 180, not {degrees}"),
        ));
    }
    let beam = plugin.float_at("beam_width")?;
    let beam_degrees = beam.map_or(0.75 * cutoff_degrees, |(degrees, _)| degrees);
    if let Some((degrees, at)) = beam
        && !(0.0..=cutoff_degrees).contains(&degrees)
    {
        let message = format!("must be from 0 to cutoff_angle ({cutoff_degrees}), not {degrees}");
        return Err(plugin.parameter_error(at, "beam_width", message));
    }
    let cutoff_angle = cutoff_degrees.to_radians();
    let reach = DVec2::splat(math::tan(cutoff_angle));
    let image = image(tree, plugin, "texture", textures, files)?;
    if image.is_none()
        && let Some((factor, _)) = spectra::read(tree, plugin, "texture", Role::Emission)?
    {
        intensity = intensity * factor;
    }
    let slide = image.map(|image| Slide::new(image, &to_world, -reach, reach));
    Ok(Emitter::Spot {
        to_world,
        intensity,
        cutoff_angle,
        beam_width: beam_degrees.to_radians(),
        slide,
    })
}

/// A projector of the image `irradiance`, times `scale`. Its field of view is that of a camera.
///
/// A white wall at unit distance across its axis has the image's values as radiance: its irradiance is π
/// times these. The image's first column is on the side of +x, its first row on that of +y.
fn projector(
    tree: &Tree,
    plugin: &Plugin,
    textures: &mut Textures,
    files: &mut Files,
) -> Result<Emitter, LoadError> {
    let to_world = plugin.to_world()?;
    must_be_rigid(plugin, &to_world)?;
    let Some(image) = image(tree, plugin, "irradiance", textures, files)? else {
        return Err(plugin.error("needs an image (a bitmap) as its parameter \"irradiance\""));
    };
    let scale = plugin.float_or("scale", 1.0)?;
    let size = [image.image.width(), image.image.height()].map(|it| it as f64);
    let half = math::tan(0.5 * horizontal_fov(plugin, size)?);
    let corner = DVec2::new(half, half * size[1] / size[0]);
    Ok(Emitter::Projector {
        slide: Slide::new(image, &to_world, corner, -corner),
        irradiance: Rgb::grey(PI * scale),
    })
}

/// The image through which a point shines; `None` if the parameter is no texture.
fn image(
    tree: &Tree,
    plugin: &Plugin,
    name: &str,
    textures: &mut Textures,
    files: &mut Files,
) -> Result<Option<BitmapTexture>, LoadError> {
    let Some(id) = textures.emission(tree, plugin, name, files)? else {
        return Ok(None);
    };
    match &textures.list[id.0 as usize] {
        Texture::Bitmap(image) => Ok(Some(image.clone())),
        _ => Err(plugin.error(format!(
            "has a texture as \"{name}\" that is no bitmap; points shine through bitmaps only"
        ))),
    }
}

/// Parallel light, which travels along `direction` or the +z axis of `to_world`.
fn directional(tree: &Tree, plugin: &Plugin) -> Result<Emitter, LoadError> {
    let direction = plugin.vector("direction")?;
    let to_world = plugin.transform("to_world")?;
    if let (Some(_), Some((_, at))) = (direction, to_world) {
        return Err(plugin.parameter_error(at, "to_world", "and \"direction\" exclude each other"));
    }
    let travel = match (direction, to_world) {
        (Some((direction, _)), _) => direction,
        (None, Some((to_world, _))) => to_world.vector(DVec3::Z),
        (None, None) => DVec3::Z,
    };
    let direction = travel.try_normalize().ok_or_else(|| match direction {
        Some((_, at)) => plugin.parameter_error(at, "direction", "must not be zero"),
        None => plugin.error("has a to_world that leaves its direction zero"),
    })?;
    Ok(Emitter::Directional {
        direction,
        irradiance: strength(tree, plugin, "irradiance")?,
    })
}

/// The same light from all directions: `to_world` makes no difference.
fn constant(tree: &Tree, plugin: &Plugin) -> Result<Emitter, LoadError> {
    plugin.transform("to_world")?;
    Ok(Emitter::Constant {
        radiance: strength(tree, plugin, "radiance")?,
    })
}

/// The image `filename`, whose alpha does not matter, times `scale`.
///
/// `mis_compensation` changes the choice of directions in Mitsuba, and no expected value.
fn envmap(
    plugin: &Plugin,
    files: &mut Files,
    warnings: &mut Vec<Warning>,
) -> Result<Emitter, LoadError> {
    plugin.boolean_or("mis_compensation", false)?;
    let scale = plugin.float_at("scale")?;
    let turn = plugin.transform("to_world")?;
    let to_world = turn.map_or(Transform::IDENTITY, |(to_world, _)| to_world);
    if let Some(size) = Envmap::size_of(&to_world) {
        warnings.push(Warning {
            at: Some(plugin.source()),
            message: format!(
                "to_world scales the environment by {size:.6}, which makes no difference to what is infinitely \
                 far away; Mitsuba 3 distorts the image"
            ),
        });
    }
    let path = files.resolve(plugin.required_string("filename")?);
    let image = files.read_named(&path).and_then(|bytes| {
        Bitmap::read(&bytes, BitmapEncoding::Color)
            .map_err(|error| format!("{}: {error}", path.display()))
    });
    let image = image.map_err(|message| plugin.error(message))?;
    let map = Envmap::new(
        image.into(),
        &to_world,
        scale.map_or(1.0, |(scale, _)| scale),
    );
    map.map(Emitter::Envmap).map_err(|error| {
        let at = match error {
            EnvmapError::Scale { .. } => scale.map(|(_, at)| at),
            EnvmapError::Stretched => turn.map(|(_, at)| at),
            EnvmapError::Size { .. } | EnvmapError::Negative { .. } => None,
        };
        match at {
            Some(at) => LoadError::new(plugin.place(at), format!("{}: {error}", plugin.what())),
            None => plugin.error(format!("cannot use {}: {error}", path.display())),
        }
    })
}
