//! Error for the same time, beside Mitsuba: `cargo bench --bench mitsuba -- --all`, and with `--scenes` over many
//! scenes of other people, or those whose names contain one of the words that follow.
//!
//! Both programs render the same scene file by turns, some seeds each, with as many threads. For each pixel
//! the variance of one render is the scatter over seeds. The sum of variances times the time of a render is
//! compared, which does not depend on the number of samples if points are random. Time is CPU time if the
//! system tells it, since another program's work is not part of it, and wall time elsewhere.
//!
//! Skipped, with the reason, if there is no Python with Mitsuba 3.9.1. Its `llvm_ad_rgb` takes LLVM from the system:
//! `DRJIT_LIBLLVM_PATH` names another one where it ends in an error, as 15 and 16 did with AVX-512.
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
use nephroid::internals::scene::{Crop, ReconstructionFilter, Scene, Sensor};
use support::child::Answering;

/// Number of seeds of a small image.
const SEEDS: u64 = 8;
const DEPTH: u32 = 16;

/// A small image by paths.
const SMALL: Size = Size {
    width: 40,
    height: 30,
    samples: 256,
};

/// A large one.
const LARGE: Size = Size {
    width: 640,
    height: 480,
    samples: 64,
};

/// A small image by light tracing: of about 2¹⁹ photons.
const PHOTONS: Size = Size {
    samples: 437,
    ..SMALL
};

/// Samples a pixel, depth and scenes of the comparison over many scenes. CPU time has steps of 10 ms.
const MANY_SAMPLES: u64 = 512;
const MANY_DEPTH: u32 = 8;
const MANY: &str = include_str!("../tests/mitsuba/third_party_quick.txt");

/// The most seeds of a scene there.
///
/// Where light comes by a narrow way, a few samples have most of the variance, and seeds disagree about it. If
/// none of them has met such light, they agree all the same: the ± is then too small.
const MOST_SEEDS: u64 = 32;

/// The part of the quotient of variances that its standard error is to be below.
const SURE: f64 = 0.1;

fn main() {
    let is_asked = |option: &str| std::env::args().any(|argument| argument == option);
    if is_asked("--scenes") {
        over_many_scenes();
        return;
    }
    if !is_asked("--all") {
        println!("skipped: some minutes; cargo bench --bench mitsuba -- --all");
        return;
    }
    let Some(mut scalar) = Mitsuba::scalar() else {
        return;
    };
    let mut llvm = Mitsuba::start("llvm_ad_rgb");
    println!(
        "| scene | ours | Mitsuba | relative error ours, theirs | CPU s ours, theirs | samples a CPU second, ours / theirs | advantage at equal time |"
    );
    println!("|---|---|---|--:|--:|--:|--:|");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let glass = shipped("cornell-glass");
    let matt = with_matt_ball(&glass, folder.path());
    let by_paths = |name, file: &Path, size, seeds| Contest {
        name,
        file: file.to_owned(),
        size,
        seeds,
        method: Ours::Path,
    };
    let by_light = |name, file| Contest {
        name,
        file: shipped(file),
        size: PHOTONS,
        seeds: SEEDS,
        method: Ours::Light,
    };
    for contest in [
        by_paths("cornell-glass, all light", &glass, SMALL, SEEDS),
        by_paths("the same, 640 x 480", &glass, LARGE, SEEDS / 2),
        by_paths("cornell-glass, its ball matt", &matt, SMALL, SEEDS),
        by_paths("the same, 640 x 480", &matt, LARGE, SEEDS / 2),
        by_light("glass-ball, caustic", "glass-ball"),
        by_light("diamond, caustic", "diamond"),
        by_light("water, caustic", "water"),
    ] {
        contest.run(&mut scalar, &mut llvm);
    }
}

/// By how much paths are ahead of Mitsuba's over the scenes of [`MANY`], and the median.
fn over_many_scenes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    if !folder.is_dir() {
        println!("skipped: there is no folder {}", folder.display());
        return;
    }
    let Some(mut mitsuba) = Mitsuba::scalar() else {
        return;
    };
    println!(
        "| scene | seeds | relative error ours, theirs | CPU s ours, theirs | variance | time | advantage at equal time |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|");
    let files = MANY.lines().filter(|line| !line.starts_with('#'));
    let files = files.filter_map(|line| line.split(" | ").next());
    let words: Vec<String> = std::env::args()
        .skip_while(|argument| argument != "--scenes")
        .skip(1)
        .filter(|argument| !argument.starts_with("--"))
        .collect();
    let files = files.filter(|name| words.is_empty() || words.iter().any(|it| name.contains(it)));
    let mut found: Vec<[f64; 3]> = files
        .filter_map(|name| of_one_scene(&folder, name, &mut mitsuba))
        .collect();
    for (index, what) in ["variance", "time", "advantage"].into_iter().enumerate() {
        found.sort_by(|a, b| a[index].total_cmp(&b[index]));
        let of = |place: usize| found.get(place).map_or(f64::NAN, |it| it[index]);
        let (middle, last) = (found.len() / 2, found.len().saturating_sub(1));
        println!(
            "{what}: median {:.2}, from {:.2} to {:.2}, {} scenes",
            of(middle),
            of(0),
            of(last),
            found.len()
        );
    }
}

