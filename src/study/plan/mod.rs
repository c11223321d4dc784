//! Which runs a study makes: what its file says, and sensible defaults for what it does not.

mod default;
mod sensors;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use super::file::{Candidate, StudyFile, StudyMethod};
use crate::method::{Method, StageSetting};
use crate::scene::{Scene, Sensor};
use crate::setting::{Given, SettingError};
use default::Default;
use sensors::is_camera;

/// The runs of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The scene file, as it was named.
    pub scene: PathBuf,
    /// Parameters of the scene file.
    pub define: Vec<(String, String)>,
    /// Seed of all random choices but the truth's.
    pub seed: u64,
    /// The difference that matters, relative to the truth's mean.
    pub margin: f64,
    /// How often each run is made.
    pub repeats: u32,
    /// No run begins after so much time.
    pub time: Option<Duration>,
    /// What each sensor is filled by, in the order of the report.
    pub sensors: Vec<SensorPlan>,
}

/// The runs of one sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorPlan {
    /// The sensor's id.
    pub sensor: String,
    /// What all others are judged by.
    pub truth: Run,
    /// What is judged, curve by curve.
    pub runs: Vec<Run>,
    /// Which stage makes an error: one entry an approximation.
    pub stages: Vec<StageRuns>,
    /// Images rendered elsewhere, which are judged, too.
    pub candidates: Vec<Candidate>,
    /// The largest relative error of each curve or candidate that has a limit.
    pub max_error: BTreeMap<String, f64>,
}

/// The runs that tell which stage of an approximation makes its error.
#[derive(Clone, Debug, PartialEq)]
pub struct StageRuns {
    /// All stages as they are set.
    pub all: Run,
    /// In the order of the pipeline.
    pub stages: Vec<StageRun>,
}

/// Runs with a stage exact.
#[derive(Clone, Debug, PartialEq)]
pub struct StageRun {
    /// The stage, as it is set.
    pub stage: StageSetting,
    /// With this stage exact, all others as they are set.
    pub alone: Run,
    /// With this stage and all before it exact.
    pub cumulative: Run,
}

/// One run of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The name of its curve.
    pub name: String,
    /// The method with all its settings.
    pub method: Method,
    /// The settings that are not the method's defaults, as text.
    pub given: Given,
}

/// Why there is no plan.
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
        /// What was asked for.
        wanted: String,
        /// Those there are.
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

/// The margin where the study names none: 1 %.
const DEFAULT_MARGIN: f64 = 0.01;

/// Seeds of truths are so far from those that they judge: with the same seed, photons of both would be the same
/// photons, and their errors not independent.
const TRUTH_SEED: u64 = 1 << 63;

impl Plan {
    /// The plan of a study of a scene.
    ///
    /// Where the study names no methods, a default is made from what the scene allows:
    ///
    /// | sensor, light | truth | methods |
    /// |---|---|---|
    /// | receiver, no area lights | beams to 0.05 % | caustic maps of 128² to 1024² photons, where they can be made; beams to 10, 3 and 1 %; 2¹⁴ to 2²² photons |
    /// | receiver, area lights | 2²⁴ photons, direct light by 8192 samples a texel where it is hard | 2¹² to 2²⁰ photons |
    /// | camera | full, 256 samples a pixel and 2²⁰ photons | full, 2 to 32 samples a pixel and 2¹³ to 2¹⁷ photons; paths, 2 to 32 samples a pixel, 8 alone where they find no caustics |
    ///
    /// # Errors
    ///
    /// Where there is no such sensor, a method cannot fill it, a name is used twice, or a limit is on nothing.
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

    /// How many runs there are, the truths included.
    pub fn count(&self) -> usize {
        self.sensors.iter().map(SensorPlan::count).sum()
    }
}

impl SensorPlan {
    fn new(
        file: &StudyFile,
        scene: &Scene,
        sensor: &Sensor,
        is_only: bool,
    ) -> Result<Self, PlanError> {
        let default = Default::of(scene, sensor);
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
            Method::new(name, &seeded).is_ok_and(|method| method.ignored(scene).is_none())
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

    /// How many runs there are, the truth's included.
    pub fn count(&self) -> usize {
        let stages = self.stages.iter().map(|one| 1 + 2 * one.stages.len());
        1 + self.runs.len() + stages.sum::<usize>()
    }

    /// The names of curves and candidates, each once.
    fn names(&self) -> Vec<&str> {
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

/// Refuses limits on what no sensor has, and methods that no sensor is filled by.
fn check_used(file: &StudyFile, plans: &[SensorPlan]) -> Result<(), PlanError> {
    let mut names: Vec<String> = Vec::new();
    for plan in plans {
        for name in plan.names() {
            names.extend([name.to_owned(), format!("{name}@{}", plan.sensor)]);
        }
    }
    // Those without a sensor first: of two that are as near, the one that most studies mean.
    names.sort_by_key(|name| name.contains('@'));
    names.dedup();
    let is_unknown = |key: &&String| !names.contains(key);
    if let Some(unknown) = file.max_error.keys().find(is_unknown) {
        let names = names.iter().map(String::as_str);
        return Err(SettingError::unknown("method or candidate", unknown, names).into());
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

fn runs(method: &StudyMethod, sensor: &Sensor) -> Result<Vec<Run>, PlanError> {
    let made = method.methods()?;
    if let Some(one) = made.iter().find(|one| one.is_of_cameras())
        && !is_camera(sensor)
    {
        return Err(PlanError::NotACamera {
            method: one.name().to_owned(),
            sensor: sensor.id.clone(),
        });
    }
    let pairs = made.into_iter().zip(&method.settings);
    Ok(pairs
        .map(|(made, given)| Run {
            name: method.name.clone(),
            method: made,
            given: given.clone(),
        })
        .collect())
}

/// The runs that attribute an approximation's error, with the settings that all its runs share; `None` of a reference.
fn stage_runs(method: &StudyMethod) -> Result<Option<StageRuns>, SettingError> {
    let mut shared = method.settings.first().cloned().unwrap_or_default();
    shared.retain(|key, value| {
        method
            .settings
            .iter()
            .all(|one| one.get(key) == Some(value))
    });
    let run = |given: Given| -> Result<Run, SettingError> {
        Ok(Run {
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
    candidates: &'a [Candidate],
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

impl Run {
    /// What it is called: its curve and the settings that are not defaults.
    pub fn label(&self) -> String {
        self.label_of(|_| true)
    }

    /// The same without the seed, which says nothing of a run that is the only one of its kind.
    pub fn label_without_seed(&self) -> String {
        self.label_of(|key| key != "seed")
    }

    fn label_of(&self, is_told: impl Fn(&str) -> bool) -> String {
        let told = self.given.iter().filter(|(key, _)| is_told(key));
        // photons=4096, not photons photons=4096: what is swept comes first where it has the method's name.
        let (named, other): (Vec<_>, Vec<_>) = told.partition(|(key, _)| **key == self.name);
        let named = named.iter().map(|(_, value)| format!("={value}"));
        let other = other.iter().map(|(key, value)| format!(" {key}={value}"));
        [self.name.clone()]
            .into_iter()
            .chain(named)
            .chain(other)
            .collect()
    }

    /// The arguments of `nephroid render` that make the same film.
    pub fn arguments(&self) -> String {
        let given = self.given.iter();
        let is_staged = !self.method.stages().is_empty();
        let settings = given.map(|(key, value)| {
            if is_staged {
                format!(" --set {key}={value}")
            } else {
                format!(" --{key} {value}")
            }
        });
        format!(
            "--method {}{}",
            self.method.name(),
            settings.collect::<String>()
        )
    }
}
