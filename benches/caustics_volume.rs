//! A frame of caustics volumes, pass by pass: `cargo bench --bench caustics_volume`.
//!
//! The five objects of `cornell-caustics` on its floor of 512², with one and three slabs, by the paper's lowest and
//! best settings. The figures are the median of nine frames; the volume is found once. CPU time is that of all
//! threads, of a frame with its preparation.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use nephroid::internals::mitsuba;
use nephroid::internals::run::Rendering;
use nephroid::internals::scene::Scene;
use support::caustics_volume::{rendered, volume};
use support::cpu;
use support::scenes::bundled_file;

/// Stages whose time is shown.
const STAGES: [&str; 6] = [
    "emission",
    "buffers",
    "march",
    "projector",
    "splat",
    "smooth",
];

fn main() {
    println!("{} threads", rayon::current_num_threads());
    println!(
        "| object | preset | slabs | ms a frame | CPU ms | {} | M steps | M fragments |",
        STAGES.join(" | ")
    );
    println!("|---|---|{}", "--:|".repeat(STAGES.len() + 5));
    for object in ["diamond", "ring", "ball", "knot", "blocks"] {
        let given = [("size", "512"), ("object", object)];
        let given = given.map(|(key, value)| (key.to_owned(), value.to_owned()));
        let scene = mitsuba::load(&bundled_file("cornell-caustics"), &given).unwrap();
        for (preset, slabs) in [("lowest", "1"), ("best", "1"), ("best", "3")] {
            row(object, &scene, preset, slabs);
        }
    }
}

/// A line of the table.
fn row(name: &str, scene: &Scene, preset: &str, slabs: &str) {
    const FRAMES: usize = 9;
    let method = volume(&[("preset", preset), ("slabs", slabs)]);
    let before = cpu::seconds();
    let mut made: Vec<Rendering> = (0..FRAMES).map(|_| rendered(&method, scene)).collect();
    let cpu = (cpu::seconds() - before) / FRAMES as f64;
    made.sort_by_key(|frame| frame.frame_time);
    let frame = &made[FRAMES / 2];
    let stages = STAGES.map(|name| {
        let passes = frame.stages.iter().filter(|stage| stage.name == name);
        let seconds: f64 = passes.map(|stage| stage.seconds).sum();
        format!("{:.1}", 1e3 * seconds)
    });
    let work = |name: &str| {
        let found = frame.counters.iter().find(|one| one.name == name);
        found.map_or(0, |one| one.count) as f64
    };
    println!(
        "| {name} | {preset} | {slabs} | {:.1} | {:.1} | {} | {:.2} | {:.2} |",
        1e3 * frame.frame_time.unwrap_or_default().as_secs_f64(),
        1e3 * cpu,
        stages.join(" | "),
        work("steps") / 1e6,
        work("fragments") / 1e6,
    );
}
