//! The figures of a report.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::attribution::Attribution;
use super::super::checks::Check;
use super::super::curve::Order;
use super::super::facts::Facts;
use super::super::limit::Limit;
use super::super::machine::Machine;
use crate::metric::{self, Bounded};
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
    /// Runs that the study's time did not suffice for.
    pub left_out: usize,
    /// Oddities of the scene or the study.
    pub warnings: Vec<String>,
    /// The meaning of the numbers.
    pub conventions: Vec<&'static str>,
}

impl StudyReport {
    /// True if all limits are kept, whatever the truths' bars allow.
    pub fn is_kept(&self) -> bool {
        let mut gates = self.sensors.iter().flat_map(|sensor| &sensor.gates);
        gates.all(|gate| gate.verdict == GateVerdict::Kept)
    }
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
    /// L1 of that layer: Σ |d| / Σ r over all texels; `None` if the truth is dark.
    pub error: Option<f64>,
    /// The smallest part of all texels that holds half of the squared difference of that layer: it tells
    /// where the error is.
    pub half_in: Option<f64>,
    /// The truth's own likely error in the same terms, which may add to `error` either way.
    pub truth_error: Option<f64>,
    /// How the picture looks with all light.
    pub picture: Option<PictureFigures>,
    /// Labels of other runs of the curve with the same film: their settings change nothing.
    pub same: Vec<String>,
    /// True if the truth is good enough to know `error` by.
    pub resolved: bool,
    /// For each counter true if no other row has less error for as little cost.
    pub pareto: BTreeMap<String, bool>,
    /// Signs of a mistake rather than an approximation.
    pub checks: Vec<Check>,
    /// All figures of `nephroid compare`, layer by layer.
    pub comparison: metric::Comparison,
}

/// Figures of the picture that a viewer sees: all light of the truth, with the light that the row is judged
/// by in place of the truth's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PictureFigures {
    /// Mean HDR-FLIP: 0 to 1.
    pub flip: Option<f64>,
    /// The exposures that FLIP takes, from and to \[stops\], and their number.
    pub exposures: Option<(f32, f32, usize)>,
    /// SSIM.
    pub ssim: Option<f64>,
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
    /// Figure by figure, and stage by stage.
    #[serde(flatten)]
    pub attribution: Attribution,
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
    /// The limit.
    pub limit: Limit,
    /// The figure of the setting that decides, with what the truth's bars allow.
    pub error: Option<Bounded>,
    /// The verdict.
    pub verdict: GateVerdict,
}

/// The verdict on a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GateVerdict {
    /// The figure is not above the limit, whatever the truth's bars allow.
    Kept,
    /// The truth is not good enough to tell.
    Undecided,
    /// The figure is above the limit, whatever the truth's bars allow.
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
