//! The meaning of `<emitter>`, which becomes an [`Emitter`].

use glam::DVec3;

use super::plugin::Plugin;
use super::spectra::{self, Role};
use super::textures::Textures;
use crate::film::bitmap::{Bitmap, BitmapEncoding};
use crate::geometry::Transform;
use crate::mitsuba::error::LoadError;
use crate::mitsuba::files::Files;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Tree};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Envmap, EnvmapError, ShapeId, Warning};
use crate::setting::did_you_mean;

/// Every plugin that becomes an emitter.
const MODELLED: [&str; 6] = ["area", "constant", "directional", "envmap", "point", "spot"];

/// The half angle of a `spot` if the file gives none, in degrees.
const DEFAULT_CUTOFF: f64 = 20.0;

/// An emitter that belongs to the scene.
pub fn read(
    tree: &Tree,
    emitter: ObjectIndex,
    files: &mut Files,
    warnings: &mut Vec<Warning>,
) -> Result<Emitter, LoadError> {
    let plugin = Plugin::new(tree, emitter);
    let result = match plugin.name() {
        "point" => point(tree, &plugin)?,
        "spot" => spot(tree, &plugin)?,
        "directional" => directional(tree, &plugin)?,
        "constant" => constant(tree, &plugin)?,
        "envmap" => envmap(&plugin, files, warnings)?,
        "area" => return Err(plugin.error("must be inside the shape that shines")),
        _ => return Err(not_modelled(&plugin)),
    };
    finish(plugin)?;
    Ok(result)
}

/// An emitter that belongs to a shape.
///
/// Its radiance may be a texture.
pub fn read_area(
    tree: &Tree,
    emitter: ObjectIndex,
    shape: ShapeId,
    textures: &mut Textures,
    files: &mut Files,
) -> Result<Emitter, LoadError> {
    let plugin = Plugin::new(tree, emitter);
    match plugin.name() {
        "area" => {}
        name if MODELLED.contains(&name) => {
            return Err(plugin.error("cannot be inside a shape; only area can"));
        }
        _ => return Err(not_modelled(&plugin)),
    }
    let texture = textures.emission(tree, &plugin, "radiance", files)?;
    let radiance = match texture {
        Some(_) => Rgb::WHITE,
        None => strength(tree, &plugin, "radiance")?,
    };
    finish(plugin)?;
    Ok(Emitter::Area {
        shape,
        radiance,
        texture,
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
    plugin.refuse(ObjectKind::Medium, "media are not modelled")?;
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

/// A spot light. `cutoff_angle` defaults to 20 degrees and `beam_width` to three quarters of it.
fn spot(tree: &Tree, plugin: &Plugin) -> Result<Emitter, LoadError> {
    let to_world = plugin.to_world()?;
    let intensity = strength(tree, plugin, "intensity")?;
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
    if let Some((texture, at)) = spectra::read(tree, plugin, "texture", Role::Emission)?
        && texture != Rgb::WHITE
    {
        return Err(plugin.parameter_error(at, "texture", "is not modelled"));
    }
    Ok(Emitter::Spot {
        to_world,
        intensity,
        cutoff_angle: cutoff_degrees.to_radians(),
        beam_width: beam_degrees.to_radians(),
    })
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
