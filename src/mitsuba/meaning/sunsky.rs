//! The meaning of `sunsky`: a clear sky, and the sun in it.

use glam::DVec3;

use super::plugin::Plugin;
use super::spectra::{self, Role};
use crate::geometry::Transform;
use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::Tree;
use crate::scene::{Daylight, Emitter, Envmap, SunDisc, Warning};
use crate::spectrum::daylight::sunlight::SUN_DIAMETER;
use crate::spectrum::daylight::{ClearSky, Clock, Place, elevation, sun_direction, sun_irradiance};

/// The parameters of a place and a time, which a direction of the sun excludes.
const PLACE_AND_TIME: [&str; 9] = [
    "latitude",
    "longitude",
    "timezone",
    "year",
    "month",
    "day",
    "hour",
    "minute",
    "second",
];

/// A sky and its sun, by the direction of the sun or by a place and a time (Tokyo, 10 July 2010, 15:00).
///
/// The sun is a disc as bright everywhere. Its radiance times its solid angle is the same for any
/// `sun_aperture`.
pub fn read(
    tree: &Tree,
    plugin: &Plugin,
    warnings: &mut Vec<Warning>,
) -> Result<Emitter, LoadError> {
    let turn = plugin.transform("to_world")?;
    let to_world = turn.map_or(Transform::IDENTITY, |(to_world, _)| to_world);
    let turbidity = plugin.float_within("turbidity", 1.0..=10.0, 3.0)?;
    let albedo = spectra::read_or(tree, plugin, "albedo", Role::Fraction, 0.3)?;
    let sun_scale = not_negative(plugin, "sun_scale")?;
    let sky_scale = not_negative(plugin, "sky_scale")?;
    let half_angle = 0.5 * aperture(plugin)?;
    if plugin.boolean_or("complex_sun", false)? {
        return Err(plugin.error(
            "asks for a sun that is darker towards its limb (complex_sun); without it the sun is an even disc of \
             the same irradiance",
        ));
    }
    let local = towards_sun(plugin, &to_world)?;
    let mut warn = |message: &str| {
        warnings.push(Warning {
            at: Some(plugin.source()),
            message: message.to_owned(),
        });
    };
    if let Some(size) = Envmap::size_of(&to_world) {
        warn(&format!(
            "to_world scales the sky by {size:.6}, which makes no difference to what is infinitely far away; \
             Mitsuba 3 puts the sun elsewhere"
        ));
    }
    if local.z < 0.0 {
        warn("the sun is below the horizon, where the model has no light: sky and sun are black");
    }
    let irradiance = sun_irradiance(turbidity, elevation(local)) * sun_scale;
    if irradiance.min_channel() < 0.0 {
        warn(
            "the sun is redder than linear sRGB can tell; negative channels are taken for 0, which Mitsuba keeps",
        );
    }
    let irradiance = irradiance.map(|channel| channel.max(0.0));
    let up = to_world.vector(DVec3::Z).normalize_or(DVec3::Z);
    let towards = to_world.vector(local).normalize_or(up);
    let sun = SunDisc::new(towards, half_angle, irradiance, up);
    let sun = (!irradiance.is_black()).then_some(sun);
    let sky = ClearSky::new(turbidity, albedo, local);
    if sky.has_negative_channels() {
        warn(
            "some of the sky has colours outside of linear sRGB; negative channels are taken for 0, which Mitsuba keeps",
        );
    }
    let daylight = Daylight::new(sky, sun, &to_world, sky_scale).map_err(|error| match turn {
        Some((_, at)) => LoadError::new(plugin.place(at), format!("{}: {error}", plugin.what())),
        None => plugin.error(error.to_string()),
    })?;
    Ok(Emitter::Sunsky(daylight))
}

/// The direction to the sun in the frame of the sky, a unit vector.
///
/// A file may give it in the scene's frame (`sun_direction`), or a place and a time.
fn towards_sun(plugin: &Plugin, to_world: &Transform) -> Result<DVec3, LoadError> {
    let Some((direction, at)) = plugin.vector("sun_direction")? else {
        return Ok(sun_direction(&clock(plugin)?, &place(plugin)?));
    };
    if let Some(other) = PLACE_AND_TIME
        .into_iter()
        .find(|name| plugin.find(name).is_some())
    {
        let message = format!("and \"{other}\" exclude each other");
        return Err(plugin.parameter_error(at, "sun_direction", message));
    }
    // Its length is of no use: without it no square overflows.
    let direction = direction / direction.abs().max_element();
    (to_world.inverse().vector(direction).try_normalize())
        .ok_or_else(|| plugin.parameter_error(at, "sun_direction", "must not be zero"))
}

fn place(plugin: &Plugin) -> Result<Place, LoadError> {
    Ok(Place {
        latitude: plugin.float_within("latitude", -90.0..=90.0, 35.6894)?,
        longitude: plugin.float_within("longitude", -360.0..=360.0, 139.6917)?,
        timezone: plugin.float_within("timezone", -24.0..=24.0, 9.0)?,
    })
}

fn clock(plugin: &Plugin) -> Result<Clock, LoadError> {
    Ok(Clock {
        year: whole(plugin, "year", 2010, 1, 9999)?,
        month: whole(plugin, "month", 7, 1, 12)?,
        day: whole(plugin, "day", 10, 1, 31)?,
        hour: plugin.float_within("hour", -48.0..=48.0, 15.0)?,
        minute: plugin.float_within("minute", -1e4..=1e4, 0.0)?,
        second: plugin.float_within("second", -1e6..=1e6, 0.0)?,
    })
}

/// The least angle of a sun, in degrees: below, rounding would move directions out of it.
const LEAST_APERTURE: f64 = 1e-6;

/// The angle that the sun fills \[rad\].
fn aperture(plugin: &Plugin) -> Result<f64, LoadError> {
    match plugin.float_at("sun_aperture")? {
        None => Ok(SUN_DIAMETER),
        // The half angle is below a quarter turn: a disc has one side.
        Some((degrees, _)) if (LEAST_APERTURE..180.0).contains(&degrees) => {
            Ok(degrees.to_radians())
        }
        Some((degrees, at)) => {
            let message =
                format!("must be at least {LEAST_APERTURE} and below 180 degrees, not {degrees}");
            Err(plugin.parameter_error(at, "sun_aperture", message))
        }
    }
}

fn not_negative(plugin: &Plugin, name: &str) -> Result<f64, LoadError> {
    plugin.float_within(name, 0.0..=f64::MAX, 1.0)
}

/// A whole number from `least` to `most`, or `default` if the file gives none.
fn whole(
    plugin: &Plugin,
    name: &str,
    default: i32,
    least: i32,
    most: i32,
) -> Result<i32, LoadError> {
    let number = plugin.float_within(name, least.into()..=most.into(), default.into())?;
    match plugin.float_at(name)? {
        Some((_, at)) if number.fract() != 0.0 => {
            let message = format!("must be a whole number, not {number}");
            Err(plugin.parameter_error(at, name, message))
        }
        // In range: the cast loses nothing.
        _ => Ok(number as i32),
    }
}
