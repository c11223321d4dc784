//! `nephroid render`: from a scene file to an irradiance map with its error bar.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use anyhow::Context;

use super::Outcome;
use super::args::{RenderArgs, SceneArgs, choose_sensor};
use super::memory;
use super::output::{self, Run};
use super::progress;
use super::summary::Summary;
use crate::film::atomic;
use crate::mitsuba;
use crate::reference::photons::run::Setup;
use crate::reference::photons::shard::Part;
use crate::reference::photons::{Progress, RunError};
use crate::scene::Scene;

/// Runs the command.
///
/// # Errors
///
/// Where the scene cannot be read, cannot be rendered as asked, or the result not written.
pub fn render(args: &RenderArgs) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    set_threads(args.threads)?;
    let progress = Arc::new(Progress::default());
    progress::stop_on_interrupt(&progress)?;
    let scene = load(&args.scene)?;
    let sensor = choose_sensor(&scene, args.sensor.as_deref())?;
    let settings = args.photon.settings();
    let budget = args.budget()?;
    memory::check_film(&scene, sensor, args.photon.layers)?;
    let extension = if args.shard.is_some() { "shard" } else { "exr" };
    let path = output::output_path(args.output.as_deref(), scene.path(), extension)?;
    if let Some(shard) = args.shard {
        let part = progress::watch(&progress, || {
            Setup::new(&scene, sensor, settings, &progress)?.run_shard(&sensor.id, &budget, shard)
        })?;
        let Some(part) = part else {
            eprintln!("stopped: nothing was written, part of a shard is of no use");
            return Ok(Outcome::Incomplete);
        };
        write_shard(&part, &path)?;
        say!("wrote {}", path.display());
        return Ok(Outcome::Complete);
    }
    let (estimate, warnings) = progress::watch(&progress, || {
        let setup = Setup::new(&scene, sensor, settings, &progress)?;
        let mut warnings = Vec::new();
        if setup.light().is_empty() {
            warnings.push(
                "no light can meet a surface that mirrors or refracts: there is no caustic, only direct light"
                    .to_owned(),
            );
        }
        let mut estimate = setup.run(&budget)?;
        if estimate.paths == 0 && !setup.light().is_empty() {
            estimate.incomplete = true;
            warnings.push(
                "the run ended before the first replicate did: nothing is known of the caustic, \
                 and only direct light is in the result"
                    .to_owned(),
            );
        }
        Ok::<_, RunError>((estimate, warnings))
    })?;
    let run = Run {
        scene: &scene,
        sensor,
        settings: &settings,
        estimate: &estimate,
        elapsed: start.elapsed(),
        warnings,
    };
    finish(&run, &path, args.json)?;
    Ok(
        if progress.stop.load(Ordering::Relaxed) || estimate.incomplete {
            Outcome::Incomplete
        } else {
            Outcome::Complete
        },
    )
}

/// Reads a scene.
///
/// # Errors
///
/// As [`mitsuba::load`].
pub(super) fn load(args: &SceneArgs) -> anyhow::Result<Scene> {
    Ok(mitsuba::load(&args.scene, &args.define)?)
}

/// Writes a result's files and prints its summary.
///
/// # Errors
///
/// Where a file cannot be written.
pub(super) fn finish(run: &Run, path: &Path, json: bool) -> anyhow::Result<()> {
    let mut summary = Summary::of(run);
    let picture = output::write(run, &summary, path)?;
    summary.files = vec![path.display().to_string(), picture.display().to_string()];
    if json {
        say!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        say!("{}", summary.to_string().trim_end());
    }
    Ok(())
}

fn write_shard(part: &Part, path: &Path) -> anyhow::Result<()> {
    atomic::write(path, |file| part.write_to(file).map_err(io::Error::other))?;
    Ok(())
}

/// Reads a shard.
///
/// # Errors
///
/// Where the file is missing or no shard.
pub(super) fn read_shard(path: &Path) -> anyhow::Result<Part> {
    let place = || path.display().to_string();
    let file = File::open(path).with_context(place)?;
    Part::read_from(BufReader::new(file)).with_context(place)
}

fn set_threads(threads: Option<u16>) -> anyhow::Result<()> {
    if let Some(threads) = threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build_global()
            .context("cannot start the threads")?;
    }
    Ok(())
}
