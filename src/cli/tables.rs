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
    let method = method(args)?;
    let scene = load(&args.scene)?;
    let sensor = sensor(&scene, args.sensor.as_deref())?;
    let context = Context {
        cache: Some(args.cache.clone()),
        memory_limit: args.memory.map(beside_program),
        ..Context::default()
    };
    let context = context.beside(&scene);
    progress::stop_on_interrupt(&context.progress)?;
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

/// The technique asked for, or the first that makes tables; all of them.
fn method(args: &TablesArgs) -> anyhow::Result<Method> {
    let settings = SettingArgs::default().and(&args.set)?;
    let first = || Method::names_with_tables().first().copied();
    let name = args.method.as_deref().or_else(first).unwrap_or_default();
    Ok(Method::new(name, &settings)?.with_all_tables()?)
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
