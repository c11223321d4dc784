//! `nephroid attribute`: which stage of an approximation makes how much of its error.

use anyhow::Context as _;

use super::args::{AttributeArgs, SettingArgs};
use super::outcome::Outcome;
use super::progress;
use super::scene::load;
use crate::metric::Figure;
use crate::run::format::{percent, three_digits};
use crate::setting::Words as _;
use crate::study::attribution::Attribution;
use crate::study::attribution::wanted::{Limits, Wanted};

/// Runs the command. Its outcome is incomplete if the truth is not as good as was asked for.
///
/// # Errors
///
/// If the scene cannot be read, approximated or measured.
pub fn attribute(args: &AttributeArgs) -> anyhow::Result<Outcome> {
    let given = SettingArgs::default().and(&args.set)?;
    let scene = load(&args.scene)?;
    let context = args.cache.context();
    let limits = Limits {
        truth: args.truth.clone(),
        error: args.error,
        time: args.time,
        side: args.side.into(),
    };
    let method = (args.method.as_deref(), &given);
    let wanted = Wanted::new(&scene, args.sensor.as_deref(), method, &limits)?;
    progress::stop_on_interrupt(&context.progress)?;
    let listener = &mut progress::lines("stages".to_owned());
    let found = wanted.attribute(&scene, &context, listener, |truth| {
        progress::watch(&context.progress, truth)
    })?;
    let Some(found) = found else {
        eprintln!("stopped: nothing is known of the stages");
        return Ok(Outcome::Incomplete);
    };
    if args.json {
        say!("{}", serde_json::to_string_pretty(&found)?);
    } else {
        print(&scene.path().display().to_string(), &found, args.figure)?;
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

/// Prints the table of one figure.
fn print(scene: &str, found: &Attribution, figure: Figure) -> anyhow::Result<()> {
    let shares = found.of(figure).with_context(|| {
        let name = figure.word();
        format!("{name} is not defined for all subsets of stages: some of them make a black image")
    })?;
    let value = |value: f64| shown(figure, value);
    let signed = |share: f64| format!("{}{}", if share > 0.0 { "+" } else { "" }, value(share));
    let [width, height] = found.size;
    say!(
        "{scene}: {} of {}, {width} x {height} texels, {} runs",
        found.approximation,
        found.light,
        found.runs
    );
    say!("");
    say!(
        "  {:<12} {:<17} {:>14} {:>14} {:>14} {:>14}",
        "stage",
        "variant",
        "adds",
        "if it is exact",
        "if alone",
        "cumulative"
    );
    for (stage, share) in found.stages.iter().zip(&shares.stages) {
        let error = share.share.standard_error;
        say!(
            "  {:<12} {:<17} {:>14} {:>14} {:>14} {:>14}{}",
            stage.name,
            stage.variant,
            signed(share.share.value),
            value(share.fixed),
            value(share.spoiled),
            value(share.cumulative),
            if error > 0.0 {
                format!("  ± {}", value(error))
            } else {
                String::new()
            }
        );
    }
    say!(
        "  {:<12} {:<17} {:>14}",
        "all exact",
        "",
        signed(shares.residual)
    );
    say!(
        "  = {:<28} {:>14}  {}",
        figure.word(),
        signed(shares.whole),
        figure.meaning()
    );
    say!("");
    say!(
        "adds: the stage's share (Shapley's value); shares and what is left with all stages exact add up"
    );
    say!(
        "if it is exact: the figure with this stage exact; if alone: with all others exact; cumulative: with it and"
    );
    say!("all before it exact");
    say!("");
    for figure in Figure::OF_LIGHT {
        if let Some(other) = found.of(figure) {
            say!("  {:<12} {}", other.figure, shown(figure, other.whole));
        }
    }
    say!(
        "  not modelled {} of the flux by mirrors and glass",
        percent(found.not_modelled)
    );
    if let Some(error) = found.twin_error {
        say!("  noise of exact twins {} of the light", percent(error));
    }
    let truth = percent(found.truth_error.unwrap_or(f64::NAN));
    let word = if found.is_resolved {
        ""
    } else {
        ", unresolved: not what was asked for"
    };
    say!("  the truth's own error {truth}{word}");
    Ok(())
}

/// A value of a figure in its unit.
fn shown(figure: Figure, value: f64) -> String {
    if figure.is_length() {
        format!("{} texels", three_digits(value))
    } else {
        format!("{} %", three_digits(100.0 * value))
    }
}
