//! The table of costs: time to a true error, beside photons.

use std::fmt::Write as _;
use std::time::Duration;

use nephroid::internals::numeric::StreamKind;

use super::percent;
use super::support::contest::{Contest, LAMP, Trial};
use super::support::scenes::{below_balls, below_bumps, below_even_ball};

/// Texels a side.
const SIDE: usize = 256;

/// Events followed, as by default.
const DEPTH: u32 = 16;

/// Error of a truth that is a beam run; below flat facets, where a finer one takes minutes, another.
const FINER: f64 = 2e-4;
const FINER_BELOW_FACETS: f64 = 3e-3;

/// True errors to be reached.
const TARGETS: [f64; 4] = [3e-2, 1e-2, 1e-3, 1e-4];

/// Errors asked for.
const ERRORS: [f64; 8] = [3e-1, 1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4];

/// Time of a run of beams \[s\] after which no finer one is begun.
const LONGEST: f64 = 12.0;

/// No run is begun that is said to take longer, even by a factor of some.
const SAID_TOO_LONG: Duration = Duration::from_secs(90);

/// Photons of the runs.
const PHOTONS: [u64; 4] = [1 << 14, 1 << 16, 1 << 18, 1 << 20];

/// A ball without bumps of 20 · `frequency`² triangles, with interpolated normals.
const EVEN: [(&str, u32); 3] = [
    ("even, 5,120", 16),
    ("even, 81,920", 64),
    ("even, 327,680", 128),
];

/// A bumpy ball of 20 · `frequency`² triangles.
const BUMPS: [(&str, u32, bool); 6] = [
    ("smooth, 5,120", 16, true),
    ("smooth, 81,920", 64, true),
    ("smooth, 327,680", 128, true),
    ("flat, 5,120", 16, false),
    ("flat, 81,920", 64, false),
    ("flat, 327,680", 128, false),
];

/// The scene of balls, as its contest names it.
const BALLS: &str = "two dozen balls";

/// Shipped scenes with a closed form for all light, and the others that beams take: `cornell-caustics`, its
/// variants and `cornell-glass` have area lights.
const KNOWN: [&str; 5] = ["glass-ball", "mirror-ring", "prism", "cube", "diamond"];
const OTHERS: [&str; 13] = [
    "coffee-cup",
    "glass-ball-behind-pane",
    "glass-ball-mesh",
    "lens",
    "parabolic-mirror",
    "pool",
    "turntable-ball",
    "turntable-bumpy",
    "turntable-cube",
    "turntable-prism",
    "turntable-ring",
    "turntable-terrain",
    "water",
];

/// Which light's error.
#[derive(Clone, Copy)]
enum Light {
    /// All of it, `E`.
    All,
    /// All but the direct light.
    Caustic,
}

impl Light {
    fn error(self, trial: &Trial) -> f64 {
        match self {
            Self::All => trial.rmse_of_all,
            Self::Caustic => trial.rmse,
        }
    }
}

/// Writes the table of the scenes whose names are asked for.
pub fn costs(text: &mut String, is_asked: &dyn Fn(&str) -> bool) -> std::fmt::Result {
    let targets: Vec<String> = TARGETS.iter().map(|&one| plain(one)).collect();
    writeln!(
        text,
        "\n## Cost\n\n{SIDE} x {SIDE} texels, all signatures to depth {DEPTH} (closed forms: 8). CPU seconds of all cores, \
         direct light, discovery and forecast included, of the quickest run with at most the true error of the column's head. \
         Errors are root mean squares over lit texels, relative to the mean of that light: of all light, or of the caustic \
         alone. \"> s\": not reached by the last run, which took s; \"> s said\": a finer run says that it takes s, and was not \
         begun; \"-\": the truth cannot judge it. Photons: Sobol'; ~ continues the order of their runs of 2^14 to 2^20 photons. Said / true: of the runs, by their own word.\n\n\
         | scene | truth | error of | {} | photons {} | said / true |\n|---|---|---|{}---|",
        targets.join(" | "),
        targets.join(" | photons "),
        "--:|".repeat(2 * TARGETS.len()),
    )?;
    for name in KNOWN.into_iter().filter(|name| is_asked(name)) {
        rows(text, &Contest::known(super::DEPTH, name, SIDE))?;
    }
    for name in OTHERS.into_iter().filter(|name| is_asked(name)) {
        rows(text, &Contest::finer(DEPTH, name, SIDE, FINER))?;
    }
    for (name, frequency) in EVEN.into_iter().filter(|(name, _)| is_asked(name)) {
        let scene = below_even_ball(frequency, LAMP, SIDE);
        rows(text, &Contest::of_scene(DEPTH, name, scene, FINER))?;
    }
    for (name, frequency, is_smooth) in BUMPS.into_iter().filter(|(name, ..)| is_asked(name)) {
        let scene = below_bumps(frequency, is_smooth, LAMP, SIDE);
        let finer = if is_smooth { FINER } else { FINER_BELOW_FACETS };
        rows(text, &Contest::of_scene(DEPTH, name, scene, finer))?;
    }
    if is_asked(BALLS) {
        let scene = below_balls(SIDE);
        rows(
            text,
            &Contest::of_scene(DEPTH, BALLS, scene, FINER_BELOW_FACETS),
        )?;
    }
    Ok(())
}

