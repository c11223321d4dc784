//! Which runs a study makes: what its file says, and sensible defaults for what it does not.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use super::file::{Candidate, StudyFile, StudyMethod};
use super::method::{Method, SettingError, Settings};
use crate::approximation::{Approximation, CausticMap, Stage};
use crate::reference::beams;
use crate::reference::full;
use crate::reference::path::PathSettings;
use crate::scene::{Scene, Sensor, SensorKind};

/// The runs of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The scene file, as it was named.
    pub scene: PathBuf,
    /// Parameters of the scene file.
    pub define: Vec<(String, String)>,
    /// The sensor's id.
    pub sensor: String,
    /// Seed of all random choices but the truth's.
    pub seed: u64,
    /// The difference that matters, relative to the truth's mean.
    pub margin: f64,
    /// How often each run is made.
    pub repeats: u32,
    /// No run begins after so much time.
    pub time: Option<Duration>,
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
    pub stage: Stage,
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
    pub given: Settings,
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
    /// A name used twice.
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
    /// | receiver, area lights | 2²⁴ photons | 2¹² to 2²⁰ photons |
    /// | camera | full, 256 samples a pixel and 2²⁰ photons | paths, 2 to 32 samples a pixel |
    ///
    /// # Errors
    ///
    /// Where there is no such sensor, a method cannot fill it, or a name is used twice.
    pub fn new(file: &StudyFile, scene: &Scene) -> Result<Self, PlanError> {
        let sensor = choose_sensor(scene, file)?;
        let default = Default::of(scene, sensor);
        let truth = file.truth.as_ref().unwrap_or(&default.truth);
        let is_empty = file.methods.is_empty() && file.candidates.is_empty();
        let mut methods = file.methods.clone();
        if file.is_default || is_empty {
            methods.extend(default.methods);
        }
        let draws_lots = |method: &str| method != "beams" || !beams::is_deterministic(scene);
        let seeded = |method: &StudyMethod, seed: u64| {
            let mut method = method.clone();
            if seed != 0 && draws_lots(&method.method) {
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
        for method in &methods {
            all.extend(runs(&seeded(method, file.seed), sensor)?);
        }
        let mut stages = Vec::new();
        for method in &methods {
            stages.extend(stage_runs(method)?);
        }
        check_names(&methods, &file.candidates)?;
        let names = methods.iter().map(|one| one.name.as_str());
        let names: Vec<&str> = names
            .chain(file.candidates.iter().map(|one| one.name.as_str()))
            .collect();
        if let Some(unknown) = file
            .max_error
            .keys()
            .find(|key| !names.contains(&key.as_str()))
        {
            return Err(SettingError::unknown("method or candidate", unknown, names).into());
        }
        // A study's truth has one value for each setting, and so one run.
        let Some(truth) = truth.into_iter().next() else {
            return Err(SettingError::value("truth", "", "one run").into());
        };
        Ok(Self {
            scene: file.scene.clone(),
            define: file.define.clone(),
            sensor: sensor.id.clone(),
            seed: file.seed,
            margin: file.margin.unwrap_or(DEFAULT_MARGIN),
            repeats: file.repeats.max(1),
            time: file.time,
            truth,
            runs: all,
            stages,
            candidates: file.candidates.clone(),
            max_error: file.max_error.clone(),
        })
    }
}

impl Plan {
    /// How many runs there are, the truth's included.
    pub fn count(&self) -> usize {
        let stages = self.stages.iter().map(|one| 1 + 2 * one.stages.len());
        1 + self.runs.len() + stages.sum::<usize>()
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
    let run = |given: Settings| -> Result<Run, SettingError> {
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

fn check_names(methods: &[StudyMethod], candidates: &[Candidate]) -> Result<(), PlanError> {
    let names = methods.iter().map(|one| &one.name);
    let mut seen: Vec<&String> = Vec::new();
    for name in names.chain(candidates.iter().map(|one| &one.name)) {
        if seen.contains(&name) {
            return Err(PlanError::Twice(name.clone()));
        }
        seen.push(name);
    }
    Ok(())
}

fn is_camera(sensor: &Sensor) -> bool {
    !matches!(sensor.kind, SensorKind::IrradianceMeter { .. })
}

/// The sensor asked for, else the first irradiancemeter, else the first camera.
fn choose_sensor<'a>(scene: &'a Scene, file: &StudyFile) -> Result<&'a Sensor, PlanError> {
    let sensors = scene.sensors();
    let found = match &file.sensor {
        Some(id) => sensors.iter().find(|sensor| sensor.id == *id),
        None => sensors
            .iter()
            .find(|sensor| !is_camera(sensor))
            .or(sensors.first()),
    };
    found.ok_or_else(|| PlanError::Sensor {
        scene: file.scene.clone(),
        wanted: match &file.sensor {
            Some(id) => format!("no sensor with id \"{id}\""),
            None => "no sensor".to_owned(),
        },
        there: if sensors.is_empty() {
            "none".to_owned()
        } else {
            let named = sensors
                .iter()
                .map(|it| format!("\"{}\" ({})", it.id, it.plugin()));
            named.collect::<Vec<_>>().join(", ")
        },
    })
}

/// What is done where nothing is said.
struct Default {
    truth: StudyMethod,
    methods: Vec<StudyMethod>,
}

impl Default {
    fn of(scene: &Scene, sensor: &Sensor) -> Self {
        if is_camera(sensor) {
            let is_full = full::Plan::new(scene, sensor, &PathSettings::default()).is_ok();
            return Self {
                truth: if is_full {
                    StudyMethod::swept("full", "spp", &["256"]).with("photons", "1048576")
                } else {
                    StudyMethod::swept("path", "spp", &["1024"])
                },
                methods: vec![StudyMethod::swept("path", "spp", &["2", "8", "32"])],
            };
        }
        if beams::is_deterministic(scene) && beams::supports(scene).is_ok() {
            let mut methods = vec![
                StudyMethod::swept("beams", "error", &["10%", "3%", "1%"]),
                StudyMethod::swept(
                    "photons",
                    "photons",
                    &["16384", "65536", "262144", "1048576", "4194304"],
                ),
            ];
            if can_be_mapped(scene, sensor) {
                let counts = ["128", "256", "512", "1024"];
                methods.insert(0, StudyMethod::swept("caustic-map", "photons", &counts));
            }
            return Self {
                truth: StudyMethod::swept("beams", "error", &["0.05%"]),
                methods,
            };
        }
        Self {
            truth: StudyMethod::swept("photons", "photons", &["16777216"]),
            methods: vec![StudyMethod::swept(
                "photons",
                "photons",
                &["4096", "16384", "65536", "262144", "1048576"],
            )],
        }
    }
}

/// Whether caustic maps can be made of a scene: a very small one is.
fn can_be_mapped(scene: &Scene, sensor: &Sensor) -> bool {
    let mut small = CausticMap::default();
    small.settings.photons = 4;
    small.settings.map = 4;
    small.settings.samples = 1;
    small.run(scene, sensor).is_ok()
}

impl Run {
    /// What it is called: its curve and the settings that are not defaults.
    pub fn label(&self) -> String {
        let settings = self
            .given
            .iter()
            .map(|(key, value)| format!(" {key}={value}"));
        format!("{}{}", self.name, settings.collect::<String>())
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
