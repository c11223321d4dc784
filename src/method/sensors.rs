//! The sensor of a scene that a run is about.

use crate::run::Refusal;
use crate::scene::{Scene, Sensor};

/// The sensor with this id, or the first irradiance meter.
///
/// # Errors
///
/// If there is none; the message lists those there are.
pub fn choose_sensor<'a>(scene: &'a Scene, id: Option<&str>) -> Result<&'a Sensor, Refusal> {
    choose(scene, id, false)
}

/// The sensor with this id, or the first camera.
///
/// # Errors
///
/// As [`choose_sensor`].
pub fn choose_camera<'a>(scene: &'a Scene, id: Option<&str>) -> Result<&'a Sensor, Refusal> {
    choose(scene, id, true)
}

fn choose<'a>(scene: &'a Scene, id: Option<&str>, camera: bool) -> Result<&'a Sensor, Refusal> {
    let mut sensors = scene.sensors().iter();
    let found = match id {
        Some(id) => sensors.find(|sensor| sensor.id == id),
        None => sensors.find(|sensor| sensor.is_camera() == camera),
    };
    found.ok_or_else(|| {
        let wanted = match id {
            Some(id) => format!("no sensor with id \"{id}\""),
            None if camera => "no camera".to_owned(),
            None => "no sensor of plugin irradiancemeter".to_owned(),
        };
        let there: Vec<String> = scene
            .sensors()
            .iter()
            .map(|sensor| format!("\"{}\" ({})", sensor.id, sensor.plugin()))
            .collect();
        let there = if there.is_empty() {
            "none".to_owned()
        } else {
            there.join(", ")
        };
        Refusal::new(format!(
            "{}: {wanted}; the scene's sensors are: {there}",
            scene.path().display()
        ))
    })
}
