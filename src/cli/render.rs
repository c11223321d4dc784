//! `nephroid render`: from a scene file to an irradiance map with its error bar.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use anyhow::Context;

use super::Outcome;
use super::args::{Method, RenderArgs, SceneArgs};
use super::memory;
use super::method;
use super::output::{self, Run, Settings};
use super::progress;
use super::sensor::{choose_camera, choose_sensor, is_camera};
use super::summary::{Summary, listed};
use crate::approximation::{Approximation, Rendering};
use crate::film::atomic;
use crate::geometry::TraversalCounters;
use crate::mitsuba;
use crate::radiometry::Rgb;
use crate::reference::beams::{self, BeamError};
use crate::reference::full::{self, PartDetail};
use crate::reference::path::{self, PathReport, PathSettings};
use crate::reference::photon_map::{self, PhotonMapError};
use crate::reference::photons::shard::Part;
use crate::reference::photons::{self, RunError, Shard};
use crate::reference::{Estimate, Layer, LayerName, Progress, Quantity};
use crate::scene::{Emitter, Scene, Sensor};
use crate::transport::chain_limits::{left_out, left_out_of_image};
use crate::transport::ledger::Ledger;
use crate::transport::path_class::PathClass;
use crate::transport::signature::Signature;

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
    let sensor = if matches!(args.method, Some(Method::Path | Method::Full)) {
        choose_camera(&scene, args.sensor.as_deref())?
    } else {
        choose_sensor(&scene, args.sensor.as_deref())?
    };
    if args.method != Some(Method::CausticMap) {
        anyhow::ensure!(args.set.is_empty(), "--set is for --method caustic-map");
    }
    let choice = method::choose(args, &scene, sensor)?;
    memory::check_film(&scene, sensor, choice.method, args.shared.layers)?;
    let extension = if args.shard.is_some() { "shard" } else { "exr" };
    let path = output::output_path(args.output.as_deref(), scene.path(), extension)?;
    let job = Job {
        args,
        scene: &scene,
        sensor,
        path: &path,
        progress: &progress,
        start,
    };
    if let Some(notice) = choice.notice {
        eprintln!("note: {notice}");
    }
    match (choice.method, args.shard) {
        (Method::Beams, _) => job.beams(),
        (Method::Path, _) => job.path(),
        (Method::PhotonMap, _) => job.photon_maps(),
        (Method::Full, _) => job.full(),
        (Method::CausticMap, _) => job.caustic_map(),
        (Method::Photons, None) => job.photons(),
        (Method::Photons, Some(shard)) => job.shard(shard),
    }
}

/// A run asked for, with all it needs.
struct Job<'a> {
    args: &'a RenderArgs,
    scene: &'a Scene,
    sensor: &'a Sensor,
    path: &'a Path,
    progress: &'a Progress,
    start: Instant,
}