fn rows(text: &mut String, contest: &Contest) -> std::fmt::Result {
    println!("cost of {}", contest.name);
    let truth = contest.finer_run.map_or("closed form".to_owned(), |error| {
        format!("beams, {}", percent(error))
    });
    let runs = Runs::of(contest);
    let photons: Vec<Trial> = PHOTONS
        .iter()
        .map(|&count| contest.photons(StreamKind::Sobol, count))
        .collect();
    for (name, light) in [("all light", Light::All), ("caustic", Light::Caustic)] {
        let mut row = format!("| {} | {truth} | {name} |", contest.name);
        for target in TARGETS {
            write!(row, " {} |", runs.seconds_to(light, target))?;
        }
        for target in TARGETS {
            write!(row, " {} |", photons_to(light, target, &photons))?;
        }
        writeln!(text, "{row} {} |", runs.said_by_true(light))?;
        println!("{row}");
    }
    Ok(())
}

/// Runs of beams, finer and finer.
struct Runs {
    trials: Vec<Trial>,
    /// Error \[relative\] of the truth.
    least: f64,
    /// What the next would have taken.
    said: Option<Duration>,
}

impl Runs {
    fn of(contest: &Contest) -> Self {
        let mut runs = Self {
            trials: Vec::new(),
            least: contest.finer_run.unwrap_or(0.0),
            said: None,
        };
        for error in ERRORS {
            let is_slow = runs
                .trials
                .last()
                .is_some_and(|last| last.seconds > LONGEST);
            if is_slow || error < 2.0 * runs.least {
                break;
            }
            let said = contest.forecast(error);
            if said > SAID_TOO_LONG {
                runs.said = Some(said);
                break;
            }
            let trial = contest.beams(error);
            println!(
                "asked {}: said {}, true {} of the caustic, {} of all light, {:.2} CPU-s",
                percent(error),
                trial.said.map_or("-".to_owned(), percent),
                percent(trial.rmse),
                percent(trial.rmse_of_all),
                trial.cpu_seconds
            );
            runs.trials.push(trial);
        }
        runs
    }

    /// CPU time of the quickest run with at most a true error.
    fn seconds_to(&self, light: Light, target: f64) -> String {
        // A truth of beams is no judge of errors below its own.
        if target <= self.least {
            return "-".to_owned();
        }
        let good = self
            .trials
            .iter()
            .filter(|one| light.error(one) <= target)
            .map(|one| one.cpu_seconds)
            .reduce(f64::min);
        match (good, self.said, self.trials.last()) {
            (Some(seconds), ..) => format!("{seconds:.2}"),
            (None, Some(said), _) => format!("> {:.0} said", said.as_secs_f64()),
            (None, None, Some(last)) => format!("> {:.0}", last.cpu_seconds),
            _ => "-".to_owned(),
        }
    }

    /// The range of the error that a run says over its true one, where the truth can judge it.
    fn said_by_true(&self, light: Light) -> String {
        let ratios = self.trials.iter().filter_map(|one| {
            let true_error = light.error(one);
            // What runs say is of the caustic alone.
            matches!(light, Light::Caustic)
                .then(|| Some(one.said? / true_error))
                .flatten()
                .filter(|_| true_error > 3.0 * self.least && true_error > 1e-9)
        });
        let (low, high) = ratios.fold((f64::INFINITY, 0.0_f64), |(low, high), one| {
            (low.min(one), high.max(one))
        });
        if low <= high {
            format!("{low:.2} to {high:.2}")
        } else {
            "-".to_owned()
        }
    }
}

/// CPU time of photons to an error: of a run, or by the order of all of them.
fn photons_to(light: Light, target: f64, runs: &[Trial]) -> String {
    if let Some(run) = runs.iter().find(|one| light.error(one) <= target) {
        return format!("{:.2}", run.cpu_seconds);
    }
    let (Some(first), Some(last)) = (runs.first(), runs.last()) else {
        return "-".to_owned();
    };
    // Photons: time has a part that does not depend on them.
    let factor = PHOTONS[PHOTONS.len() - 1] as f64 / PHOTONS[0] as f64;
    let order = (light.error(first) / light.error(last)).ln() / factor.ln();
    if order <= 0.1 {
        return "-".to_owned();
    }
    let seconds = last.cpu_seconds * (light.error(last) / target).powf(1.0 / order);
    format!("~{seconds:.1e}")
}

fn plain(part: f64) -> String {
    format!("{} %", 100.0 * part)
}
