//! The table of costs: time to an error, beside photons of as much time.

use std::fmt::Write as _;

use nephroid::internals::numeric::StreamKind;

use super::percent;
use super::support::contest::{Contest, Trial};

/// Texels a side.
const SIDE: usize = 256;

/// Events followed, as by default.
const DEPTH: u32 = 16;

/// Error of a truth that is a beam run; below flat facets, where a finer one takes minutes, another.
const FINER: f64 = 2e-4;
const FINER_BELOW_FACETS: f64 = 3e-3;

/// Errors asked for.
const ERRORS: [f64; 4] = [3e-2, 1e-2, 1e-3, 1e-4];

/// Time of a run \[s\] after which no finer one is begun.
const LONGEST: f64 = 12.0;

/// Photons of the first run; each of the next has four times as many.
const FEWEST: u64 = 1 << 14;

/// A bumpy ball of 20 · `frequency`² triangles.
const BUMPS: [(&str, u32, bool); 6] = [
    ("smooth, 5,120", 16, true),
    ("smooth, 81,920", 64, true),
    ("smooth, 327,680", 128, true),
    ("flat, 5,120", 16, false),
    ("flat, 81,920", 64, false),
    ("flat, 327,680", 128, false),
];

/// Scenes with a closed form for all light, and others.
const KNOWN: [&str; 5] = ["glass-ball", "mirror-ring", "prism", "cube", "diamond"];
const OTHERS: [&str; 6] = [
    "coffee-cup",
    "glass-ball-behind-pane",
    "glass-ball-mesh",
    "lens",
    "parabolic-mirror",
    "water",
];

/// Writes the table.
pub fn costs(text: &mut String) -> std::fmt::Result {
    writeln!(
        text,
        "\n## Cost\n\n{SIDE} x {SIDE} texels, all signatures to depth {DEPTH} (closed forms: 8), direct light and \
         discovery included. CPU: time of all cores. Said: the error that the run says. Photons: the error of Sobol' photons \
         that take at least as much CPU time.\n\n\
         | scene | truth | asked | CPU s | said | true error | photons, CPU s | photons' error |\n\
         |---|---|--:|--:|--:|--:|--:|--:|"
    )?;
    for name in KNOWN {
        rows(text, &Contest::known(super::DEPTH, name, SIDE))?;
    }
    for name in OTHERS {
        rows(text, &Contest::finer(DEPTH, name, SIDE, FINER))?;
    }
    for (name, frequency, is_smooth) in BUMPS {
        let bumps = (frequency, is_smooth);
        let finer = if is_smooth { FINER } else { FINER_BELOW_FACETS };
        rows(text, &Contest::below_bumps(DEPTH, name, SIDE, bumps, finer))?;
    }
    Ok(())
}

fn rows(text: &mut String, contest: &Contest) -> std::fmt::Result {
    println!("cost of {}", contest.name);
    let truth = contest.finer_run.map_or("closed form".to_owned(), |error| {
        format!("beams, {}", percent(error))
    });
    let mut photons: Option<(u64, Trial)> = None;
    for error in ERRORS {
        if contest.finer_run.is_some_and(|finer| error < 3.0 * finer) {
            break;
        }
        let beams = contest.beams(error);
        while photons.is_none_or(|(_, trial)| trial.cpu_seconds < beams.cpu_seconds) {
            let count = photons.map_or(FEWEST, |(count, _)| 4 * count);
            photons = Some((count, contest.photons(StreamKind::Sobol, count)));
        }
        let (photon_seconds, photon_error) = photons.map_or((f64::NAN, f64::NAN), |(_, trial)| {
            (trial.cpu_seconds, trial.rmse)
        });
        writeln!(
            text,
            "| {} | {truth} | {} | {:.2} | {} | {} | {photon_seconds:.2} | {} |",
            contest.name,
            percent(error),
            beams.cpu_seconds,
            beams.said.map_or("-".to_owned(), percent),
            percent(beams.rmse),
            percent(photon_error),
        )?;
        if beams.seconds > LONGEST {
            break;
        }
    }
    Ok(())
}
