//! The runs of one sensor.

use std::collections::BTreeMap;

use super::default::DefaultStudy;
use super::error::PlanError;
use super::run::{StageRun, StageRuns, StudyRun};
use super::sensors;
use crate::method::Method;
use crate::scene::{Scene, Sensor};
use crate::setting::{Given, SettingError};
use crate::study::file::{StudyCandidate, StudyFile, StudyMethod};

/// The runs of one sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorPlan {
    /// The sensor's id.
    pub sensor: String,
    /// The run by which all others are judged.
    pub truth: StudyRun,
    /// The runs that are judged, curve by curve.
    pub runs: Vec<StudyRun>,
    /// The runs that tell which stage makes an error: one entry an approximation.
    pub stages: Vec<StageRuns>,
    /// Images rendered elsewhere, which are judged, too.
    pub candidates: Vec<StudyCandidate>,
    /// The largest relative error of each curve or candidate that has a limit.
    pub max_error: BTreeMap<String, f64>,
}

/// Distance of the truths' seeds from those that they judge. With the same seed both would have the same
/// photons, and their errors would not be independent.
const TRUTH_SEED: u64 = 1 << 63;

impl SensorPlan {
    pub(super) fn new(
        file: &StudyFile,
        scene: &Scene,
        sensor: &Sensor,
        is_only: bool,
    ) -> Result<Self, PlanError> {
        let default = DefaultStudy::of(scene, sensor);
        let truth = file
            .truths
            .get(&Some(sensor.id.clone()))
            .or_else(|| file.truths.get(&None))
            .unwrap_or(&default.truth);
        let is_empty = file.methods.is_empty() && file.candidates.is_empty();
        let mut methods = Vec::new();
        for method in &file.methods {
            if sensors::is_meant(method, sensor, is_only)? {
                methods.push(method.clone());
            }
        }
        if file.is_default || is_empty {
            methods.extend(default.methods);
        }
        let takes_seed = |name: &str| {
            let seeded = Given::from([("seed".to_owned(), "1".to_owned())]);
            Method::new(name, &seeded).is_ok()
        };
        let seeded = |method: &StudyMethod, seed: u64| {
            let mut method = method.clone();
            if seed != 0 && takes_seed(&method.method) {
                for settings in &mut method.settings {
                    settings
                        .entry("seed".to_owned())
                        .or_insert_with(|| seed.to_string());
                }
            }
            method
        };
        let truth = runs(&seeded(truth, file.seed.wrapping_add(TRUTH_SEED)), sensor)?;
        let mut all = Vec::new();
        let mut stages = Vec::new();
        for method in &methods {
            all.extend(runs(&seeded(method, file.seed), sensor)?);
            stages.extend(stage_runs(method)?);
        }
        let candidates = sensors::candidates(file, sensor);
        let names = names(&methods, &candidates)?;
        let max_error = sensors::limits(&file.max_error, &sensor.id, &names);
        // A study's truth has one value for each setting, and so one run.
        let Some(truth) = truth.into_iter().next() else {
            return Err(SettingError::value("truth", "", "one run").into());
        };
        Ok(Self {
            sensor: sensor.id.clone(),
            truth,
            runs: all,
            stages,
            max_error,
            candidates,
        })
    }

    /// Number of runs, including the truth's.
    pub fn count(&self) -> usize {
        let stages = self.stages.iter().map(|one| 1 + 2 * one.stages.len());
        1 + self.runs.len() + stages.sum::<usize>()
    }

    /// The names of curves and candidates, each once.
    pub(super) fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        let runs = self.runs.iter().map(|run| run.name.as_str());
        for name in runs.chain(self.candidates.iter().map(|one| one.name.as_str())) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }
}

fn runs(method: &StudyMethod, sensor: &Sensor) -> Result<Vec<StudyRun>, PlanError> {
    let made = method.methods()?;
    if let Some(one) = made.iter().find(|one| one.is_of_cameras())
        && !sensor.is_camera()
    {
        return Err(PlanError::NotACamera {
            method: one.name().to_owned(),
            sensor: sensor.id.clone(),
        });
    }
    let timed = made.iter().zip(&method.settings);
    let timed = timed.filter(|(one, _)| one.budget().time.is_some());
    if let Some((_, given)) = timed.into_iter().next() {
        let value = given.get("time").map_or("", String::as_str);
        let allowed = "error or work as a method's limit: its film would depend on the machine (`time` of the whole \
                       study is a limit on when the last run begins)";
        return Err(SettingError::value("time", value, allowed).into());
    }
    let pairs = made.into_iter().zip(&method.settings);
    Ok(pairs
        .map(|(made, given)| StudyRun {
            name: method.name.clone(),
            method: made,
            given: given.clone(),
        })
        .collect())
}

/// The runs that attribute an approximation's error, with the settings that all its runs share; `None` for a
/// reference.
fn stage_runs(method: &StudyMethod) -> Result<Option<StageRuns>, SettingError> {
    let mut shared = method.settings.first().cloned().unwrap_or_default();
    shared.retain(|key, value| {
        method
            .settings
            .iter()
            .all(|one| one.get(key) == Some(value))
    });
    let run = |given: Given| -> Result<StudyRun, SettingError> {
        Ok(StudyRun {
            name: method.name.clone(),
            method: Method::new(&method.method, &given)?,
            given,
        })
    };
    let all = run(shared.clone())?;
    let mut cumulative = shared.clone();
    let mut stages = Vec::new();
    for stage in all.method.stages() {
        let (key, exact) = (stage.name.to_owned(), stage.exact.to_owned());
        let mut alone = shared.clone();
        alone.insert(key.clone(), exact.clone());
        cumulative.insert(key, exact);
        stages.push(StageRun {
            alone: run(alone)?,
            cumulative: run(cumulative.clone())?,
            stage,
        });
    }
    Ok((!stages.is_empty()).then_some(StageRuns { all, stages }))
}

/// The names of curves and candidates.
fn names<'a>(
    methods: &'a [StudyMethod],
    candidates: &'a [StudyCandidate],
) -> Result<Vec<&'a str>, PlanError> {
    let mut seen: Vec<&str> = Vec::new();
    let names = methods.iter().map(|one| one.name.as_str());
    for name in names.chain(candidates.iter().map(|one| one.name.as_str())) {
        if seen.contains(&name) {
            return Err(PlanError::Twice(name.to_owned()));
        }
        seen.push(name);
    }
    Ok(seen)
}
