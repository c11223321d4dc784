//! Error for the same time, beside Mitsuba: `cargo bench --bench mitsuba -- --all`.
//!
//! Both programs render the same scene file by turns, some seeds each, with as many threads. For each pixel
//! the variance of one render is the scatter over seeds. The sum of variances times the time of a render is
//! compared, which does not depend on the number of samples if points are random. Time is CPU time if the
//! system tells it, since another program's work is not part of it, and wall time elsewhere.
//!
//! Skipped, with the reason, if there is no Python with Mitsuba 3.9.1.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use nephroid::internals::mitsuba;
use nephroid::internals::reference::path;
use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::reference::photons;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Layer, Progress};
use nephroid::internals::scene::{Crop, Scene, Sensor};
use support::child::Answering;

const WIDTH: u32 = 40;
const HEIGHT: u32 = 30;
const SEEDS: u64 = 8;
const DEPTH: u32 = 16;

/// Samples a pixel of each render by paths.
const SAMPLES: u64 = 256;

/// Photons of each render by light tracing.
const PHOTONS: u64 = 1 << 19;

fn main() {
    if !std::env::args().any(|argument| argument == "--all") {
        println!("skipped: some minutes; cargo bench --bench mitsuba -- --all");
        return;
    }
    let mut scalar = match Mitsuba::start("scalar_rgb") {
        Ok(mitsuba) => mitsuba,
        Err(reason) => {
            println!("skipped: {reason}");
            return;
        }
    };
    let mut llvm = Mitsuba::start("llvm_ad_rgb");
    println!(
        "| scene | ours | Mitsuba | relative error ours, theirs | CPU s ours, theirs | advantage at equal time |"
    );
    println!("|---|---|---|--:|--:|--:|");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let glass = shipped("cornell-glass");
    for (name, file) in [
        ("cornell-glass, all light", glass.clone()),
        (
            "cornell-glass, its ball matt",
            with_matt_ball(&glass, folder.path()),
        ),
    ] {
        compare(name, &file, &mut scalar, &mut llvm, Ours::Path);
    }
    compare(
        "glass-ball, caustic",
        &shipped("glass-ball"),
        &mut scalar,
        &mut llvm,
        Ours::Light,
    );
}

#[derive(Clone, Copy, PartialEq)]
enum Ours {
    /// Paths, against `path`.
    Path,
    /// Photons connected to the camera, against `ptracer`.
    Light,
}

/// Images of some seeds, and the mean time of a render.
#[derive(Default)]
struct Renders {
    images: Vec<Vec<f64>>,
    seconds: f64,
}

impl Renders {
    fn add(&mut self, (image, seconds): (Vec<f64>, f64)) {
        self.images.push(image);
        self.seconds += seconds / SEEDS as f64;
    }

    /// The variance of a render relative to the value: Σ variance / Σ value², over the pixels wanted.
    fn relative_variance(&self, wanted: &[bool]) -> f64 {
        let count = self.images.len() as f64;
        let (mut variances, mut squares) = (0.0, 0.0);
        for pixel in (0..wanted.len()).filter(|&pixel| wanted[pixel]) {
            let values = self.images.iter().map(|image| image[pixel]);
            let mean = values.clone().sum::<f64>() / count;
            variances += values.map(|it| (it - mean).powi(2)).sum::<f64>() / (count - 1.0);
            squares += mean * mean;
        }
        variances / squares
    }
}

fn compare(
    name: &str,
    file: &Path,
    scalar: &mut Mitsuba,
    llvm: &mut Result<Mitsuba, String>,
    method: Ours,
) {
    let scene = mitsuba::load(file, &[]).expect("a shipped scene loads");
    let camera = small_camera(&scene);
    let mut ours = Renders::default();
    let mut others = [Renders::default(), Renders::default()];
    for seed in 1..=SEEDS {
        ours.add(timed(|| match method {
            Ours::Path => by_paths(&scene, &camera, seed, DEPTH),
            Ours::Light => by_photons(&scene, &camera, seed),
        }));
        others[0].add(scalar.render(file, method, seed));
        if let Ok(llvm) = llvm {
            others[1].add(llvm.render(file, method, seed));
        }
    }
    let wanted: Vec<bool> = match method {
        Ours::Path => vec![true; (WIDTH * HEIGHT) as usize],
        // `ptracer` also has direct light: only pixels in the ball's shadow show the noise of its caustic.
        Ours::Light => {
            let direct = by_paths(&scene, &camera, 0, 2);
            let caustic = |pixel: usize| ours.images.iter().any(|image| image[pixel] > 0.0);
            (0..direct.len())
                .map(|pixel| direct[pixel] == 0.0 && caustic(pixel))
                .collect()
        }
    };
    let variance = ours.relative_variance(&wanted);
    for (variant, other) in ["scalar_rgb", "llvm_ad_rgb"].into_iter().zip(&others) {
        if other.images.is_empty() {
            continue;
        }
        let theirs = other.relative_variance(&wanted);
        let [method, integrator] = match method {
            Ours::Path => ["path", "path"],
            Ours::Light => ["light", "ptracer"],
        };
        println!(
            "| {name} | {method} | {variant} {integrator} | {:.2} %, {:.2} % | {:.2}, {:.2} | {:.2} |",
            100.0 * variance.sqrt(),
            100.0 * theirs.sqrt(),
            ours.seconds,
            other.seconds,
            theirs * other.seconds / (variance * ours.seconds)
        );
    }
    if let Err(reason) = llvm {
        println!("| {name} | | llvm_ad_rgb: {reason} | | | |");
    }
}

