//! The figures and tables of `docs/beams.md`: `cargo run --release --example beam-figures`.
//!
//! Writes `docs/beams/*.svg`, error against rays and against seconds for beams and for photons, and
//! `docs/beams/figures.md`, what errors cost, how bounds hold and what they are made of. Half an hour on two
//! cores. With names of scenes (`-- cube lens`) it prints what errors cost there, run by run, and writes nothing.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of an example, no results"
)]
#![allow(missing_docs, reason = "an example is no library")]

#[path = "../../tests/support/mod.rs"]
mod support;

mod cost;
mod svg;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use nephroid::internals::numeric::StreamKind;
use nephroid::internals::reference::beams::BeamReport;
use nephroid::internals::run::Budget;
use support::beams::{Held, beams_within, verdict};
use support::contest::{Contest, Trial};
use support::oracles::{DEPTH, NAMES, oracle};
use svg::{Chart, Curve};

/// Texels a side.
const SIDE: usize = 128;

/// Events followed in the convergence figures.
const CONTEST_DEPTH: u32 = 4;

/// No run is begun after one that took longer.
const LONGEST: Duration = Duration::from_secs(3);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let names: Vec<String> = std::env::args().skip(1).collect();
    if !names.is_empty() {
        let mut text = String::new();
        cost::costs(&mut text, &|name| names.iter().any(|one| one == name))?;
        let has_rows = text.contains("| closed form |") || text.contains("| beams, ");
        let problem = || format!("the table of costs has no {}", names.join(" and no "));
        return has_rows.then_some(()).ok_or_else(|| problem().into());
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/beams");
    fs::create_dir_all(&folder)?;
    let mut text = String::from(
        "# Figures of beams\n\nMade by `cargo run --release --example beam-figures`; \
         [`beams.md`](../beams.md) says what they mean.\n",
    );
    convergence(&folder, &mut text)?;
    cost::costs(&mut text, &|_| true)?;
    bounds(&mut text)?;
    fs::write(folder.join("figures.md"), text)?;
    Ok(())
}

/// Error against cost, scene by scene.
fn convergence(folder: &Path, text: &mut String) -> Result<(), Box<dyn std::error::Error>> {
    writeln!(
        text,
        "\n## Convergence\n\n{SIDE} x {SIDE} texels, specular paths to depth {CONTEST_DEPTH} (bumpy balls: 2). Relative RMS \
         error over lit texels; order: of the error in rays, between the last two runs (rays of signature discovery left out).\n\n\
         | scene | truth | method | rays | s | true error | order |\n|---|---|---|--:|--:|--:|--:|"
    )?;
    let contests: [fn() -> Contest; 9] = [
        || Contest::known(CONTEST_DEPTH, "glass-ball", SIDE),
        || Contest::known(CONTEST_DEPTH, "coffee-cup", SIDE),
        || Contest::known(CONTEST_DEPTH, "mirror-ring", SIDE),
        || Contest::known(CONTEST_DEPTH, "sine-water", SIDE),
        || Contest::finer(CONTEST_DEPTH, "water", SIDE, 1e-5),
        || Contest::finer(2, "smooth mesh", SIDE, 1e-4),
        || Contest::finer(2, "flat mesh", SIDE, 1e-4),
        || Contest::known(CONTEST_DEPTH, "cube", SIDE),
        || Contest::known(CONTEST_DEPTH, "diamond", SIDE),
    ];
    for contest in contests {
        let contest = contest();
        println!("{}", contest.name);
        let truth = contest.finer_run.map_or("closed form".to_owned(), |error| {
            format!("beams, {}", percent(error))
        });
        let curves = [
            ("beams", beams(&contest)),
            ("Sobol' photons", photons(&contest, StreamKind::Sobol)),
            ("random photons", photons(&contest, StreamKind::Random)),
        ];
        for (method, trials) in &curves {
            let Some(last) = trials.last() else {
                continue;
            };
            writeln!(
                text,
                "| {} | {truth} | {method} | {:.2e} | {:.2} | {} | {} |",
                contest.name,
                last.rays as f64,
                last.seconds,
                percent(last.rmse),
                order(trials),
            )?;
        }
        let panel = |horizontal: &'static str, cost: fn(&Trial) -> f64| Chart {
            title: contest.name,
            horizontal,
            curves: curves
                .iter()
                .map(|(name, trials)| Curve {
                    name,
                    points: trials.iter().map(|one| (cost(one), one.rmse)).collect(),
                })
                .collect(),
        };
        let drawn = svg::draw(&[
            panel("rays", |one| one.rays as f64),
            panel("seconds", |one| one.seconds),
        ]);
        let file = format!("{}.svg", contest.name.replace(' ', "-"));
        fs::write(folder.join(file), drawn)?;
    }
    Ok(())
}

