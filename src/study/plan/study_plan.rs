//! The runs of a study.

use std::path::PathBuf;
use std::time::Duration;

use super::error::PlanError;
use super::sensor_plan::SensorPlan;
use super::sensors;
use crate::scene::Scene;
use crate::setting::SettingError;
use crate::study::file::StudyFile;
use crate::study::limit::StudyLimit;

/// The runs of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyPlan {
    /// The scene file, as it was named.
    pub scene: PathBuf,
    /// Parameters of the scene file.
    pub define: Vec<(String, String)>,
    /// Seed of all random choices except the truth's.
    pub seed: u64,
    /// The difference that matters, relative to the truth's mean.
    pub margin: f64,
    /// Number of times that each run is made.
    pub repeats: u32,
    /// Time after which no run begins.
    pub time: Option<Duration>,
    /// The runs of each sensor, in the order of the report.
    pub sensors: Vec<SensorPlan>,
}

/// The margin if the study names none: 1 %.
const DEFAULT_MARGIN: f64 = 0.01;

impl StudyPlan {
    /// The plan of a study of a scene.
    ///
    /// If the study names no methods, a default is made from what the scene allows:
    ///
    /// - Receiver, no area lights. Truth: beams to 0.05 %. Methods: caustic maps of 128² to 1024² photons, if
    ///   they can be made; beams to 10 and 3 %; 2¹⁴ to 2²² photons.
    /// - Receiver, area lights. Truth: 2²⁴ photons, with 8192 samples a texel of direct light that is hard.
    ///   Methods: 2¹² to 2²⁰ photons.
    /// - Camera. Truth: full, 256 samples a pixel and 2²⁰ photons. Methods: full, 2 to 32 samples a pixel and
    ///   2¹³ to 2¹⁷ photons; paths, 2 to 32 samples a pixel, 8 alone if they find no caustics.
    ///
    /// # Errors
    ///
    /// If there is no such sensor, a method cannot fill it, a name is used twice, or a limit is on nothing.
    pub fn new(file: &StudyFile, scene: &Scene) -> Result<Self, PlanError> {
        let chosen = sensors::choose(scene, file)?;
        sensors::check(file, &chosen)?;
        let mut plans = Vec::new();
        for sensor in &chosen {
            plans.push(SensorPlan::new(file, scene, sensor, chosen.len() == 1)?);
        }
        check_used(file, &plans)?;
        Ok(Self {
            scene: file.scene.clone(),
            define: file.define.clone(),
            seed: file.seed,
            margin: file.margin.unwrap_or(DEFAULT_MARGIN),
            repeats: file.repeats.max(1),
            time: file.time,
            sensors: plans,
        })
    }

    /// Number of runs, including the truths.
    pub fn count(&self) -> usize {
        self.sensors.iter().map(SensorPlan::count).sum()
    }
}

/// Refuses limits on names that no sensor has, and methods that fill no sensor.
fn check_used(file: &StudyFile, plans: &[SensorPlan]) -> Result<(), PlanError> {
    let mut names: Vec<String> = Vec::new();
    for plan in plans {
        for name in plan.names() {
            names.extend([name.to_owned(), format!("{name}@{}", plan.sensor)]);
        }
    }
    // Names without a sensor first: of two equally near names it is the one that most studies mean.
    names.sort_by_key(|name| name.contains('@'));
    names.dedup();
    let mut limited = file.max_error.iter().map(StudyLimit::place);
    if let Some(unknown) = limited.find(|place| !names.contains(place)) {
        let names = names.iter().map(String::as_str);
        return Err(SettingError::unknown("method or candidate", &unknown, names).into());
    }
    let is_used = |name: &String| {
        let mut runs = plans.iter().flat_map(|plan| &plan.runs);
        runs.any(|run| run.name == *name)
    };
    match file.methods.iter().find(|method| !is_used(&method.name)) {
        Some(method) => Err(PlanError::NotACamera {
            method: method.method.clone(),
            sensor: plans
                .first()
                .map_or_else(String::new, |plan| plan.sensor.clone()),
        }),
        None => Ok(()),
    }
}