fn shipped(name: &str) -> PathBuf {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    scenes.join(name).with_extension("xml")
}

/// The scene with a diffuse ball in the place of the glass one, so that none of its light is a caustic's.
fn with_matt_ball(file: &Path, folder: &Path) -> PathBuf {
    let text = std::fs::read_to_string(file).expect("a shipped scene");
    let start = text
        .find("<bsdf type=\"dielectric\"")
        .expect("a glass ball");
    let end = start + text[start..].find("</bsdf>").expect("its end") + "</bsdf>".len();
    let matt = format!("{}<bsdf type=\"diffuse\"/>{}", &text[..start], &text[end..]);
    let path = folder.join("cornell-matt.xml");
    std::fs::write(&path, matt).expect("a temporary file");
    path
}

fn small_camera(scene: &Scene) -> Sensor {
    let mut camera = scene
        .sensors()
        .iter()
        .find(|it| it.id == "camera")
        .expect("a camera")
        .clone();
    (camera.film.width, camera.film.height) = (WIDTH, HEIGHT);
    camera.film.crop = Crop {
        offset_x: 0,
        offset_y: 0,
        width: WIDTH,
        height: HEIGHT,
    };
    camera
}

fn values(layer: &Layer) -> Vec<f64> {
    layer.values.iter().map(|it| it.mean()).collect()
}

fn by_paths(scene: &Scene, camera: &Sensor, seed: u64, max_depth: u32) -> Vec<f64> {
    let settings = PathSettings {
        seed,
        max_depth: Some(max_depth),
        ..PathSettings::default()
    };
    let budget = Budget {
        work: Some(SAMPLES),
        ..Budget::default()
    };
    let found = path::run(scene, camera, settings, &budget, &Progress::default());
    values(&found.expect("a shipped scene can be rendered").0.total)
}

fn by_photons(scene: &Scene, camera: &Sensor, seed: u64) -> Vec<f64> {
    let settings = PhotonSettings {
        seed,
        ..PhotonSettings::default()
    };
    let budget = Budget {
        work: Some(PHOTONS),
        ..Budget::default()
    };
    let found = photons::run(scene, camera, settings, &budget, &Progress::default());
    values(&found.expect("a shipped scene can be rendered").total)
}

/// The result of `work`, and its CPU seconds.
fn timed(work: impl FnOnce() -> Vec<f64>) -> (Vec<f64>, f64) {
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let image = work();
    let seconds = match (cpu, cpu_seconds()) {
        (Some(before), Some(after)) => after - before,
        _ => start.elapsed().as_secs_f64(),
    };
    (image, seconds)
}

/// CPU seconds of this process, all threads: fields 14 and 15 of `/proc/self/stat` in ticks of 10 ms
/// (proc(5)).
fn cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |index: usize| fields.get(index)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// A Python process that renders on request.
struct Mitsuba(Answering);

impl Mitsuba {
    /// Starts it; returns the reason if that is not possible.
    fn start(variant: &str) -> Result<Self, String> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/render_with_mitsuba.py");
        let mut python = Command::new("python3");
        python.arg(script).arg(variant).stderr(Stdio::null());
        let mut mitsuba = Self(Answering::start(&mut python)?);
        let about = mitsuba.answer().ok_or_else(|| {
            format!("no Python with Mitsuba 3.9.1, {variant}: pip install mitsuba==3.9.1")
        })?;
        match about["version"].as_str() {
            Some("3.9.1") => Ok(mitsuba),
            other => Err(format!("Mitsuba is {other:?}, not 3.9.1")),
        }
    }

    fn answer(&mut self) -> Option<serde_json::Value> {
        serde_json::from_str(&self.0.answer()?).ok()
    }

    fn render(&mut self, file: &Path, method: Ours, seed: u64) -> (Vec<f64>, f64) {
        let (integrator, samples) = match method {
            Ours::Path => ("path", SAMPLES),
            Ours::Light => ("ptracer", PHOTONS / u64::from(WIDTH * HEIGHT)),
        };
        let job = serde_json::json!({
            "scene": file, "integrator": integrator, "max_depth": DEPTH, "width": WIDTH, "height": HEIGHT,
            "samples": samples, "seed": 1_000_003 * seed,
        });
        self.0.send(&job.to_string());
        let answer = self.answer().expect("Mitsuba renders a shipped scene");
        let values = answer["values"].as_array().expect("numbers");
        let image = values
            .iter()
            .map(|it| it.as_f64().unwrap_or(f64::NAN))
            .collect();
        let time = if cpu_seconds().is_some() {
            "cpu"
        } else {
            "wall"
        };
        (image, answer[time].as_f64().expect("seconds"))
    }
}