/// The slope of the last piece of a curve, error over rays, both logarithmic.
fn order(trials: &[Trial]) -> String {
    let [.., before, last] = trials else {
        return "-".to_owned();
    };
    let order = (last.rmse / before.rmse).ln() / (last.rays as f64 / before.rays as f64).ln();
    format!("{order:.2}")
}

/// Beam runs to smaller and smaller errors, none near that of a truth which is a beam run itself.
fn beams(contest: &Contest) -> Vec<Trial> {
    let mut trials: Vec<Trial> = Vec::new();
    for error in [3e-1, 1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4] {
        let is_slow = trials
            .last()
            .is_some_and(|last| last.seconds > LONGEST.as_secs_f64());
        let is_truth = contest.finer_run.is_some_and(|finer| error < 3.0 * finer);
        if is_slow || is_truth {
            break;
        }
        let trial = contest.beams(error);
        // One tolerance may serve several errors.
        if trials.last().is_none_or(|last| last.rays != trial.rays) {
            trials.push(trial);
        }
    }
    trials
}

/// Runs of four times as many photons each.
fn photons(contest: &Contest, stream: StreamKind) -> Vec<Trial> {
    let mut trials: Vec<Trial> = Vec::new();
    for exponent in (14..=22).step_by(2) {
        if trials
            .last()
            .is_some_and(|last| last.seconds > LONGEST.as_secs_f64() / 4.0)
        {
            break;
        }
        trials.push(contest.photons(stream, 1 << exponent));
    }
    trials
}

/// How bounds hold, and what they are made of.
fn bounds(text: &mut String) -> Result<(), Box<dyn std::error::Error>> {
    writeln!(
        text,
        "\n## Bounds\n\n{SIDE} x {SIDE} texels, all signatures to depth {DEPTH}, the sum of the specular layers and the layer with the \
         most texels out of bounds. Out: texels whose truth is out of bounds, and by how much of the mean. Bar / error: median over lit texels of bar / |true error|. \
         Uncertain: flux of cut and of unresolved cells that may be elsewhere. Balance: the largest |film − cells| of a signature, of the light that set out.\n\n\
         | scene | asked | true error | bar / error | lit | out | by | worst layer | its out | uncertain / flux | cells | cut | unresolved | balance | s |\n\
         |---|--:|--:|--:|--:|--:|--:|---|--:|--:|--:|--:|--:|--:|--:|"
    )?;
    for name in NAMES {
        let oracle = oracle(name, SIDE);
        let mut longest = Duration::ZERO;
        for error in [1e-1, 1e-2, 1e-3, 1e-4] {
            if longest > LONGEST {
                writeln!(
                    text,
                    "| {name} | {} | not run: the one before took {:.0} s |||||||||||||",
                    percent(error),
                    longest.as_secs_f64()
                )?;
                break;
            }
            println!("{name} {error}");
            let start = Instant::now();
            let budget = Budget {
                relative_error: Some(error),
                ..Budget::default()
            };
            let (estimate, report) = beams_within(DEPTH, &oracle.scene, &budget);
            longest = start.elapsed();
            let verdict = verdict(&oracle, &estimate);
            let held = verdict.caustic;
            let (layer, worst) = verdict
                .layers
                .iter()
                .max_by_key(|(_, held)| held.missed)
                .map_or(("", Held::default()), |(layer, held)| {
                    (layer.as_str(), *held)
                });
            let layer = if worst.missed > 0 { layer } else { "-" };
            let work = Work::of(&report);
            writeln!(
                text,
                "| {name} | {} | {} | {:.1} | {} | {} | {:.1e} | {layer} | {} | {:.1e} | {} | {} | {} | {:.0e} | {:.2} |",
                percent(error),
                percent(held.rmse),
                held.tightness,
                held.lit,
                held.missed,
                held.worst,
                worst.missed,
                work.uncertain / work.received,
                work.cells,
                work.cut,
                work.unresolved,
                work.balance,
                longest.as_secs_f64(),
            )?;
        }
    }
    Ok(())
}

/// All signatures together.
#[derive(Default)]
struct Work {
    received: f64,
    uncertain: f64,
    cells: u64,
    cut: u64,
    unresolved: u64,
    balance: f64,
}

impl Work {
    fn of(report: &BeamReport) -> Self {
        let mut work = Self::default();
        for one in &report.signatures {
            work.received += one.received.mean();
            work.uncertain += one.uncertain.mean();
            work.cells += one.cells;
            work.cut += one.cut_cells;
            work.unresolved += one.unresolved_cells;
            work.balance = work.balance.max(one.balance_error);
        }
        work
    }
}

fn percent(part: f64) -> String {
    format!("{:.2e} %", 100.0 * part)
}