impl Job<'_> {
    fn beams(&self) -> anyhow::Result<Outcome> {
        let (settings, budget) = self.args.beams()?;
        let (estimate, report, mut warnings) = progress::watch(self.progress, || {
            let mut setup =
                beams::run::Setup::new(self.scene, self.sensor, settings, self.progress)?;
            let mut warnings = no_caustic(setup.is_dark());
            warnings.extend(missed(&setup));
            warnings.extend(left_out(self.scene));
            let (estimate, report) = setup.run(&budget)?;
            Ok::<_, BeamError>((estimate, report, warnings))
        })?;
        if report.passes == 0 && warnings.is_empty() {
            warnings.push(
                "the run ended before the first pass did: nothing is known of the caustic"
                    .to_owned(),
            );
        } else if report.passes > 0 && estimate.incomplete {
            warnings.push("the error asked for was not reached".to_owned());
        }
        warnings.extend(unknown_direct(&estimate));
        self.finish(Settings::Beams(&settings, &report), &estimate, warnings)
    }

    fn photons(&self) -> anyhow::Result<Outcome> {
        let (settings, budget) = self.args.photons()?;
        let (estimate, mut warnings) = progress::watch(self.progress, || {
            let setup = photons::run::Setup::new(self.scene, self.sensor, settings, self.progress)?;
            let mut warnings = no_caustic(setup.light().is_empty());
            warnings.extend(left_out(self.scene));
            let mut estimate = setup.run(&budget)?;
            if estimate.paths == 0 && !setup.light().is_empty() {
                estimate.incomplete = true;
                warnings.push(
                    "the run ended before the first replicate did: nothing is known of the caustic"
                        .to_owned(),
                );
            }
            Ok::<_, RunError>((estimate, warnings))
        })?;
        warnings.extend(unknown_direct(&estimate));
        self.finish(Settings::Photons(&settings), &estimate, warnings)
    }

    fn path(&self) -> anyhow::Result<Outcome> {
        let (settings, budget) = self.args.path(self.scene.integrator())?;
        let (estimate, report) = progress::watch(self.progress, || {
            path::run(self.scene, self.sensor, settings, &budget, self.progress)
        })?;
        let mut warnings = cut_off(&report);
        if report.samples == 0 {
            warnings.push(
                "the run ended before the first replicate did: nothing is known of the image"
                    .to_owned(),
            );
        }
        warnings.extend(out_of_reach(self.scene, &settings));
        self.finish(Settings::Path(&settings, &report), &estimate, warnings)
    }

    fn photon_maps(&self) -> anyhow::Result<Outcome> {
        let (settings, budget) = self.args.photon_maps()?;
        let (estimate, report, mut warnings) = progress::watch(self.progress, || {
            let setup =
                photon_map::run::Setup::new(self.scene, self.sensor, settings, self.progress)?;
            let mut warnings = no_caustic(setup.light().is_empty());
            warnings.extend(left_out(self.scene));
            let (estimate, report) = setup.run(&budget)?;
            Ok::<_, PhotonMapError>((estimate, report, warnings))
        })?;
        if report.passes == 0 {
            warnings.push(
                "the run ended before the first pass did: nothing is known of the caustic"
                    .to_owned(),
            );
        }
        self.finish(Settings::PhotonMap(&settings, &report), &estimate, warnings)
    }

    fn full(&self) -> anyhow::Result<Outcome> {
        let (settings, budget) = self.args.full(self.scene.integrator())?;
        let (estimate, report) = progress::watch(self.progress, || {
            full::run(self.scene, self.sensor, settings, &budget, self.progress)
        })?;
        let mut warnings = report.notices.clone();
        for part in &report.parts {
            if part.incomplete {
                warnings.push(format!(
                    "the part of {} ({}) did not come to its end",
                    part.method.name(),
                    listed(part.classes)
                ));
            }
            if let PartDetail::Path(report) = &part.detail {
                warnings.extend(cut_off(report));
            }
        }
        self.finish(Settings::Full(&settings, &report), &estimate, warnings)
    }

    fn caustic_map(&self) -> anyhow::Result<Outcome> {
        let map = self.args.caustic_map()?;
        let rendering = map.run(self.scene, self.sensor)?;
        let estimate = as_estimate(&rendering, is_camera(self.sensor));
        let warnings = vec![format!(
            "a caustic map is an approximation: of all light it models {} alone, and its error is not known here \
             (see nephroid attribute)",
            rendering.signature
        )];
        self.finish(Settings::CausticMap(&map, &rendering), &estimate, warnings)
    }

    fn shard(&self, shard: Shard) -> anyhow::Result<Outcome> {
        let (settings, budget) = self.args.photons()?;
        let part =
            progress::watch(self.progress, || {
                photons::run::Setup::new(self.scene, self.sensor, settings, self.progress)?
                    .run_shard(&self.sensor.id, &budget, shard)
            })?;
        let Some(part) = part else {
            eprintln!("stopped: nothing was written, part of a shard is of no use");
            return Ok(Outcome::Incomplete);
        };
        write_shard(&part, self.path)?;
        say!("wrote {}", self.path.display());
        Ok(Outcome::Complete)
    }

    fn finish(
        &self,
        method: Settings,
        estimate: &Estimate,
        mut warnings: Vec<String>,
    ) -> anyhow::Result<Outcome> {
        let is_all_light = matches!(method, Settings::Path(..) | Settings::Full(..));
        if estimate.quantity == Quantity::Radiance && !is_all_light {
            // Photon maps are looked up on any surface that scatters.
            if !matches!(method, Settings::PhotonMap(..)) {
                warnings.extend(left_out_of_image(self.scene));
            }
            warnings.push(format!(
                "{} on a camera measure light by way of mirrors and glass only: direct light (LD) is not \
                 in the image",
                method.plural()
            ));
        }
        let run = Run {
            scene: self.scene,
            sensor: self.sensor,
            method,
            estimate,
            elapsed: self.start.elapsed(),
            warnings,
        };
        finish(&run, self.path, self.args.json)?;
        let stopped = self.progress.stop.load(Ordering::Relaxed);
        Ok(if stopped || estimate.incomplete {
            Outcome::Incomplete
        } else {
            Outcome::Complete
        })
    }
}

