//! Beams as a method.

use crate::method::memory::{self, Layers, channels};
use crate::method::reference::{About, InParts, Job, Reference, other_step};
use crate::method::rows::{self, COUNT};
use crate::method::warnings;
use crate::reference::beams::inputs::BeamInputs;
use crate::reference::beams::run::{Divided, Setup};
use crate::reference::beams::{self, BeamReport, BeamSettings, Chaotic, Forecast, SignatureReport};
use crate::reference::parts::beams::{MOST_BYTES, check_error_only, next, run_part};
use crate::reference::parts::{GatherError, Gathered, Next, Part, Shards, Step};
use crate::reference::shard::Shard;
use crate::run::format::relative;
use crate::run::{Budget, Cost, Error, Estimate, Progress, Refusal, Rendering};
use crate::scene::{Scene, Sensor};
use crate::setting::table::row;
use crate::setting::{Kind, Setting, Values, words_of};

pub struct Beams;

const LIMITS: &[Setting] = &[
    row!("error": Kind::Fraction, Rule "0.1% if nothing else is limited", "", rows::ERROR_MEANING),
    rows::TIME,
    row!("rays": COUNT, Rule "no limit", "rays", "Stop after so many rays"),
];

pub(super) const SETTINGS: &[Setting] = &[
    rows::MAX_DEPTH,
    rows::SHADING_NORMALS,
    rows::LAYERS,
    row!("chaotic": Kind::Choice(words_of::<Chaotic>), Value "photons", "", "Who measures light of chaotic chains, which beams would take most of their work for"),
    row!("layer-error": Kind::NamedFractions, Rule "none", "", "Errors to reach in single layers, relative to their own means"),
];

/// The settings of beams from checked values.
pub(super) fn settings(values: &Values) -> BeamSettings {
    let default = BeamSettings::default();
    BeamSettings {
        max_depth: values.whole("max-depth").unwrap_or(default.max_depth),
        shading_normals: values.word("shading-normals").unwrap_or_default(),
        max_layers: values.whole("layers").unwrap_or(default.max_layers),
        chaotic: values.word("chaotic").unwrap_or(default.chaotic),
        ..default
    }
}

/// Likely work of beams with these settings to an error.
///
/// # Errors
///
/// If the sensor cannot receive.
pub(crate) fn forecast(
    scene: &Scene,
    sensor: &Sensor,
    values: &Values,
    error: f64,
) -> Result<Forecast, Error> {
    beams::forecast(scene, sensor, settings(values), error)
}

const ABOUT: About = About {
    name: "beams",
    meaning: "Adaptive beams with lower and upper bounds, of lights without size: deterministic",
    limits: LIMITS,
    work_key: Some("rays"),
    settings: SETTINGS,
    is_of_cameras: false,
};

/// Memory \[bytes\] of beams whose light is divided so, with `LD` on a receiver, and with at most so many
/// `named` layers.
fn bytes(scene: &Scene, sensor: &Sensor, named: u64, divided: &Divided) -> u64 {
    let channels = channels(scene, sensor);
    let layers = Layers {
        named: divided.named as u64,
        has_others: divided.has_others,
    };
    let (texels, together) = (memory::texels(sensor), divided.together as u64);
    let (events, count) = (divided.events as u64, layers.count());
    let beams = memory::beams(channels, layers, texels, together);
    let (texel, count, maps) = if divided.by_photons {
        let all = memory::beams_and_photons(channels, layers.count(), beams, named);
        (all, count.max(named + 1), memory::BOTH)
    } else {
        (beams, count, memory::BOUNDS)
    };
    let film = memory::film(sensor, texel);
    let run = film.saturating_add(memory::beam_scratch(channels, events));
    memory::with_files(run, sensor, count + 2, maps)
}

impl Reference for Beams {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn supports(&self, scene: &Scene, _sensor: &Sensor, _values: &Values) -> Result<(), Refusal> {
        beams::supports(scene)
    }

    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        let settings = settings(values);
        // What is shared by flat facets, and by photons, is not known before a pilot.
        let divided = Divided {
            named: settings.max_layers,
            has_others: true,
            together: 1,
            events: settings.max_depth as usize,
            by_photons: false,
        };
        Cost {
            bytes: bytes(scene, sensor, settings.max_layers as u64, &divided),
            work: Vec::new(),
        }
    }

    fn pilot(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<u64, Error> {
        let progress = Progress::default();
        let settings = settings(values);
        let mut setup = Setup::new(scene, sensor, settings, &progress)?;
        setup.ask(&values.named_fractions("layer-error"))?;
        let budget = Budget {
            relative_error: values.fraction("error"),
            time: values.time("time"),
            work: values.whole("rays"),
        };
        let divided = setup.divided(&budget);
        Ok(bytes(scene, sensor, settings.max_layers as u64, &divided))
    }

    fn run(&self, job: &Job) -> Result<Rendering, Error> {
        let mut setup = setup(job)?;
        let found = setup.run(job.budget)?;
        Ok(rendering(job, &setup, found))
    }

    fn in_parts(&self) -> Option<&dyn InParts> {
        Some(self)
    }
}

