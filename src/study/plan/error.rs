//! Errors of a plan.

use std::path::PathBuf;

use crate::setting::SettingError;

/// Errors of planning a study.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// A setting.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// No sensor to fill.
    #[error("{}: {wanted}; the scene's sensors are: {there}", scene.display())]
    Sensor {
        /// The scene file.
        scene: PathBuf,
        /// The sensor that was asked for.
        wanted: String,
        /// The sensors that the scene has.
        there: String,
    },
    /// A sensor named twice.
    #[error("sensor \"{0}\" is named twice")]
    SensorTwice(String),
    /// A candidate that could be of several sensors.
    #[error(
        "candidate \"{candidate}\" names no sensor, and the study has several ({sensors}): give sensor = \"{first}\", \
         or --candidate {candidate}@{first}=FILE.exr"
    )]
    Unplaced {
        /// The candidate's name.
        candidate: String,
        /// The sensors' ids.
        sensors: String,
        /// The first of them.
        first: String,
    },
    /// A method of cameras on a receiver.
    #[error(
        "{method} starts at cameras, and sensor \"{sensor}\" is an irradiancemeter: allowed are beams and photons"
    )]
    NotACamera {
        /// The method.
        method: String,
        /// The sensor's id.
        sensor: String,
    },
    /// A name used twice on one sensor.
    #[error("two methods or candidates are called \"{0}\": give one another name")]
    Twice(String),
}
