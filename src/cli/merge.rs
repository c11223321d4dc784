//! `nephroid merge`: the shards of a run, put together exactly.

use std::time::Instant;

use super::args::MergeArgs;
use super::outcome::Outcome;
use super::output;
use super::render::{finish, read_shard};
use super::run::Run;
use super::scene::load;
use crate::method::Method;
use crate::method::sensors::choose_sensor;
use crate::run::Context;

/// Runs the command.
///
/// # Errors
///
/// If a shard cannot be read or is of another run, or the result not written.
pub fn merge(args: &MergeArgs) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    let scene = load(&args.scene)?;
    let sensor = choose_sensor(&scene, args.sensor.as_deref())?;
    let sensor = &args.filter.filtered(sensor);
    let method = Method::new("photons", &args.settings.given)
        .map_err(|error| args.settings.retold(error))?;
    let context = Context::default();
    method.check_memory(&scene, sensor, &context)?;
    let path = output::output_path(args.output.as_deref(), scene.path(), "exr")?;
    let parts = args
        .shards
        .iter()
        .map(|shard| read_shard(shard))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let rendering = method.merge(&scene, sensor, parts, &context)?;
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
