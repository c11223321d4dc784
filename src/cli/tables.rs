//! `nephroid tables`: all tables that a technique looks up, made and kept for later runs.

use std::time::Instant;

use super::args::{SettingArgs, TablesArgs};
use super::outcome::Outcome;
use super::progress;
use super::render::{beside_program, set_threads};
use super::scene::load;
use crate::method::Method;
use crate::method::sensors::{choose_camera, choose_sensor};
use crate::run::Refusal;
use crate::run::format::megabytes;
use crate::run::{Context, Cost};
use crate::scene::{Scene, Sensor};

/// Runs the command. Its outcome is incomplete if tables are missing, or not in the folder.
///
/// # Errors
///
/// If the scene cannot be read, the method has no tables for it, or the memory does not suffice.
pub fn tables(args: &TablesArgs) -> anyhow::Result<Outcome> {
    set_threads(args.threads)?;
    let mut method = method(args)?;
    let scene = load(&args.scene)?;
    let sensor = sensor(&scene, args.sensor.as_deref())?;
    let context = Context {
        cache: Some(args.cache.clone()),
        memory_limit: args.memory.map(beside_program),
        ..Context::default()
    };
    let context = context.beside(&scene);
    progress::stop_on_interrupt(&context.progress)?;
    if let Some(bytes) = args.bytes {
        method = chosen(&method, &scene, sensor, (bytes, &context))?;
    }
    let method = method.with_all_tables()?;
    method.supports(&scene, sensor)?;
    method.check_memory(&scene, sensor, &context)?;
    eprintln!(
        "{}: at most {}",
        scene.path().display(),
        described(&method.cost(&scene, sensor))
    );
    let start = Instant::now();
    let made = progress::watch(&context.progress, || {
        method.make_tables(&scene, sensor, &context, args.export.as_deref())
    })?;
    for warning in &made.report.warnings {
        eprintln!("warning: {warning}");
    }
    let account = made.report.account;
    say!(
        "{} tables made and {} read, {} in {}, {:.1} s",
        account.made,
        account.read,
        megabytes(account.bytes),
        args.cache.display(),
        start.elapsed().as_secs_f64()
    );
    if let Some(folder) = args.export.as_ref().filter(|_| !made.exported.is_empty()) {
        say!(
            "wrote {} files into {}",
            made.exported.len(),
            folder.display()
        );
    }
    if account.missing > 0 {
        eprintln!(
            "stopped: {} tables are missing; the same command goes on from there",
            account.missing
        );
    }
    Ok(if account.missing + account.unwritten > 0 {
        Outcome::Incomplete
    } else {
        Outcome::Complete
    })
}

/// The method with the settings that err least within some bytes; says what there was to choose from.
fn chosen(
    method: &Method,
    scene: &Scene,
    sensor: &Sensor,
    (bytes, context): (u64, &Context),
) -> anyhow::Result<Method> {
    let (method, choices) = progress::watch(&context.progress, || {
        method.within_bytes(scene, sensor, bytes, context)
    })?;
    say!("    tables  likely L1  measured  settings");
    for (index, one) in choices.front.iter().enumerate() {
        let percent = |error: f64| format!("{:.3} %", 100.0 * error);
        let settings: Vec<String> = one
            .settings
            .iter()
            .map(|(key, text)| format!("{key}={text}"))
            .collect();
        say!(
            "{} {:>9} {:>9} {:>9}  {}",
            if index == choices.chosen { '>' } else { ' ' },
            megabytes(one.bytes),
            percent(one.likely),
            one.measured.map_or_else(String::new, percent),
            settings.join(" ")
        );
    }
    Ok(method)
}

/// The technique asked for, or the first that makes tables.
fn method(args: &TablesArgs) -> anyhow::Result<Method> {
    let settings = SettingArgs::default().and(&args.set)?;
    let first = || Method::names_with_tables().first().copied();
    let name = args.method.as_deref().or_else(first).unwrap_or_default();
    Ok(Method::new(name, &settings)?)
}

fn sensor<'a>(scene: &'a Scene, id: Option<&str>) -> Result<&'a Sensor, Refusal> {
    let meter = choose_sensor(scene, id);
    if id.is_some() {
        return meter;
    }
    meter.or_else(|_| choose_camera(scene, None))
}

/// Work and memory beforehand.
fn described(cost: &Cost) -> String {
    let count = |name: &str, count: u64| match name.strip_prefix("bytes of ") {
        Some(what) => format!("{} of {what}", megabytes(count)),
        None if count >= 1_000_000 => format!("{:.1} M {name}", count as f64 / 1e6),
        None => format!("{count} {name}"),
    };
    let mut parts: Vec<String> = cost
        .work
        .iter()
        .map(|one| count(&one.name, one.count))
        .collect();
    parts.push(format!("{} of memory", megabytes(cost.bytes)));
    parts.join(", ")
}
