//! The figures of a report, from films.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::attribution::Attribution;
use super::super::checks;
use super::super::curve::median;
use super::super::file::StudyCandidate;
use super::super::layers::add_specular;
use super::super::plan::{SensorPlan, StudyRun};
use super::super::session::Session;
use super::super::store::StoredRun;
use super::super::{StudyError, truth};
use super::answers::{answers, half_in, left_out, with_left_out};
use super::figures::{
    Curve, ReportRow, RunTiming, SensorFigures, SensorTimings, StageErrors, StudyFigures,
    StudyReport, Timings, TruthFigures,
};
use super::picture::picture;
use super::trade::{curves, front, gates, mark_pareto, orders_in_seconds, unknown};
use crate::film::{Image, exr};
use crate::metric::{self, CompareImage, LayerComparison};
use crate::run::LayerName;
use crate::scene::requirements;

/// The film that a row judges.
#[derive(Clone, Debug)]
pub enum JudgedFilm<'a> {
    /// A run of the study.
    Run(&'a StudyRun, Box<StoredRun>),
    /// An image rendered elsewhere, with the name of its copy in the store.
    Candidate(&'a StudyCandidate, String),
}

/// A listener that hears which row is about to be judged: its number from 0, and its label. It ends the work
/// by returning false.
pub type RowProgress<'a> = &'a mut dyn FnMut(usize, &str) -> bool;

/// The folder of films beside the report.
const FILMS: &str = "runs";

/// The films of one sensor.
#[derive(Clone, Debug)]
pub struct SensorFilms<'a> {
    /// The plan.
    pub plan: &'a SensorPlan,
    /// The truth.
    pub truth: StoredRun,
    /// Runs and candidates.
    pub judged: Vec<JudgedFilm<'a>>,
    /// Labels of runs that are not judged, since their film is that of another one of their curve, each with
    /// that film's place.
    pub same: Vec<(usize, String)>,
    /// Approximations whose error is attributed to their stages, or the reason why it is not.
    pub stages: Vec<(&'a StudyRun, Result<Attribution, String>)>,
}

/// Judges films by the truths'. They are read from the files, as anybody can who has them. `None` if the
/// listener ended it.
///
/// # Errors
///
/// If a film cannot be read or compared.
pub fn build(
    session: &Session,
    films: &[SensorFilms],
    progressing: RowProgress,
) -> Result<Option<(StudyReport, Timings)>, StudyError> {
    let plan = &session.plan;
    let mut sensors = Vec::new();
    let mut timed = Vec::new();
    let mut done = 0;
    for one in films {
        let mut next = |label: &str| {
            let goes_on = progressing(done, label);
            done += 1;
            goes_on
        };
        let Some((figures, timings)) = sensor_figures(session, one, &mut next)? else {
            return Ok(None);
        };
        sensors.push(figures);
        timed.push(timings);
    }
    let without = films.iter().flat_map(|one| &one.stages);
    let without = without.filter_map(|(run, found)| {
        let reason = found.as_ref().err()?;
        Some(format!("{}: no error of stages: {reason}", run.label()))
    });
    let warnings = session.scene.warnings().iter().map(ToString::to_string);
    let report = StudyReport {
        version: env!("CARGO_PKG_VERSION"),
        study: StudyFigures {
            scene: plan.scene.display().to_string(),
            scene_hash: session.scene.content_hash().to_owned(),
            define: plan.define.clone(),
            seed: plan.seed,
            margin: plan.margin,
        },
        requirements: requirements(&session.scene),
        sensors,
        left_out: 0,
        warnings: warnings.chain(without).collect(),
        conventions: CONVENTIONS.to_vec(),
    };
    let timings = Timings {
        version: env!("CARGO_PKG_VERSION"),
        commit: env!("NEPHROID_COMMIT"),
        program: session.store.program(),
        sensors: timed,
    };
    Ok(Some((report, timings)))
}

fn sensor_figures(
    session: &Session,
    films: &SensorFilms,
    next: &mut dyn FnMut(&str) -> bool,
) -> Result<Option<(SensorFigures, SensorTimings)>, StudyError> {
    let plan = films.plan;
    let sensor = session.sensor(plan)?;
    let mut truth = film(session, &films.truth.exr)?;
    if films.is_specular_judged() {
        add_specular(&mut truth.image);
    }
    let mut rows = Vec::new();
    for one in &films.judged {
        if !next(&one.label()) {
            return Ok(None);
        }
        rows.push(row(session, films, &truth, one)?);
    }
    for (kept, label) in &films.same {
        rows[*kept].same.push(label.clone());
    }
    // A limit is on all runs, whether they are rows or not.
    let gates = gates(&plan.max_error, &rows);
    let is_default = |row: usize| films.judged[row].is_default();
    let unknown = unknown(&rows, is_default);
    let without = left_out(&rows, &unknown, &plan.truth.label_without_seed());
    let (judged, mut rows): (Vec<&JudgedFilm>, Vec<ReportRow>) = films
        .judged
        .iter()
        .zip(rows)
        .enumerate()
        .filter(|(place, _)| !unknown.contains(place))
        .map(|(_, kept)| kept)
        .unzip();
    mark_pareto(&mut rows);
    let curves = curves(&rows);
    let timings = timings(films, &judged, &rows, &curves);
    let stages: Vec<StageErrors> = films
        .stages
        .iter()
        .filter_map(|(run, found)| {
            Some(StageErrors {
                name: run.name.clone(),
                label: run.label(),
                attribution: found.as_ref().ok()?.clone(),
            })
        })
        .collect();
    let quantity = quantity(&truth.image);
    let figures = SensorFigures {
        sensor: sensor.id.clone(),
        plugin: sensor.plugin(),
        size: [truth.image.width, truth.image.height],
        quantity,
        unit: quantity.unit(),
        answers: with_left_out(answers(&rows, &curves, &stages), without),
        truth: TruthFigures {
            method: plan.truth.method.name().to_owned(),
            settings: plan.truth.given.clone(),
            label: plan.truth.label_without_seed(),
            file: truth.name.clone(),
            command: command(session, plan, &plan.truth, &truth.name),
            facts: films.truth.facts.clone(),
        },
        gates,
        curves,
        stages,
        rows,
    };
    Ok(Some((figures, timings)))
}

/// The meaning of the numbers, for readers who find the report alone.
const CONVENTIONS: [&str; 11] = [
    "all figures are over all texels of the light that a row is judged by, lit or not; a black image has an L1 and an L2 of 1",
    "error: L1, the sum of absolute differences from the truth over the sum of the truth; a fraction",
    "energy: flux of the image over flux of the truth on the sensor; misplaced: the part of the light that is in a wrong texel if both have the same flux",
    "displaced: how far light must be moved to its place, on average (the Wasserstein distance of order one); its value is a lower bound, its interval holds the distance",
    "resolution: the smallest square over which means are right to 10 % (L2)",
    "low and high: what the truth's own bars allow",
    "picture: FLIP and SSIM of all light of the truth with the row's light in place of the truth's",
    "truth_error: what is known of the truth's own error, in the terms of error; a row is resolved where it is a tenth of error at most",
    "counters are exact and the same on every machine; seconds are in timings.json",
    "stages: shares of each stage in a figure by Shapley's value, which add up to the figure with the residual; on a sensor of fewer texels",
    "order: error goes as cost to this power, by least squares of logarithms over resolved rows",
];

/// A film as it is in its file.
fn film(session: &Session, name: &str) -> Result<CompareImage, StudyError> {
    let image = exr::read(&session.store.path(name))?;
    Ok(CompareImage::new(format!("{FILMS}/{name}"), image))
}

fn quantity(image: &Image) -> crate::run::Quantity {
    use crate::run::Quantity::{Irradiance, Radiance};
    if image.metadata("quantity") == Some(Radiance.name()) {
        Radiance
    } else {
        Irradiance
    }
}

impl SensorFilms<'_> {
    /// The films without those of a curve's runs that are what an earlier one is, to the last bit: a setting
    /// that asks for less than the coarsest run gives changes nothing.
    #[must_use]
    pub fn distinct(mut self) -> Self {
        for one in std::mem::take(&mut self.judged) {
            let earlier = self.judged.iter().position(|other| match (&one, other) {
                (JudgedFilm::Run(run, film), JudgedFilm::Run(other, earlier)) => {
                    run.name == other.name && film.texels == earlier.texels
                }
                _ => false,
            });
            match earlier {
                Some(place) => self.same.push((place, one.label())),
                None => self.judged.push(one),
            }
        }
        self
    }

    /// True if a film is judged by all light by way of mirrors and glass, which the truth may not have as a
    /// layer.
    fn is_specular_judged(&self) -> bool {
        let rows = self.judged.iter().filter_map(|one| match one {
            JudgedFilm::Run(_, stored) => Some(&stored.facts),
            JudgedFilm::Candidate(..) => None,
        });
        let specular = LayerName::Specular.to_string();
        let mut judged = rows.map(|facts| &facts.judged);
        judged.any(|judged| *judged == specular)
    }
}

