//! `nephroid inspect`: contents and requirements of a scene.

use super::args::{InspectArgs, SettingArgs};
use super::outcome::Outcome;
use super::resident::Resident;
use super::scene::load;
use crate::method::Method;
use crate::method::inspection::{Advice, Inspection};
use crate::mitsuba::LoadError;
use crate::run::Cost;

/// Runs the command.
///
/// # Errors
///
/// If the scene cannot be read, or the method that is asked for cannot work on it.
pub fn inspect(args: &InspectArgs) -> anyhow::Result<Outcome> {
    let before = Resident::now();
    let scene = load(&args.scene).map_err(|error| anyhow::anyhow!(obstacles(&error)))?;
    let mut inspection = Inspection::of(&scene);
    if let Some(name) = args.method.as_deref() {
        let method = Method::new(name, &SettingArgs::default().and(&args.set)?)?;
        let program = || match (before, Resident::now()) {
            (Some(before), Some(now)) => before.own + now.code,
            _ => 0,
        };
        let advice = Advice::of(&method, &scene, args.sensor.as_deref(), program)?;
        inspection.advice = Some(advice);
    }
    if args.json {
        say!("{}", serde_json::to_string_pretty(&inspection)?);
    } else {
        print(&inspection);
    }
    Ok(Outcome::Complete)
}

/// All problems of a scene, those with one message together.
fn obstacles(error: &LoadError) -> String {
    if error.others.is_empty() {
        return error.to_string();
    }
    let mut places: Vec<(&str, Vec<String>)> = Vec::new();
    for one in error.all() {
        let at = one.at.to_string();
        match places
            .iter_mut()
            .find(|(message, _)| *message == one.message)
        {
            Some((_, all)) => all.push(at),
            None => places.push((&one.message, vec![at])),
        }
    }
    let lines = places.iter().map(|(message, all)| match all.as_slice() {
        [one] => format!("\n  {one}: {message}"),
        [first, others @ ..] => {
            format!("\n  {first} and {} more: {message}", others.len())
        }
        [] => String::new(),
    });
    format!(
        "{} problems keep this file from being a scene:{}",
        error.all().count(),
        lines.collect::<String>()
    )
}

/// Memory and work in a line.
fn told(cost: &Cost) -> String {
    let work = cost.work.iter();
    let work = work.map(|one| format!(", {} {}", one.count, one.name));
    format!(
        "up to {} MB of memory{}",
        cost.bytes.div_ceil(1_000_000),
        work.collect::<String>()
    )
}

/// Prints a scene's contents.
fn print(found: &Inspection) {
    say!("{}", found.scene);
    say!(
        "\nshapes ({} kB in memory)",
        found.memory_bytes.div_ceil(1000)
    );
    for shape in &found.shapes {
        let mesh = shape.mesh.as_ref().map_or_else(String::new, |mesh| {
            format!(
                ", {} triangles, {}, {} part(s)",
                shape.triangles.unwrap_or(0),
                if mesh.closed { "closed" } else { "not closed" },
                mesh.components
            )
        });
        say!(
            "  {} ({}): {}{mesh}",
            shape.id,
            shape.plugin,
            shape.material
        );
    }
    say!("\nemitters");
    for emitter in &found.emitters {
        let [r, g, b] = emitter.strength;
        say!("  {}: {r} {g} {b} {}", emitter.plugin, emitter.unit);
    }
    say!("\nsensors");
    for sensor in &found.sensors {
        let on = sensor.on.map_or_else(String::new, |on| format!(" on {on}"));
        let [width, height] = sensor.size;
        say!(
            "  {} ({}){on}: {width} x {height}",
            sensor.id,
            sensor.plugin
        );
        if let Some([method, reason]) = &sensor.suits {
            say!("    suited by {method}: {reason}");
        }
        for (method, cost) in &sensor.costs {
            say!("    {method}: {}", told(cost));
        }
    }
    say!("\nrequires modelled");
    for requirement in &found.requirements {
        let needed = if requirement.needed { "yes" } else { "no " };
        say!(
            "  {needed}  {}: {}",
            requirement.feature,
            requirement.reason
        );
    }
    if !found.ignored.is_empty() {
        say!("\nignored");
        for ignored in found.ignored {
            say!("  {}: {}: {}", ignored.at, ignored.what, ignored.why);
        }
    }
    if !found.warnings.is_empty() {
        say!("\nwarnings");
        for warning in found.warnings {
            say!("  {warning}");
        }
    }
    if let Some(advice) = &found.advice {
        print_advice(advice);
    }
}

/// Prints what a pilot says.
fn print_advice(advice: &Advice) {
    say!(
        "\n{} on sensor {}: {}",
        advice.method,
        advice.sensor,
        told(&advice.cost)
    );
    let megabytes = |bytes: u64| bytes.div_ceil(1_000_000);
    say!(
        "  the program is likely to take {} MB: {} of the run, with the light that a pilot finds; {} of the \
         scene; {} of its own",
        megabytes(advice.memory.bytes),
        megabytes(advice.memory.run),
        megabytes(advice.memory.scene),
        megabytes(advice.memory.program)
    );
    for line in &advice.lines {
        say!("  {line}");
    }
    if advice.lines.is_empty() {
        say!("  no pilot: this method gives no advice");
    }
}