/// An approximation's image as methods deliver theirs: one layer, of whose error nothing is known.
fn as_estimate(rendering: &Rendering, is_camera: bool) -> Estimate {
    let layer = |name| {
        let mut layer = Layer::dark(name, rendering.values.len());
        layer.irradiance.clone_from(&rendering.values);
        layer.standard_error.fill(Rgb::grey(f64::NAN));
        layer
    };
    let work = rendering.total_work();
    Estimate {
        quantity: if is_camera {
            Quantity::Radiance
        } else {
            Quantity::Irradiance
        },
        width: rendering.width,
        height: rendering.height,
        total: layer(LayerName::Total),
        layers: vec![layer(LayerName::Path(rendering.signature))],
        counts: vec![0; rendering.values.len()],
        ledger: Ledger::default(),
        paths: rendering.work.first().map_or(0, |stage| stage.work.photons),
        counters: TraversalCounters {
            rays: work.rays,
            ..TraversalCounters::default()
        },
        relative_error: None,
        incomplete: false,
    }
}

/// What to warn of where paths did not come to their end.
fn cut_off(report: &PathReport) -> Vec<String> {
    let is_any = report.cut_off > 0;
    is_any
        .then(|| {
            format!(
                "{} paths were cut off after 65536 surfaces: give a --max-depth, or a lower --rr-depth",
                report.cut_off
            )
        })
        .into_iter()
        .collect()
}

/// What to warn of where paths from a camera cannot find a caustic that there is.
fn out_of_reach(scene: &Scene, settings: &PathSettings) -> Option<String> {
    let has_specular = scene.objects().iter().any(|object| {
        scene
            .material(object.material)
            .is_specular(scene.materials())
    });
    let has_delta = scene.emitters().iter().any(Emitter::is_delta);
    let is_wanted = settings.classes.contains(PathClass::Caustic);
    (has_specular && has_delta && is_wanted).then(|| {
        "paths from a camera never find the caustics of lights that are a point or a direction: those \
         are black in this image, as in Mitsuba's `path`"
            .to_owned()
    })
}

fn no_caustic(is_dark: bool) -> Vec<String> {
    let warning = "no light was found that meets a surface which mirrors or refracts, and gets to the \
                   sensor: no caustic, only direct light";
    is_dark.then(|| warning.to_owned()).into_iter().collect()
}

/// What there is to say where beams found no light, though some sets out.
fn missed(setup: &beams::run::Setup) -> Option<String> {
    let unseen = setup.unseen().filter(|unseen| !unseen.is_black())?;
    Some(format!(
        "up to {:.1e} W may have been missed: that is the upper bound of every texel",
        unseen.mean()
    ))
}

/// What there is to say where direct light was not measured.
fn unknown_direct(estimate: &Estimate) -> Option<String> {
    let direct = LayerName::Path(Signature::DIRECT);
    let is_unknown = estimate
        .layers
        .iter()
        .any(|layer| layer.name == direct && layer.is_unknown());
    is_unknown.then(|| {
        "the run ended before direct light (LD) was measured: nothing is known of it".to_owned()
    })
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
