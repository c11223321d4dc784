//! The runs of one sensor.

use super::default::DefaultStudy;
use super::error::PlanError;
use super::run::StudyRun;
use super::sensors;
use crate::method::Method;
use crate::scene::{Scene, Sensor};
use crate::setting::{Given, SettingError};
use crate::study::file::{StudyCandidate, StudyFile, StudyMethod};
use crate::study::limit::Limit;

/// The runs of one sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorPlan {
    /// The sensor's id.
    pub sensor: String,
    /// The run by which all others are judged.
    pub truth: StudyRun,
    /// The runs that are judged, curve by curve.
    pub runs: Vec<StudyRun>,
    /// Approximations whose error is attributed to their stages, with the settings that their runs share.
    pub attributed: Vec<StudyRun>,
    /// Images rendered elsewhere, which are judged, too.
    pub candidates: Vec<StudyCandidate>,
    /// The limits on curves and candidates.
    pub max_error: Vec<(String, Limit)>,
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
        let named = methods.len();
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
        let mut attributed = Vec::new();
        for (place, method) in methods.iter().enumerate() {
            let mut made = runs(&seeded(method, file.seed), sensor)?;
            for run in &mut made {
                run.is_default = place >= named;
            }
            all.extend(made);
            attributed.extend(shared_run(method)?);
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
            attributed,
            max_error,
            candidates,
        })
    }

    /// Number of runs, including the truth's; an attribution counts as one.
    pub fn count(&self) -> usize {
        1 + self.runs.len() + self.attributed.len()
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
            is_default: false,
        })
        .collect())
}

/// An approximation with the settings that all its runs share; `None` for a reference.
fn shared_run(method: &StudyMethod) -> Result<Option<StudyRun>, SettingError> {
    let mut shared = method.settings.first().cloned().unwrap_or_default();
    shared.retain(|key, value| {
        method
            .settings
            .iter()
            .all(|one| one.get(key) == Some(value))
    });
    let run = StudyRun {
        name: method.name.clone(),
        method: Method::new(&method.method, &shared)?,
        given: shared,
        is_default: false,
    };
    Ok((!run.method.stages().is_empty()).then_some(run))
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