impl JudgedFilm<'_> {
    /// True for a run that nobody named.
    fn is_default(&self) -> bool {
        matches!(self, Self::Run(run, _) if run.is_default)
    }

    fn label(&self) -> String {
        match self {
            Self::Run(run, _) => run.label(),
            Self::Candidate(candidate, _) => candidate.name.clone(),
        }
    }
}

fn row(
    session: &Session,
    films: &SensorFilms,
    truth: &CompareImage,
    judged: &JudgedFilm,
) -> Result<ReportRow, StudyError> {
    let settings = metric::CompareSettings {
        margin: session.plan.margin,
        ..metric::CompareSettings::default()
    };
    let (name, file) = match judged {
        JudgedFilm::Run(run, stored) => (&run.name, &stored.exr),
        JudgedFilm::Candidate(candidate, file) => (&candidate.name, file),
    };
    let film = film(session, file)?;
    let comparison = metric::compare(truth, &film, &settings)?;
    let compare = format!(
        "nephroid compare {} {} --margin {}",
        quoted(&truth.name),
        quoted(&film.name),
        session.plan.margin
    );
    let (run, facts) = match judged {
        JudgedFilm::Run(run, stored) => (Some(run), Some(stored.facts.clone())),
        JudgedFilm::Candidate(..) => (None, None),
    };
    let layer = layer_judged(
        &comparison,
        facts.as_ref().map(|facts| facts.judged.as_str()),
    );
    let is_direct_shared = layer.is_some_and(|layer| !layer.is_total)
        || truth::shares_direct(&truth.image, &film.image);
    let truth_error =
        layer.and_then(|layer| truth::error(&films.truth.facts, is_direct_shared, layer));
    let error = layer.and_then(|layer| Some(layer.fidelity.l1?.value));
    let seen = layer
        .map(|layer| picture(truth, &film, layer))
        .transpose()?;
    Ok(ReportRow {
        name: name.clone(),
        label: judged.label(),
        method: run.map(|run| run.method.name().to_owned()),
        settings: run.map(|run| run.given.clone()).unwrap_or_default(),
        command: run.map(|run| command(session, films.plan, run, &film.name)),
        compare,
        layer: layer.map(|layer| layer.layer.clone()).unwrap_or_default(),
        error,
        half_in: layer.and_then(|layer| half_in(&truth.image, &film.image, layer)),
        truth_error,
        picture: seen,
        same: Vec::new(),
        resolved: truth::resolves(truth_error, error),
        pareto: BTreeMap::new(),
        checks: match (judged, layer) {
            (JudgedFilm::Candidate(..), Some(layer)) => {
                checks::checks(&truth.image, &film.image, layer)
            }
            _ => Vec::new(),
        },
        file: film.name,
        facts,
        comparison,
    })
}

