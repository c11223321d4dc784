//! `nephroid render`: from a scene file to a map with its error bar.

use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

use anyhow::Context as _;

use super::args::RenderArgs;
use super::choice::choose;
use super::frames;
use super::outcome::Outcome;
use super::output;
use super::progress;
use super::run::Run;
use super::scene::load;
use super::summary::Summary;
use crate::film::atomic;
use crate::method::Method;
use crate::reference::shard::Shard;
use crate::run::{Budget, Context};
use crate::scene::{Scene, Sensor};
use crate::study::file;

/// Memory \[bytes\] of the program itself, threads' stacks and buffers: a little more than films of 16 x 16
/// texels take by methods without tables, on two threads.
const PROGRAM: u64 = 40_000_000;

/// Runs the command.
///
/// # Errors
///
/// If the scene cannot be read, cannot be rendered as asked, or the result not written.
pub fn render(args: &RenderArgs) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    set_threads(args.threads)?;
    let mut context = args.cache.context();
    context.memory_limit = args.memory.map(beside_program);
    progress::stop_on_interrupt(&context.progress)?;
    let extension = if args.shard.is_some() { "shard" } else { "exr" };
    let frames = file::frames(&args.frames)?;
    if !frames.is_empty() {
        return frames::render(args, &frames, extension, &context);
    }
    let scene = load(&args.scene)?;
    let context = context.beside(&scene);
    let (sensor, method, notice) = choose(args, &scene)?;
    let sensor = &sensor;
    method.check_memory(&scene, sensor, &context)?;
    let path = output::output_path(args.output.as_deref(), scene.path(), extension)?;
    if let Some(notice) = notice {
        eprintln!("note: {notice}");
    }
    if let Some(shard) = args.shard {
        return trace_shard(&method, &scene, sensor, shard, &path, &context);
    }
    let rendering = progress::watch(&context.progress, || {
        method.run(&scene, sensor, &Budget::default(), &context)
    })?;
    let run = Run {
        scene: &scene,
        sensor,
        method: &method,
        rendering: &rendering,
        elapsed: start.elapsed(),
    };
    finish(&run, &path, args.json)?;
    // As the file says: whoever interrupts while it is written is too late.
    Ok(if rendering.estimate.incomplete {
        Outcome::Incomplete
    } else {
        Outcome::Complete
    })
}

fn trace_shard(
    method: &Method,
    scene: &Scene,
    sensor: &Sensor,
    shard: Shard,
    path: &Path,
    context: &Context,
) -> anyhow::Result<Outcome> {
    let file = progress::watch(&context.progress, || {
        method.run_shard(scene, sensor, shard, context)
    })?;
    let Some(contents) = file else {
        eprintln!("stopped: nothing was written, part of a shard is of no use");
        return Ok(Outcome::Incomplete);
    };
    atomic::write(path, |file| file.write_all(&contents))?;
    say!("wrote {}", path.display());
    Ok(Outcome::Complete)
}

/// Writes a result's files and prints its summary.
///
/// # Errors
///
/// Where a file cannot be written.
pub(super) fn finish(run: &Run, path: &Path, json: bool) -> anyhow::Result<()> {
    let mut summary = Summary::of(run);
    let files = output::write(run, &summary, path)?;
    summary.files = files
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    if json {
        say!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        say!("{}", summary.to_string().trim_end());
    }
    Ok(())
}

/// What a limit on the program's memory \[bytes\] leaves for scene and run.
pub(super) fn beside_program(limit: u64) -> u64 {
    limit.saturating_sub(PROGRAM)
}

/// Uses so many threads, where a number is given.
///
/// # Errors
///
/// Where they cannot be started.
pub(super) fn set_threads(threads: Option<u16>) -> anyhow::Result<()> {
    if let Some(threads) = threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build_global()
            .context("cannot start the threads")?;
    }
    Ok(())
}
