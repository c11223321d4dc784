//! The figures of a report.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::checks::Check;
use super::super::curve::Order;
use super::super::facts::Facts;
use super::super::machine::Machine;
use crate::metric;
use crate::run::Quantity;
use crate::scene::Requirement;
use crate::setting::Given;

/// All figures of a study except timings. Relative numbers are fractions.
#[derive(Clone, Debug, Serialize)]
pub struct StudyReport {
    /// The program's version.
    pub version: &'static str,
    /// The subject of the study.
    pub study: StudyFigures,
    /// The phenomena that the scene needs modelled.
    pub requirements: Vec<Requirement>,
    /// One entry a sensor.
    pub sensors: Vec<SensorFigures>,
    /// Oddities of the scene or the study.
    pub warnings: Vec<String>,
    /// The meaning of the numbers.
    pub conventions: Vec<&'static str>,
}

/// The subject of a study.
#[derive(Clone, Debug, Serialize)]
pub struct StudyFigures {
    /// The scene file, as it was named.
    pub scene: String,
    /// A hash of the scene file, all files it names, and its parameters.
    pub scene_hash: String,
    /// Parameters of the scene file.
    pub define: Vec<(String, String)>,
    /// Seed of all random choices except the truths'.
    pub seed: u64,
    /// The difference that matters, relative to the truth's mean.
    pub margin: f64,
}

/// The figures of one sensor.
#[derive(Clone, Debug, Serialize)]
pub struct SensorFigures {
    /// Its id.
    pub sensor: String,
    /// Its plugin.
    pub plugin: &'static str,
    /// Texels a row and rows.
    pub size: [usize; 2],
    /// The quantity that it measures.
    pub quantity: Quantity,
    /// Its unit.
    pub unit: &'static str,
    /// A reader's first questions, answered in sentences: one entry a curve.
    pub answers: Vec<Answer>,
    /// The truth by which all rows are judged.
    pub truth: TruthFigures,
    /// One entry a run or candidate.
    pub rows: Vec<ReportRow>,
    /// One entry a method.
    pub curves: Vec<Curve>,
    /// The errors of stages: one entry an approximation.
    pub stages: Vec<StageErrors>,
    /// One entry a limit.
    pub gates: Vec<Gate>,
}

/// Answers on a curve: how wrong it is at its best, where, why, and what less error would cost.
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
    /// Given that are not defaults.
    pub settings: Given,
    /// The method's name with these, except its seed.
    pub label: String,
    /// The film, beside the report.
    pub file: String,
    /// The command that makes the film.
    pub command: String,
    /// All facts of the film.
    pub facts: Facts,
}

/// A run or a candidate, judged.
#[derive(Clone, Debug, Serialize)]
pub struct ReportRow {
    /// The name of its curve.
    pub name: String,
    /// The curve's name with the settings that are not defaults.
    pub label: String,
    /// The method's name; `None` for a candidate.
    pub method: Option<String>,
    /// Given that are not defaults.
    pub settings: Given,
    /// The film, beside the report.
    pub file: String,
    /// The command that makes the film; `None` for a candidate.
    pub command: Option<String>,
    /// The command that prints the row's figures, in the report's folder.
    pub compare: String,
    /// All facts of the film; `None` for a candidate.
    pub facts: Option<Facts>,
    /// The layer that the row is judged by.
    pub layer: String,
    /// √(mean d²) / mean r over lit texels of that layer; `None` if the truth is dark.
    pub error: Option<f64>,
    /// The mean's difference, relative, of that layer.
    pub bias: Option<f64>,
    /// The smallest part of all texels that holds half of the squared difference of that layer: it tells
    /// where the error is.
    pub half_in: Option<f64>,
    /// The truth's own error, which may add to `error` either way.
    pub truth_error: Option<f64>,
    /// True if the truth is good enough to know `error` by.
    pub resolved: bool,
    /// For each counter true if no other row has less error for as little cost.
    pub pareto: BTreeMap<String, bool>,
    /// Signs of a mistake rather than an approximation.
    pub checks: Vec<Check>,
    /// All figures of `nephroid compare`, layer by layer.
    pub comparison: metric::Comparison,
}

/// One method over its settings.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    /// Its name.
    pub name: String,
    /// Its rows, by their index in `rows`, the cheapest (in the first counter) first.
    pub rows: Vec<usize>,
    /// The order of its error in each counter that all its rows have, fitted to resolved rows.
    pub orders: Vec<OrderOf>,
}

/// The error of an approximation, stage by stage.
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
    /// The part of the error that the falls of single stages do not add up to: errors that hide or cancel
    /// each other.
    pub interaction: f64,
    /// The part of the light from mirrors and glass that is not modelled at all.
    pub not_modelled: f64,
}

/// The effect of one stage on the error.
#[derive(Clone, Debug, Serialize)]
pub struct StageFigures {
    /// The stage.
    pub stage: &'static str,
    /// The variant that is set.
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
    /// The truth's own error, which may add to it either way.
    pub truth_error: Option<f64>,
    /// The verdict.
    pub verdict: GateVerdict,
}

/// The verdict on a limit.
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
    /// The commit that the program was built from, with `-modified` if its source was changed since;
    /// `unknown` if it was built outside of its repository.
    pub commit: &'static str,
    /// A hash of the program's source.
    pub program: &'static str,
    /// In the order of the report's sensors.
    pub sensors: Vec<SensorTimings>,
}

/// Times of the runs of one sensor.
#[derive(Clone, Debug, Serialize)]
pub struct SensorTimings {
    /// The sensor's id.
    pub sensor: String,
    /// The truth.
    pub truth: RunTiming,
    /// In the order of the report's rows.
    pub rows: Vec<RunTiming>,
    /// The order of each curve's error in seconds, fitted to resolved rows; in the order of the report's
    /// curves.
    pub orders: Vec<Option<OrderOf>>,
    /// Reasons why orders in seconds are missing, as sentences without their full stop.
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

/// Time of one run.
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
    /// The machine; `None` for a candidate, whose machine nobody told.
    pub machine: Option<Machine>,
    /// True if no other row has less error for as few seconds.
    pub pareto: bool,
}