impl InParts for Beams {
    fn check_shards(&self) -> Result<(), Refusal> {
        Err(no_shards())
    }

    fn run_shard(&self, _: &Job, _: Shard) -> Result<Option<Vec<u8>>, GatherError> {
        Err(Error::from(no_shards()).into())
    }

    fn run_part(&self, job: &Job, step: &Step, shard: Shard) -> Result<Option<Part>, Error> {
        let Step::Piece(piece) = step else {
            return Err(other_step());
        };
        let settings = settings(job.values);
        let inputs = BeamInputs::new(job.scene, job.sensor, settings)?;
        let progress = &job.context.progress;
        run_part(&inputs, &settings, &job.sensor.id, piece, shard, progress)
    }

    fn merge(&self, _: &Job, _: &mut Shards) -> Result<Rendering, GatherError> {
        Err(Error::from(no_shards()).into())
    }

    fn next(&self, job: &Job, gathered: &Gathered) -> Result<Next<Rendering>, GatherError> {
        check_error_only(job.budget).map_err(Error::from)?;
        let mut setup = setup(job)?;
        let next = next(&mut setup, &job.sensor.id, job.budget, gathered, MOST_BYTES)?;
        Ok(match next {
            Next::Step(wanted) => Next::Step(wanted),
            Next::Done(found) => Next::Done(Box::new(rendering(job, &setup, *found))),
        })
    }
}

/// Why beams have no shards.
fn no_shards() -> Refusal {
    let reason = "beams are followed in passes, each as fine as those before ask for, so that no shard knows its part \
                  beforehand: nephroid.dask divides them";
    Refusal::new(reason)
}

/// Sets a run up.
fn setup<'a>(job: &Job<'a>) -> Result<Setup<'a>, Error> {
    let settings = settings(job.values);
    let mut setup = Setup::new(job.scene, job.sensor, settings, &job.context.progress)?;
    setup.ask(&job.values.named_fractions("layer-error"))?;
    Ok(setup)
}

/// The result of a run, made in one piece or put together of parts.
fn rendering(job: &Job, setup: &Setup, (estimate, report): (Estimate, BeamReport)) -> Rendering {
    let scene = job.scene;
    let mut warnings = warnings::of_chains(scene, setup.is_dark());
    let unseen = setup.unseen().filter(|unseen| !unseen.is_black());
    if let Some(unseen) = unseen {
        let missed = format!(
            "up to {:.1e} W may have been missed: that is the upper bound of every texel",
            unseen.mean()
        );
        warnings.insert(1.min(warnings.len()), missed);
    }
    let is_known = report.passes > 0 || report.by_photons.is_some();
    if !is_known && warnings.is_empty() {
        warnings.push(warnings::ended_before("pass", "caustic"));
    } else if is_known && estimate.incomplete {
        warnings.push(warnings::NOT_REACHED.to_owned());
    }
    if report.gave_up && report.by_photons.is_none() {
        warnings.push(warnings::BEAMS_GAVE_UP.to_owned());
    }
    warnings.extend(warnings::unknown_direct(&estimate));
    warnings.extend(warnings::of_camera(scene, &estimate, "beams", false));
    let summary = summary(&estimate, &report);
    Rendering {
        summary,
        warnings,
        unit: "patches",
        ..Rendering::new(estimate)
            .reporting("beams", report)
            .reporting("settings", settings(job.values))
    }
}

fn summary(estimate: &Estimate, report: &BeamReport) -> Vec<String> {
    let mut lines = Vec::new();
    if report.passes == 0 {
        lines.push("no pass was finished".to_owned());
    } else {
        let sum =
            |count: fn(&SignatureReport) -> u64| report.signatures.iter().map(count).sum::<u64>();
        lines.push(format!(
            "{} signatures, {} cells ({} cut, {} unresolved) in the last of {} passes",
            report.signatures.len(),
            sum(|one| one.cells),
            sum(|one| one.cut_cells),
            sum(|one| one.unresolved_cells),
            report.passes
        ));
    }
    if report.not_followed > 0.0 {
        lines.push(format!(
            "too faint to be followed: light of {:.1e} W on the film; upper bounds hold it",
            report.not_followed
        ));
    }
    if let Some(rest) = &report.by_photons {
        lines.push(format!(
            "light that beams did not follow: by {} photons, known to {} of all light; its bounds hold with 99.9 %",
            rest.photons,
            relative(rest.relative_error, false),
        ));
    }
    let balance = report.signatures.iter().map(|one| one.balance_error);
    if let Some(worst) = balance.reduce(f64::max) {
        lines.push(format!(
            "largest balance error of a signature (what its cells booked against the film): {worst:.1e}"
        ));
    }
    lines.push(format!(
        "likely error of the specular layers' sum over lit texels: {}",
        relative(estimate.relative_error, estimate.is_without_caustics())
    ));
    lines
}