/// Mitsuba's variance, its time, and their product, each by ours.
fn of_one_scene(folder: &Path, name: &str, mitsuba: &mut Mitsuba) -> Option<[f64; 3]> {
    let file = folder.join(name);
    let (mut ours, mut theirs) = (Renders::default(), Renders::default());
    let scene = mitsuba::load(&file, &[]).ok()?;
    let mut seed = 0;
    let variances = loop {
        seed += 1;
        let job = serde_json::json!({
            "scene": file, "integrator": "path", "max_depth": MANY_DEPTH,
            "samples": MANY_SAMPLES, "seed": 1_000_003 * seed,
        });
        let answer = mitsuba.ask(&job).expect("Mitsuba answers");
        let Some(rows) = answer["rows"].as_u64() else {
            println!("| {name} | {} | | | | | |", answer["error"]);
            return None;
        };
        theirs.add(Mitsuba::image(&answer));
        let columns = theirs.images[0].len() as u64 / rows;
        let mut camera = sized(&scene.sensors()[0], columns as u32, rows as u32);
        camera.film.filter = ReconstructionFilter::Box;
        let settings = PathSettings {
            seed,
            max_depth: Some(MANY_DEPTH),
            ..PathSettings::default()
        };
        ours.add(timed(|| {
            image_by_paths(&scene, &camera, settings, MANY_SAMPLES)
        }));
        if seed < SEEDS {
            continue;
        }
        let all = vec![true; ours.images[0].len()];
        let variances = [&ours, &theirs].map(|it| it.relative_variance(&all));
        if seed == MOST_SEEDS || uncertainty(variances) < SURE {
            break variances;
        }
    };
    let [[variance, _], [other, _]] = variances;
    let [own, their] = [&ours, &theirs].map(Renders::seconds);
    let (gain, time) = (other / variance, their / own);
    println!(
        "| {name} | {seed} | {:.2} %, {:.2} % | {own:.2}, {their:.2} | {gain:.2} ± {:.2} | {time:.2} | {:.2} |",
        100.0 * variance.sqrt(),
        100.0 * other.sqrt(),
        gain * uncertainty(variances),
        gain * time
    );
    Some([gain, time, gain * time])
}

/// The relative standard error of the quotient of two variances.
fn uncertainty(variances: [[f64; 2]; 2]) -> f64 {
    let [ours, theirs] = variances.map(|[variance, error]| error / variance);
    ours.hypot(theirs)
}

#[derive(Clone, Copy, PartialEq)]
enum Ours {
    /// Paths, against `path`.
    Path,
    /// Photons connected to the camera, against `ptracer`.
    Light,
}

impl Ours {
    /// Its name here, and that of Mitsuba's integrator.
    fn names(self) -> [&'static str; 2] {
        match self {
            Self::Path => ["path", "path"],
            Self::Light => ["light", "ptracer"],
        }
    }
}

/// Images of some seeds, and the time of all renders.
#[derive(Default)]
struct Renders {
    images: Vec<Vec<f64>>,
    seconds: f64,
}

impl Renders {
    fn add(&mut self, (image, seconds): (Vec<f64>, f64)) {
        self.images.push(image);
        self.seconds += seconds;
    }

    /// The mean time of a render.
    fn seconds(&self) -> f64 {
        self.seconds / self.images.len() as f64
    }

    /// The variance of a render relative to the value, Σ variance / Σ value² over the pixels wanted, and its
    /// standard error, by the scatter of what each seed adds to it.
    fn relative_variance(&self, wanted: &[bool]) -> [f64; 2] {
        let count = self.images.len() as f64;
        let mut of_seeds = vec![0.0; self.images.len()];
        let mut squares = 0.0;
        for pixel in (0..wanted.len()).filter(|&pixel| wanted[pixel]) {
            let values = self.images.iter().map(|image| image[pixel]);
            let mean = values.clone().sum::<f64>() / count;
            for (of_seed, value) in of_seeds.iter_mut().zip(values) {
                *of_seed += (value - mean).powi(2) * count / (count - 1.0);
            }
            squares += mean * mean;
        }
        let mean = of_seeds.iter().sum::<f64>() / count;
        let scatter = of_seeds.iter().map(|it| (it - mean).powi(2)).sum::<f64>();
        let error = (scatter / (count * (count - 1.0))).sqrt();
        [mean / squares, error / squares]
    }
}

/// The size of an image.
#[derive(Clone, Copy)]
struct Size {
    width: u32,
    height: u32,
    /// A pixel.
    samples: u64,
}

impl Size {
    fn all_samples(self) -> u64 {
        u64::from(self.width * self.height) * self.samples
    }
}

/// A scene that both programs render.
struct Contest {
    name: &'static str,
    file: PathBuf,
    size: Size,
    seeds: u64,
    method: Ours,
}