/// The layer of a name, or that of all light.
fn layer_judged<'a>(
    comparison: &'a metric::Comparison,
    name: Option<&str>,
) -> Option<&'a LayerComparison> {
    let named = comparison
        .layers
        .iter()
        .find(|layer| Some(layer.layer.as_str()) == name);
    named.or(comparison.layers.first())
}

/// The command that makes a film.
fn command(session: &Session, sensor: &SensorPlan, run: &StudyRun, file: &str) -> String {
    let plan = &session.plan;
    let define = plan
        .define
        .iter()
        .map(|(key, value)| format!("{key}={value}"));
    let define = define.fold(String::new(), |all, one| all + " -D " + &quoted(&one));
    format!(
        "nephroid render {}{define} --sensor {} {} --output {}",
        quoted(&plan.scene.display().to_string()),
        quoted(&sensor.sensor),
        run.arguments(),
        quoted(
            Path::new(file)
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .as_ref()
        ),
    )
}

/// A word of a shell's command.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=%+,:".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

fn timings(
    films: &SensorFilms,
    judged: &[&JudgedFilm],
    rows: &[ReportRow],
    curves: &[Curve],
) -> SensorTimings {
    let of_run = |run: &StudyRun, stored: &StoredRun| RunTiming {
        label: run.label(),
        median: median(&stored.time.seconds),
        seconds: stored.time.seconds.clone(),
        threads: Some(stored.time.threads),
        machine: Some(stored.time.machine.clone()),
        pareto: false,
    };
    let mut timed: Vec<RunTiming> = judged
        .iter()
        .map(|one| match one {
            JudgedFilm::Run(run, stored) => of_run(run, stored),
            JudgedFilm::Candidate(candidate, _) => RunTiming {
                label: candidate.name.clone(),
                median: candidate.seconds,
                seconds: candidate.seconds.into_iter().collect(),
                threads: None,
                machine: None,
                pareto: false,
            },
        })
        .collect();
    for (row, is_on_front) in front(rows, |i, _| timed[i].median) {
        timed[row].pareto = is_on_front;
    }
    let (orders, notes) = orders_in_seconds(curves, rows, &timed);
    SensorTimings {
        sensor: films.plan.sensor.clone(),
        truth: of_run(&films.plan.truth, &films.truth),
        rows: timed,
        orders,
        notes,
    }
}
