//! The figures of a report.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::checks::Check;
use super::super::curve::Order;
use super::super::machine::Machine;
use super::super::method::{Facts, Settings};
use crate::metric;
use crate::reference::Quantity;
use crate::scene::Requirement;

/// All that a study found, timings apart. Relative numbers are fractions.
#[derive(Clone, Debug, Serialize)]
pub struct StudyReport {
    /// The program's version.
    pub version: &'static str,
    /// What was studied.
    pub study: StudyFigures,
    /// What the scene needs modelled.
    pub requirements: Vec<Requirement>,
    /// One entry a sensor.
    pub sensors: Vec<SensorFigures>,
    /// What is odd about the scene or the study.
    pub warnings: Vec<String>,
    /// What the numbers mean.
    pub conventions: Vec<&'static str>,
}

/// What was studied.
#[derive(Clone, Debug, Serialize)]
pub struct StudyFigures {
    /// The scene file, as it was named.
    pub scene: String,
    /// A hash of the scene file, all files it names, and its parameters.
    pub scene_hash: String,
    /// Parameters of the scene file.
    pub define: Vec<(String, String)>,
    /// Seed of all random choices but the truths'.
    pub seed: u64,
    /// The difference that matters, relative to the truth's mean.
    pub margin: f64,
}

/// What was found on one sensor.
#[derive(Clone, Debug, Serialize)]
pub struct SensorFigures {
    /// Its id.
    pub sensor: String,
    /// Its plugin.
    pub plugin: &'static str,
    /// Texels a row and rows.
    pub size: [usize; 2],
    /// What is measured.
    pub quantity: Quantity,
    /// Its unit.
    pub unit: &'static str,
    /// What a reader asks first, in sentences: one entry a curve.
    pub answers: Vec<Answer>,
    /// What all rows are judged by.
    pub truth: TruthFigures,
    /// One entry a run or candidate.
    pub rows: Vec<ReportRow>,
    /// One entry a method.
    pub curves: Vec<Curve>,
    /// Which stage makes an error: one entry an approximation.
    pub stages: Vec<StageErrors>,
    /// One entry a limit.
    pub gates: Vec<Gate>,
}

/// How wrong a curve is at its best, where, why, and what less error would cost.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Answer {
    /// The curve.
    pub name: String,
    /// Sentences, in the order of the questions.
    pub sentences: Vec<String>,
}

/// The truth.
#[derive(Clone, Debug, Serialize)]
pub struct TruthFigures {
    /// The method's name.
    pub method: String,
    /// Settings that are not defaults.
    pub settings: Settings,
    /// The method's name with these, but for its seed.
    pub label: String,
    /// The film, beside the report.
    pub file: String,
    /// The command that makes the film.
    pub command: String,
    /// What there is to know of it.
    pub facts: Facts,
}

/// A run or a candidate, judged.
#[derive(Clone, Debug, Serialize)]
pub struct ReportRow {
    /// The name of its curve.
    pub name: String,
    /// The curve's name with the settings that are not defaults.
    pub label: String,
    /// The method's name; `None` of a candidate.
    pub method: Option<String>,
    /// Settings that are not defaults.
    pub settings: Settings,
    /// The film, beside the report.
    pub file: String,
    /// The command that makes the film; `None` of a candidate.
    pub command: Option<String>,
    /// The command that prints the row's figures, in the report's folder.
    pub compare: String,
    /// What there is to know of the film; `None` of a candidate.
    pub facts: Option<Facts>,
    /// The layer that the row is judged by.
    pub layer: String,
    /// √(mean d²) / mean r over lit texels of that layer; `None` where the truth is dark.
    pub error: Option<f64>,
    /// The mean's difference, relative, of that layer.
    pub bias: Option<f64>,
    /// Where the error is: the part of all texels that holds half of the squared difference of that layer; of those that hold most
    /// of it, as few as do.
    pub half_in: Option<f64>,
    /// What the truth's own error may add to `error`, either way.
    pub truth_error: Option<f64>,
    /// Whether the truth is good enough to know `error` by.
    pub resolved: bool,
    /// By counter: whether no other row has less error for as little cost.
    pub pareto: BTreeMap<String, bool>,
    /// What looks like a mistake rather than an approximation.
    pub checks: Vec<Check>,
    /// All figures of `nephroid compare`, layer by layer.
    pub comparison: metric::Report,
}

