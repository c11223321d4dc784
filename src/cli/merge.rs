//! `nephroid merge`: the shards of a run, put together exactly.

use std::time::Instant;

use super::Outcome;
use super::args::{MergeArgs, Method};
use super::memory;
use super::output::{self, Run};
use super::render::{finish, load, read_shard};
use super::sensor::choose_sensor;
use crate::reference::Progress;
use crate::reference::photons::run::Setup;

/// Runs the command.
///
/// # Errors
///
/// Where a shard cannot be read or is of another run, or the result not written.
pub fn merge(args: &MergeArgs) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    let scene = load(&args.scene)?;
    let sensor = choose_sensor(&scene, args.sensor.as_deref())?;
    let settings = args.shared.photons(&args.photon);
    memory::check_film(&scene, sensor, Method::Photons, args.shared.layers)?;
    let path = output::output_path(args.output.as_deref(), scene.path(), "exr")?;
    let parts = args
        .shards
        .iter()
        .map(|shard| read_shard(shard))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let progress = Progress::default();
    let setup = Setup::new(&scene, sensor, settings, &progress)?;
    let estimate = setup.merge(&sensor.id, parts)?;
    let run = Run {
        scene: &scene,
        sensor,
        method: output::Settings::Photons(&settings),
        estimate: &estimate,
        elapsed: start.elapsed(),
        warnings: Vec::new(),
    };
    finish(&run, &path, args.json)?;
    Ok(Outcome::Complete)
}
