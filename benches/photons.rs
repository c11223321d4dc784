//! Photons a second, and seconds to a given error: `cargo bench --bench photons`.
//!
//! Rates leave out set-up and direct light: they are differences of two runs' times. A photon at split depth
//! 2 (the default) follows all branches of its first two interfaces. At split depth 0 it takes one branch at
//! random everywhere, as Mitsuba's `ptracer` does.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "../tests/support/measured.rs"]
#[allow(dead_code, reason = "every program uses its own part of this")]
mod measured;

use std::path::{Path, PathBuf};
use std::time::Instant;

use measured::is_measured;
use nephroid::internals::generate::{GenerateOptions, generate};
use nephroid::internals::mitsuba;
use nephroid::internals::numeric::StreamKind;
use nephroid::internals::reference::photons::{PhotonSettings, run};
use nephroid::internals::run::Budget;
use nephroid::internals::run::Estimate;
use nephroid::internals::run::Progress;
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::chain::ChainSettings;

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name)
        .with_extension("xml")
}

fn load(path: &Path, size: u32) -> Scene {
    mitsuba::load(path, &[("size".to_owned(), size.to_string())]).expect("a shipped scene loads")
}

fn measure(scene: &Scene, settings: PhotonSettings, budget: &Budget) -> (Estimate, f64) {
    let meter = scene
        .sensors()
        .iter()
        .find(|sensor| sensor.plugin() == "irradiancemeter")
        .expect("a shipped scene has a meter");
    let start = Instant::now();
    let estimate = run(scene, meter, settings, budget, &Progress::default())
        .expect("a shipped scene can be measured");
    (estimate, start.elapsed().as_secs_f64())
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads can be started")
        .install(work)
}

fn photons(count: u64) -> Budget {
    Budget {
        work: Some(count),
        ..Budget::default()
    }
}

fn main() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    generate(
        "glass-ball-mesh",
        folder.path(),
        GenerateOptions { detail: 2 },
    )
    .expect("the mesh can be written");
    let fine_mesh = folder.path().join("glass-ball-mesh.xml");

    println!(
        "| scene | split depth | M photons/s, 1 thread | 2 threads | rays/photon | nodes/ray | tests/ray |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|");
    for (name, path) in [
        ("ball", shipped("glass-ball")),
        ("mesh ball, 82k triangles", fine_mesh),
        ("water, 28k triangles", shipped("water")),
    ] {
        let scene = load(&path, 256);
        for split_depth in [2, 0] {
            rates(name, &scene, split_depth);
        }
    }

    println!("\n| scene, 64 x 64 texels | points | s to 5 % | s to 2 % | photons to 2 % |");
    println!("|---|---|--:|--:|--:|");
    for name in [
        "glass-ball",
        "coffee-cup",
        "mirror-ring",
        "water",
        "prism",
        "lens",
    ] {
        let scene = load(&shipped(name), 64);
        for stream in [StreamKind::Sobol, StreamKind::Random] {
            time_to_error(name, &scene, stream);
        }
    }
}

fn rates(name: &str, scene: &Scene, split_depth: u32) {
    const FEW: u64 = 1 << 15;
    let many_photons = FEW + if is_measured() { 1 << 20 } else { 1 << 16 };
    let settings = PhotonSettings {
        chains: ChainSettings {
            split_depth,
            ..ChainSettings::default()
        },
        ..PhotonSettings::default()
    };
    let [(few, many, one), (_, _, two)] = [1, 2].map(|threads| {
        on_threads(threads, || {
            let (few, set_up) = measure(scene, settings, &photons(FEW));
            let (many, whole) = measure(scene, settings, &photons(many_photons));
            let rate = (many.paths - few.paths) as f64 / (whole - set_up) / 1e6;
            (few.counters, many.counters, rate)
        })
    });
    let rays = (many.rays - few.rays) as f64;
    println!(
        "| {name} | {split_depth} | {one:.2} | {two:.2} | {:.2} | {:.2} | {:.2} |",
        rays / (many_photons - FEW) as f64,
        (many.node_visits - few.node_visits) as f64 / rays,
        (many.primitive_tests - few.primitive_tests) as f64 / rays,
    );
}

fn time_to_error(name: &str, scene: &Scene, stream: StreamKind) {
    let is_all = std::env::args().any(|argument| argument == "--all");
    let most = match (is_all, is_measured()) {
        (true, _) => 16.0,
        (false, true) => 1.0,
        (false, false) => 0.1,
    };
    let settings = PhotonSettings {
        stream,
        ..PhotonSettings::default()
    };
    let to = |error: f64| {
        let budget = Budget {
            relative_error: Some(error),
            time: Some(std::time::Duration::from_secs_f64(most)),
            ..Budget::default()
        };
        let (estimate, seconds) = measure(scene, settings, &budget);
        let reached = estimate.relative_error.is_some_and(|found| found <= error);
        let text = if reached {
            format!("{seconds:.2}")
        } else {
            format!("> {most}")
        };
        (text, estimate.paths)
    };
    let (coarse, _) = to(0.05);
    let (fine, paths) = to(0.02);
    println!("| {name} | {stream:?} | {coarse} | {fine} | {paths} |");
}
