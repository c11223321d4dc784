//! The meaning of `<sensor>`, which becomes a [`SensorKind`] and a [`Film`].

use glam::DVec2;

use super::field_of_view::{horizontal_fov, must_be_rigid};
use super::film;
use super::plugin::Plugin;
use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Tree};
use crate::scene::{Film, Perspective, ReconstructionFilter, SensorKind, ShapeId, Warning};
use crate::setting::did_you_mean;

/// Every plugin that becomes a sensor.
const MODELLED: [&str; 4] = ["irradiancemeter", "orthographic", "perspective", "thinlens"];

/// A sensor that belongs to the scene.
pub fn read(tree: &Tree, sensor: ObjectIndex) -> Result<(SensorKind, Film), LoadError> {
    let plugin = Plugin::new(tree, sensor);
    let name = plugin.name();
    if name == "irradiancemeter" {
        return Err(plugin.error("must be inside the shape it measures"));
    }
    if !MODELLED.contains(&name) {
        return Err(not_modelled(&plugin));
    }
    let film = common(tree, &plugin)?;
    let to_world = plugin.to_world()?;
    let (near_clip, far_clip) = clips(&plugin)?;
    let focus_distance = plugin.positive_or("focus_distance", far_clip)?;
    let kind = if name == "orthographic" {
        SensorKind::Orthographic {
            to_world,
            near_clip,
            far_clip,
        }
    } else {
        must_be_rigid(&plugin, &to_world)?;
        let mut camera = Perspective {
            to_world,
            horizontal_fov: horizontal_fov(&plugin, [film.width, film.height].map(f64::from))?,
            near_clip,
            far_clip,
            principal_point_offset: DVec2::ZERO,
        };
        if name == "perspective" {
            camera.principal_point_offset.x = plugin.float_or("principal_point_offset_x", 0.0)?;
            camera.principal_point_offset.y = plugin.float_or("principal_point_offset_y", 0.0)?;
            SensorKind::Perspective(camera)
        } else {
            if plugin.find("aperture_radius").is_none() {
                return Err(plugin.error("needs the parameter \"aperture_radius\""));
            }
            SensorKind::ThinLens {
                camera,
                aperture_radius: plugin.positive_or("aperture_radius", 1.0)?,
                focus_distance,
            }
        }
    };
    plugin.finish()?;
    Ok((kind, film))
}

/// A sensor that belongs to a shape, with a warning if Mitsuba would blur over texels.
pub fn read_meter(
    tree: &Tree,
    sensor: ObjectIndex,
    shape: ShapeId,
) -> Result<(SensorKind, Film, Option<Warning>), LoadError> {
    let plugin = Plugin::new(tree, sensor);
    match plugin.name() {
        "irradiancemeter" => {}
        name if MODELLED.contains(&name) => {
            return Err(plugin.error("cannot be inside a shape; only irradiancemeter can"));
        }
        _ => return Err(not_modelled(&plugin)),
    }
    let film = common(tree, &plugin)?;
    if let Some(found) = plugin.find("to_world") {
        let message = "is not allowed: the meter lies on its shape";
        return Err(plugin.parameter_error(found.property.at, "to_world", message));
    }
    let source = plugin.source();
    plugin.finish()?;
    let warning = (film.filter != ReconstructionFilter::Box).then(|| Warning {
        at: Some(source),
        message: "an irradiance meter here averages over each texel, but Mitsuba spreads samples over \
                  neighbouring texels with this film's filter; add <rfilter type=\"box\"/> to the film to compare"
            .to_owned(),
    });
    Ok((SensorKind::IrradianceMeter { shape }, film, warning))
}

fn not_modelled(plugin: &Plugin) -> LoadError {
    let hint = did_you_mean(plugin.name(), MODELLED);
    plugin.error(format!(
        "is not modelled{hint}; modelled sensors are: {}",
        MODELLED.join(", ")
    ))
}

/// Reads the parameters that all sensors share; samplers and shutters make no difference here.
fn common(tree: &Tree, plugin: &Plugin) -> Result<Film, LoadError> {
    // Read with the scene's media.
    plugin.children(ObjectKind::Medium);
    plugin.children(ObjectKind::Sampler);
    plugin.float_or("shutter_open", 0.0)?;
    plugin.float_or("shutter_close", 0.0)?;
    film::read(tree, plugin.child(ObjectKind::Film)?)
}

fn clips(plugin: &Plugin) -> Result<(f64, f64), LoadError> {
    let near = plugin.positive_or("near_clip", 0.01)?;
    let far = plugin.positive_or("far_clip", 10_000.0)?;
    if near >= far {
        return Err(plugin.error(format!("needs near_clip ({near}) below far_clip ({far})")));
    }
    Ok((near, far))
}