/// One method over its settings.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    /// Its name.
    pub name: String,
    /// Its rows, by their place in `rows`, the cheapest (in the first counter) first.
    pub rows: Vec<usize>,
    /// The order of its error in each counter that all its rows have, fitted to resolved rows.
    pub orders: Vec<OrderOf>,
}

/// Where an approximation's error comes from, stage by stage.
#[derive(Clone, Debug, Serialize)]
pub struct StageErrors {
    /// Its curve.
    pub name: String,
    /// The curve's name with the settings that are not defaults.
    pub label: String,
    /// The layer that is judged.
    pub layer: String,
    /// The error with all stages as they are set.
    pub error: f64,
    /// In the order of the pipeline.
    pub stages: Vec<StageFigures>,
    /// The error with all stages exact: of sampling, and of the truth.
    pub residual: f64,
    /// What the falls of single stages do not add up to: errors that hide or cancel each other.
    pub interaction: f64,
    /// The part of the light from mirrors and glass that is not modelled at all.
    pub not_modelled: f64,
}

/// What one stage does to the error.
#[derive(Clone, Debug, Serialize)]
pub struct StageFigures {
    /// The stage.
    pub stage: &'static str,
    /// As it is set.
    pub variant: String,
    /// Its twin without error.
    pub exact: &'static str,
    /// The error with this stage exact, all others as they are set.
    pub alone: f64,
    /// The error with this stage and all before it exact.
    pub cumulative: f64,
}

/// The order of an error in a cost.
#[derive(Clone, Debug, Serialize)]
pub struct OrderOf {
    /// The cost.
    pub cost: String,
    /// error ∝ cost^exponent.
    #[serde(flatten)]
    pub order: Order,
}

/// A limit on a method's error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gate {
    /// The curve or candidate.
    pub name: String,
    /// The largest relative error that it may have.
    pub limit: f64,
    /// The smallest that it has, over its settings.
    pub error: Option<f64>,
    /// What the truth's own error may add to it, either way.
    pub truth_error: Option<f64>,
    /// Which it is.
    pub verdict: GateVerdict,
}

/// Whether a limit was kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GateVerdict {
    /// The error is below the limit, the truth's own error added.
    Kept,
    /// The truth is not good enough to tell.
    Undecided,
    /// The error is above the limit, the truth's own error taken off.
    Exceeded,
}

/// Times of all runs, and the machines on which they were taken.
#[derive(Clone, Debug, Serialize)]
pub struct Timings {
    /// The program's version.
    pub version: &'static str,
    /// The commit that the program was built from, with `-modified` where its source was changed since; `unknown` where it was built
    /// outside of its repository.
    pub commit: &'static str,
    /// A hash of the program's source.
    pub program: &'static str,
    /// As the report's sensors.
    pub sensors: Vec<SensorTimings>,
}

/// What the runs of one sensor took.
#[derive(Clone, Debug, Serialize)]
pub struct SensorTimings {
    /// The sensor's id.
    pub sensor: String,
    /// The truth.
    pub truth: RunTiming,
    /// As the report's rows.
    pub rows: Vec<RunTiming>,
    /// The order of each curve's error in seconds, fitted to resolved rows; by its place among the report's curves.
    pub orders: Vec<Option<OrderOf>>,
    /// Reasons for which an order in seconds is missing, as sentences without their full stop.
    pub notes: Vec<String>,
}

impl Timings {
    /// The machines of all runs, each once.
    pub fn machines(&self) -> Vec<&Machine> {
        let timings = self
            .sensors
            .iter()
            .flat_map(|sensor| [&sensor.truth].into_iter().chain(&sensor.rows));
        let mut machines = Vec::new();
        for machine in timings.filter_map(|timing| timing.machine.as_ref()) {
            if !machines.contains(&machine) {
                machines.push(machine);
            }
        }
        machines
    }
}

/// What one run took.
#[derive(Clone, Debug, Serialize)]
pub struct RunTiming {
    /// The run.
    pub label: String,
    /// Once for each repeat, from set-up to the film \[s\].
    pub seconds: Vec<f64>,
    /// Their median \[s\].
    pub median: Option<f64>,
    /// Threads used.
    pub threads: Option<usize>,
    /// The machine; `None` of a candidate, for which nobody told it.
    pub machine: Option<Machine>,
    /// Whether no other row has less error for as few seconds.
    pub pareto: bool,
}
