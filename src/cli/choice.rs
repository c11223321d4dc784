//! The sensor and the method of `nephroid render`.

use super::args::RenderArgs;
use super::sensor::{choose_camera, choose_sensor};
use crate::method::Method;
use crate::scene::{Scene, Sensor};
use crate::setting::{Given, SettingError};

/// The sensor and the method asked for, or those that suit the scene, with a notice if the method is not what
/// one would expect. A scene that has cameras alone is seen by the first.
///
/// # Errors
///
/// For a sensor, a method or a setting that does not exist.
pub(super) fn choose(
    args: &RenderArgs,
    scene: &Scene,
) -> anyhow::Result<(Sensor, Method, Option<String>)> {
    // Settings of another method are better known before the scene is looked at.
    let is_of_cameras = match args.method.as_deref() {
        Some(name) => Method::new(name, &Given::new())?.is_of_cameras(),
        None => false,
    };
    let given = args.settings.and(&args.set)?;
    let is_open = args.sensor.is_none() && args.method.is_none() && args.shard.is_none();
    let sensors = scene.sensors();
    let is_seen = is_open && !sensors.is_empty() && sensors.iter().all(Sensor::is_camera);
    let sensor = if is_of_cameras || is_seen {
        choose_camera(scene, args.sensor.as_deref())?
    } else {
        choose_sensor(scene, args.sensor.as_deref())?
    };
    let sensor = args.filter.filtered(sensor);
    let (method, notice) = if is_seen {
        choose_view(&given, scene, &sensor)
    } else {
        choose_method(args, &given, scene, &sensor)
    }
    .map_err(|error| args.settings.retold(error))?;
    Ok((sensor, method, notice))
}

/// The method that makes a picture of all light: all methods together. Settings of one method alone choose
/// it.
fn choose_view(
    given: &Given,
    scene: &Scene,
    sensor: &Sensor,
) -> Result<(Method, Option<String>), SettingError> {
    let of = |name: &str| Method::new(name, given);
    let seen = format!(
        "no sensor is an irradiancemeter: camera \"{}\" is rendered",
        sensor.id
    );
    let Ok(full) = of("full") else {
        let method = match of("path") {
            Ok(path) => path,
            Err(_) => Method::choose_with(scene, sensor, given)?.method,
        };
        let notice = format!("{seen} by {}, whose settings are given", method.name());
        return Ok((method, Some(notice)));
    };
    Ok((full, Some(format!("{seen} by full, with all of its light"))))
}

/// The method asked for, or the one that suits the scene and the settings, with a notice if it is not
/// what one would expect.
fn choose_method(
    args: &RenderArgs,
    given: &Given,
    scene: &Scene,
    sensor: &Sensor,
) -> Result<(Method, Option<String>), SettingError> {
    let name = args.method.as_deref().or(args.shard.map(|_| "photons"));
    if let Some(name) = name {
        return Ok((Method::new(name, given)?, None));
    }
    let choice = Method::choose_with(scene, sensor, given)?;
    // Whoever gives an amount of work knows the method whose work that is.
    let work_key = choice.method.work_key();
    let is_work = work_key.is_some_and(|key| given.contains_key(key));
    // The reason begins with the setting.
    let notice = choice
        .by_setting
        .filter(|_| !is_work)
        .map(|key| choice.reason.replacen(&key, &args.settings.typed(&key), 1));
    Ok((choice.method, notice))
}
