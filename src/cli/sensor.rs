//! Which sensor of a scene a command is about.

use crate::scene::{Scene, Sensor, SensorKind};

/// Whether a sensor sees surfaces from afar, rather than measuring on one.
pub fn is_camera(sensor: &Sensor) -> bool {
    !matches!(sensor.kind, SensorKind::IrradianceMeter { .. })
}

/// The sensor with this id, or the first irradiance meter.
///
/// # Errors
///
/// Where there is none; the message lists those there are.
pub fn choose_sensor<'a>(scene: &'a Scene, id: Option<&str>) -> anyhow::Result<&'a Sensor> {
    let found = match id {
        Some(id) => scene.sensors().iter().find(|sensor| sensor.id == id),
        None => scene
            .sensors()
            .iter()
            .find(|sensor| matches!(sensor.kind, SensorKind::IrradianceMeter { .. })),
    };
    found.ok_or_else(|| {
        let wanted = id.map_or_else(
            || "no sensor of plugin irradiancemeter".to_owned(),
            |id| format!("no sensor with id \"{id}\""),
        );
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
        anyhow::anyhow!(
            "{}: {wanted}; the scene's sensors are: {there}",
            scene.path().display()
        )
    })
}
