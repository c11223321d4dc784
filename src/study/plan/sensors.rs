//! The sensors that a study fills, and the methods and images for each of them.

use super::error::PlanError;
use crate::method::Method;
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;
use crate::study::file::{StudyCandidate, StudyFile, StudyMethod};
use crate::study::limit::{Limit, StudyLimit};

/// The sensors asked for, in that order. Without any it is the first irradiancemeter, or else the first
/// camera.
pub(super) fn choose<'a>(scene: &'a Scene, file: &StudyFile) -> Result<Vec<&'a Sensor>, PlanError> {
    let sensors = scene.sensors();
    let refused = |wanted: String| {
        let named = sensors
            .iter()
            .map(|it| format!("\"{}\" ({})", it.id, it.plugin()));
        PlanError::Sensor {
            scene: file.scene.clone(),
            wanted,
            there: if sensors.is_empty() {
                "none".to_owned()
            } else {
                named.collect::<Vec<_>>().join(", ")
            },
        }
    };
    if file.sensors.is_empty() {
        let mut meters = sensors.iter().filter(|sensor| !sensor.is_camera());
        let first = meters.next().or(sensors.first());
        return Ok(vec![first.ok_or_else(|| refused("no sensor".to_owned()))?]);
    }
    let mut chosen: Vec<&Sensor> = Vec::new();
    for id in &file.sensors {
        let found = sensors.iter().find(|sensor| sensor.id == *id);
        let found = found.ok_or_else(|| refused(format!("no sensor with id \"{id}\"")))?;
        if chosen.iter().any(|one| one.id == *id) {
            return Err(PlanError::SensorTwice(id.clone()));
        }
        chosen.push(found);
    }
    Ok(chosen)
}

/// Refuses an entry that names a sensor outside the study, and one that names none if there are several.
pub(super) fn check(file: &StudyFile, sensors: &[&Sensor]) -> Result<(), PlanError> {
    let ids = || sensors.iter().map(|sensor| sensor.id.as_str());
    let truths = file.truths.keys().flatten();
    let methods = file.methods.iter().flat_map(|method| &method.sensors);
    let candidates = file.candidates.iter().filter_map(|one| one.sensor.as_ref());
    for id in truths.chain(methods).chain(candidates) {
        if !ids().any(|known| known == id) {
            return Err(SettingError::unknown("sensor of the study", id, ids()).into());
        }
    }
    let unplaced = file.candidates.iter().find(|one| one.sensor.is_none());
    match unplaced {
        Some(candidate) if sensors.len() > 1 => Err(PlanError::Unplaced {
            candidate: candidate.name.clone(),
            sensors: ids().collect::<Vec<_>>().join(", "),
            first: sensors[0].id.clone(),
        }),
        _ => Ok(()),
    }
}

/// True if a method is meant for a sensor: one that it names, or else any that it can fill. On the only
/// sensor of a study it is meant in any case; if it cannot fill it, the plan is an error.
pub(super) fn is_meant(
    method: &StudyMethod,
    sensor: &Sensor,
    is_only: bool,
) -> Result<bool, SettingError> {
    if !method.sensors.is_empty() {
        return Ok(method.sensors.contains(&sensor.id));
    }
    let of_cameras = method.methods()?.iter().any(Method::is_of_cameras);
    Ok(is_only || !of_cameras || sensor.is_camera())
}

/// The images that are meant for a sensor.
pub(super) fn candidates(file: &StudyFile, sensor: &Sensor) -> Vec<StudyCandidate> {
    let own = |one: &&StudyCandidate| one.sensor.as_ref().is_none_or(|id| *id == sensor.id);
    file.candidates.iter().filter(own).cloned().collect()
}

/// The limits on a sensor's curves. `NAME` is for every sensor that has it. `NAME@SENSOR` is for that one and
/// goes first.
pub(super) fn limits(limits: &[StudyLimit], sensor: &str, names: &[&str]) -> Vec<(String, Limit)> {
    let is_known = |one: &&StudyLimit| names.contains(&one.curve.as_str());
    let is_meant = |one: &&StudyLimit| match &one.sensor {
        Some(id) => id == sensor,
        None => !limits.iter().any(|other| {
            let is_same = other.curve == one.curve && other.limit.figure == one.limit.figure;
            is_same && other.sensor.as_deref() == Some(sensor)
        }),
    };
    let own = limits.iter().filter(is_known).filter(is_meant);
    own.map(|one| (one.curve.clone(), one.limit)).collect()
}