impl Contest {
    /// Renders by turns, and prints a line for each variant of Mitsuba.
    fn run(&self, scalar: &mut Mitsuba, llvm: &mut Result<Mitsuba, String>) {
        let scene = mitsuba::load(&self.file, &[]).expect("a shipped scene loads");
        let camera = scene.sensors().iter().find(|it| it.id == "camera");
        let camera = sized(camera.expect("a camera"), self.size.width, self.size.height);
        let mut ours = Renders::default();
        let mut others = [Renders::default(), Renders::default()];
        for seed in 1..=self.seeds {
            ours.add(timed(|| match self.method {
                Ours::Path => by_paths(&scene, &camera, seed, DEPTH, self.size.samples),
                Ours::Light => by_photons(&scene, &camera, seed, self.size.all_samples()),
            }));
            others[0].add(self.by(scalar, seed).expect("Mitsuba answers"));
            if let Ok(process) = llvm {
                match self.by(process, seed) {
                    Some(render) => others[1].add(render),
                    None => *llvm = Err("it ended: another LLVM may do".to_owned()),
                }
            }
        }
        let wanted: Vec<bool> = match self.method {
            Ours::Path => vec![true; ours.images[0].len()],
            // `ptracer` also has direct light: only pixels in the shadow show the noise of the caustic.
            Ours::Light => {
                let direct = by_paths(&scene, &camera, 0, 2, SMALL.samples);
                let caustic = |pixel: usize| ours.images.iter().any(|image| image[pixel] > 0.0);
                (0..direct.len())
                    .map(|pixel| direct[pixel] == 0.0 && caustic(pixel))
                    .collect()
            }
        };
        for (variant, other) in ["scalar_rgb", "llvm_ad_rgb"].into_iter().zip(&others) {
            if other.images.len() == ours.images.len() {
                self.print(variant, &ours, other, &wanted);
            }
        }
        if let Err(reason) = llvm {
            println!("| {} | | llvm_ad_rgb: {reason} | | | | |", self.name);
        }
    }

    fn print(&self, variant: &str, ours: &Renders, other: &Renders, wanted: &[bool]) {
        let [variance, theirs] = [ours, other].map(|it| it.relative_variance(wanted)[0]);
        let [own, their] = [ours, other].map(Renders::seconds);
        let [method, integrator] = self.method.names();
        println!(
            "| {} | {method} | {variant} {integrator} | {:.2} %, {:.2} % | {:.2}, {:.2} | {:.2} | {:.2} |",
            self.name,
            100.0 * variance.sqrt(),
            100.0 * theirs.sqrt(),
            own,
            their,
            their / own,
            theirs * their / (variance * own)
        );
    }

    /// A render by Mitsuba; `None` if it ended.
    fn by(&self, mitsuba: &mut Mitsuba, seed: u64) -> Option<(Vec<f64>, f64)> {
        let [_, integrator] = self.method.names();
        let job = serde_json::json!({
            "scene": self.file, "integrator": integrator, "max_depth": DEPTH,
            "width": self.size.width, "height": self.size.height,
            "samples": self.size.samples, "seed": 1_000_003 * seed,
        });
        mitsuba.ask(&job).as_ref().map(Mitsuba::image)
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

/// The sensor with a film of another size.
fn sized(sensor: &Sensor, width: u32, height: u32) -> Sensor {
    let mut camera = sensor.clone();
    (camera.film.width, camera.film.height) = (width, height);
    camera.film.crop = Crop {
        offset_x: 0,
        offset_y: 0,
        width,
        height,
    };
    camera
}

fn values(layer: &Layer) -> Vec<f64> {
    layer.values.iter().map(|it| it.mean()).collect()
}

fn by_paths(scene: &Scene, camera: &Sensor, seed: u64, max_depth: u32, samples: u64) -> Vec<f64> {
    let settings = PathSettings {
        seed,
        max_depth: Some(max_depth),
        ..PathSettings::default()
    };
    image_by_paths(scene, camera, settings, samples)
}

fn image_by_paths(
    scene: &Scene,
    camera: &Sensor,
    settings: PathSettings,
    samples: u64,
) -> Vec<f64> {
    let (budget, progress) = (Budget::work(samples), Progress::default());
    let found = path::run(scene, camera, settings, &budget, &progress);
    values(&found.expect("a scene that loads can be rendered").0.total)
}

fn by_photons(scene: &Scene, camera: &Sensor, seed: u64, photons: u64) -> Vec<f64> {
    let settings = PhotonSettings {
        seed,
        ..PhotonSettings::default()
    };
    let budget = Budget {
        work: Some(photons),
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
    /// The scalar variant; says why if it cannot be had.
    fn scalar() -> Option<Self> {
        Self::start("scalar_rgb")
            .inspect_err(|reason| println!("skipped: {reason}"))
            .ok()
    }

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

    /// The answer to a job; `None` if the process ended.
    fn ask(&mut self, job: &serde_json::Value) -> Option<serde_json::Value> {
        self.0.send(&job.to_string());
        self.answer()
    }

    /// The image of an answer, and its seconds.
    fn image(answer: &serde_json::Value) -> (Vec<f64>, f64) {
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
