//! `nephroid merge`: the shards of a run, put together exactly.

use std::fs::File;
use std::io::BufReader;
use std::time::Instant;

use anyhow::Context as _;

use super::args::MergeArgs;
use super::choice::choose_merged;
use super::outcome::Outcome;
use super::output;
use super::render::finish;
use super::run::Run;
use super::scene::load;
use crate::reference::parts::Shards;
use crate::run::Context;

/// Runs the command.
///
/// # Errors
///
/// If a shard cannot be read or is of another run, or the result not written.
pub fn merge(args: &MergeArgs) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    let scene = load(&args.scene)?;
    // The first lines of all, before hours of work are read.
    let mut shards = Shards::default();
    for path in &args.shards {
        let name = path.display().to_string();
        let file = File::open(path).with_context(|| name.clone())?;
        shards.open(name, Box::new(BufReader::new(file)))?;
    }
    let (sensor, method) = choose_merged(args, shards.method().unwrap_or_default(), &scene)?;
    let sensor = &sensor;
    let context = Context::default();
    method.check_memory(&scene, sensor, &context)?;
    let path = output::output_path(args.output.as_deref(), scene.path(), "exr")?;
    let rendering = method.merge(&scene, sensor, &mut shards, &context)?;
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
