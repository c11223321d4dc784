//! `nephroid attribute`: which stage of an approximation makes how much of its error.

use super::args::{AttributeArgs, SettingArgs};
use super::outcome::Outcome;
use super::progress;
use super::render::load;
use super::sensor::choose_sensor;
use crate::method::Method;
use crate::run::format::percent;
use crate::run::{Budget, Context};
use crate::setting::Given;
use crate::study::attribution::{self, Attribution};

/// Runs the command. Its outcome is incomplete if the truth is not as good as was asked for.
///
/// # Errors
///
/// If the scene cannot be read, approximated or measured.
pub fn attribute(args: &AttributeArgs) -> anyhow::Result<Outcome> {
    let technique = technique(args)?;
    let scene = load(&args.scene)?;
    let sensor = choose_sensor(&scene, args.sensor.as_deref())?;
    let context = Context::default();
    progress::stop_on_interrupt(&context.progress)?;
    let budget = Budget {
        relative_error: Some(args.error),
        time: args.time,
        work: None,
    };
    let found = attribution::attribute(&technique, &scene, sensor, &context, |light| {
        progress::watch(&context.progress, || {
            attribution::truth_by_beams(&scene, sensor, light, &budget, &context)
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

/// The technique asked for, or the first that there is.
fn technique(args: &AttributeArgs) -> anyhow::Result<Method> {
    let settings = SettingArgs::default().and(&args.set)?;
    let mut techniques = Method::names()
        .into_iter()
        .filter(|name| Method::new(name, &Given::new()).is_ok_and(|method| method.is_technique()));
    let name = args.method.as_deref().or_else(|| techniques.next());
    Ok(Method::new(name.unwrap_or_default(), &settings)?)
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
