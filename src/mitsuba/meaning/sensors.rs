//! The meaning of `<sensor>`, which becomes a [`SensorKind`] and a [`Film`].

use glam::{DMat3, DVec2};

use super::film;
use super::plugin::Plugin;
use crate::geometry::Transform;
use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Tree, shortened};
use crate::numeric::math;
use crate::scene::{Film, Perspective, ReconstructionFilter, SensorKind, ShapeId, Warning};
use crate::setting::did_you_mean;

/// Every plugin that becomes a sensor.
const MODELLED: [&str; 4] = ["irradiancemeter", "orthographic", "perspective", "thinlens"];

/// Largest deviation of the products of a camera's axes from 0 and 1: Mitsuba's own limit
/// (`AffineTransform::has_scale`).
const RIGID_TOLERANCE: f64 = 1e-3;

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
            horizontal_fov: horizontal_fov(&plugin, &film)?,
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
    plugin.refuse(ObjectKind::Medium, "media are not modelled")?;
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

/// Fails for a camera that stretches space, as Mitsuba does.
fn must_be_rigid(plugin: &Plugin, to_world: &Transform) -> Result<(), LoadError> {
    let linear = DMat3::from_mat4(to_world.matrix());
    if (linear * linear.transpose()).abs_diff_eq(DMat3::IDENTITY, RIGID_TOLERANCE) {
        Ok(())
    } else {
        Err(plugin.error("must not scale or shear in its to_world"))
    }
}

/// The full horizontal field of view of the uncropped film \[rad\].
///
/// `fov` is in degrees along `fov_axis`. Without it, `focal_length` ("50mm" by default) is that of a 35 mm
/// still camera. Its film measures 36 mm x 24 mm, and its diagonal is the image's.
fn horizontal_fov(plugin: &Plugin, film: &Film) -> Result<f64, LoadError> {
    let aspect = f64::from(film.width) / f64::from(film.height);
    let Some((degrees, at)) = plugin.float_at("fov")? else {
        let length = focal_length(plugin)?;
        let diagonal = 2.0 * math::atan(0.5 * math::hypot(36.0_f64, 24.0) / length);
        return Ok(from_axis("diagonal", diagonal, aspect));
    };
    if let Some(found) = plugin.find("focal_length") {
        return Err(plugin.parameter_error(
            found.property.at,
            "focal_length",
            "and \"fov\" exclude each other",
        ));
    }
    let axis = plugin.choice_or(
        "fov_axis",
        &["x", "y", "diagonal", "smaller", "larger"],
        "x",
    )?;
    let horizontal = from_axis(axis, degrees.to_radians(), aspect);
    if degrees > 0.0 && degrees < 180.0 && horizontal > 0.0 && horizontal < std::f64::consts::PI {
        return Ok(horizontal);
    }
    Err(plugin.parameter_error(
        at,
        "fov",
        format!("must be above 0 and below 180 degrees, not {degrees}"),
    ))
}

fn focal_length(plugin: &Plugin) -> Result<f64, LoadError> {
    const DEFAULT: f64 = 50.0;
    let Some(found) = plugin.find("focal_length") else {
        return Ok(DEFAULT);
    };
    let text = plugin.string("focal_length")?.unwrap_or_default();
    let number = text.trim().trim_end_matches("mm").trim_end().parse::<f64>();
    match number {
        Ok(length) if length > 0.0 && length.is_finite() => Ok(length),
        _ => {
            let message = format!(
                "must be a length in millimetres such as \"50mm\", not \"{}\"",
                shortened(text)
            );
            Err(plugin.parameter_error(found.property.at, "focal_length", message))
        }
    }
}

/// The horizontal angle, from the angle along an axis. All in radians.
fn from_axis(axis: &str, angle: f64, aspect: f64) -> f64 {
    let half = math::tan(0.5 * angle);
    let half_width = match axis {
        "y" => half * aspect,
        "diagonal" => half * aspect / math::hypot(aspect, 1.0),
        "smaller" if aspect > 1.0 => half * aspect,
        "larger" if aspect < 1.0 => half * aspect,
        _ => half,
    };
    2.0 * math::atan(half_width)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers are `x_fov` as Mitsuba 3.9.1 prints it, six digits.
    #[test]
    fn fields_of_view_are_mitsubas() {
        let aspect = 768.0 / 576.0;
        let degrees = |axis, angle: f64| from_axis(axis, angle.to_radians(), aspect).to_degrees();
        assert!((degrees("y", 40.0) - 51.774).abs() < 5e-4);
        assert!((degrees("smaller", 40.0) - 51.774).abs() < 5e-4);
        assert!((degrees("x", 40.0) - 40.0).abs() < 1e-12);
        assert!((degrees("larger", 40.0) - 40.0).abs() < 1e-12);
        let of_lens =
            |length: f64| 2.0 * math::atan(0.5 * math::hypot(36.0_f64, 24.0) / length).to_degrees();
        assert!((degrees("diagonal", of_lens(35.0)) - 52.6225).abs() < 5e-5);
        assert!((degrees("diagonal", of_lens(50.0)) - 38.1848).abs() < 5e-5);
    }
}
