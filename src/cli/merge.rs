//! `nephroid merge`: the shards of a run, put together exactly.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::time::Instant;

use anyhow::Context as _;

use super::args::MergeArgs;
use super::choice::choose_merged;
use super::outcome::Outcome;
use super::output;
use super::render::finish;
use super::run::Run;
use super::scene::load;
use crate::reference::parts::{Gathered, Part};
use crate::run::Context;

/// Runs the command.
///
/// # Errors
///
/// If a shard cannot be read or is of another run, or the result not written.
pub fn merge(args: &MergeArgs) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    let scene = load(&args.scene)?;
    // Before hours of work are read: what can be refused by their first lines.
    let name = args.shards.first().map(|path| method_of(path));
    let name = name.transpose()?.unwrap_or_default();
    let (sensor, method) = choose_merged(args, &name, &scene)?;
    let sensor = &sensor;
    let context = Context::default();
    method.check_memory(&scene, sensor, &context)?;
    let path = output::output_path(args.output.as_deref(), scene.path(), "exr")?;
    let mut shards = Gathered::default();
    for path in &args.shards {
        let parts = read_shard(path)?;
        let added = shards.add_shard(parts);
        added.with_context(|| path.display().to_string())?;
    }
    let rendering = method.merge(&scene, sensor, &shards, &context)?;
    let run = Run {
        scene: &scene,
        sensor,
        method: &method,
        rendering: &rendering,
        elapsed: start.elapsed(),
    };
    finish(&run, &path, args.json)?;
    Ok(Outcome::Complete)
}

/// The method that made a shard.
fn method_of(path: &Path) -> anyhow::Result<String> {
    let place = || path.display().to_string();
    let file = File::open(path).with_context(place)?;
    Part::method_of(BufReader::new(file)).with_context(place)
}

/// Reads a shard.
fn read_shard(path: &Path) -> anyhow::Result<Vec<Part>> {
    let place = || path.display().to_string();
    let file = File::open(path).with_context(place)?;
    Part::read_all(BufReader::new(file)).with_context(place)
}
