//! `nephroid attribute`: which stage of an approximation makes how much of its error.

use std::sync::Arc;

use super::Outcome;
use super::args::AttributeArgs;
use super::progress;
use super::render::load;
use super::sensor::choose_sensor;
use crate::reference::Progress;
use crate::reference::beams::BeamBudget;
use crate::study::attribution::{self, Attribution};

/// Runs the command. Its outcome is incomplete where the truth is not as good as was asked for.
///
/// # Errors
///
/// Where the scene cannot be read, approximated or measured.
pub fn attribute(args: &AttributeArgs) -> anyhow::Result<Outcome> {
    let map = args.caustic_map()?;
    let scene = load(&args.scene)?;
    let sensor = choose_sensor(&scene, args.sensor.as_deref())?;
    let progress = Arc::new(Progress::default());
    progress::stop_on_interrupt(&progress)?;
    let budget = BeamBudget {
        relative_error: Some(args.error),
        time: args.time,
        rays: None,
    };
    let found = attribution::attribute(&map, &scene, sensor, |signature| {
        progress::watch(&progress, || {
            attribution::truth_by_beams(&scene, sensor, signature, &budget, &progress)
        })
    })?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&found)?);
    } else {
        print(&scene.path().display().to_string(), &found);
    }
    Ok(if found.is_resolved {
        Outcome::Complete
    } else {
        eprintln!(
            "unresolved: the truth has a likely error of {}, not the {} asked for; figures that are smaller say nothing",
            percent(found.truth_error.unwrap_or(f64::NAN)),
            percent(args.error)
        );
        Outcome::Incomplete
    })
}

fn percent(value: f64) -> String {
    if value.is_nan() {
        "unknown".to_owned()
    } else {
        format!("{:.3} %", 100.0 * value)
    }
}

/// Prints the table.
fn print(scene: &str, found: &Attribution) {
    say!("{scene}: {} of {}", found.approximation, found.signature);
    say!("");
    say!(
        "  {:<12} {:<17} {:>12} {:>12} {:>12} {:>12}",
        "stage",
        "variant",
        "exact alone",
        "fall",
        "cumulative",
        "fall"
    );
    say!(
        "  {:<12} {:<17} {:>12} {:>12} {:>12} {:>12}",
        "(all as set)",
        "",
        percent(found.all.error),
        "",
        percent(found.all.error),
        ""
    );
    for (stage, fall) in found.stages.iter().zip(found.falls()) {
        say!(
            "  {:<12} {:<17} {:>12} {:>12} {:>12} {:>12}",
            stage.name,
            stage.variant,
            percent(stage.alone.error),
            percent(found.all.error - stage.alone.error),
            percent(stage.cumulative.error),
            percent(fall)
        );
    }
    say!("");
    say!(
        "  error            {:>12}  relative RMSE",
        percent(found.all.error)
    );
    say!(
        "  = falls          {:>12}",
        percent(found.falls().iter().sum())
    );
    say!(
        "  + residual       {:>12}  all stages exact",
        percent(found.residual())
    );
    say!(
        "  interaction      {:>12}  what the falls alone do not add up to",
        percent(found.interaction())
    );
    say!(
        "  not modelled     {:>12}  of the flux by mirrors and glass; leaving it out is an RMSE of {}",
        percent(found.not_modelled),
        percent(found.not_modelled_error)
    );
    say!(
        "  energy           {:>12}  of the truth's",
        percent(found.all.energy_ratio)
    );
    let truth = percent(found.truth_error.unwrap_or(f64::NAN));
    let word = if found.is_resolved {
        ""
    } else {
        "  unresolved: not what was asked for"
    };
    say!("  the truth's own  {truth:>12}{word}");
}
