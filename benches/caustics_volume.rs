//! A frame of caustics volumes, pass by pass: `cargo bench --bench caustics_volume`, or of some objects and
//! presets alone: `cargo bench --bench caustics_volume -- knot lowest`.
//!
//! The five objects of `cornell-caustics` on its floor of 512², with one and three slabs, by the paper's lowest and
//! best settings. The figures are medians of nine frames, as in an animation: the scene and the pilot's advice are made
//! once. Milliseconds and CPU time are of all that a frame takes, also beside its stages; CPU time is the mean of as
//! many frames as take half a second, of all threads. The bars are those of the knot, by two cores: 200 ms by the best
//! settings, 30 ms by the lowest.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::time::Instant;

use nephroid::internals::approximation::Technique as _;
use nephroid::internals::approximation::caustics_volume::CausticsVolume;
use nephroid::internals::mitsuba;
use nephroid::internals::run::Context;
use nephroid::internals::scene::Scene;
use support::cpu;
use support::scenes::{bundled_file, meter};
use support::technique::values;

/// Stages whose time is shown.
const STAGES: [&str; 6] = [
    "emission",
    "buffers",
    "march",
    "projector",
    "splat",
    "smooth",
];

const OBJECTS: [&str; 5] = ["diamond", "ring", "ball", "knot", "blocks"];

/// Frames by preset and slabs, with the milliseconds that the knot's may take on two cores.
const FRAMES: [(&str, &str, Option<f64>); 3] = [
    ("lowest", "1", Some(30.0)),
    ("best", "1", None),
    ("best", "3", Some(200.0)),
];

fn main() {
    println!("{} threads", rayon::current_num_threads());
    println!(
        "| object | preset | slabs | bar, ms | ms a frame | CPU ms | {} | M steps | M fragments |",
        STAGES.join(" | ")
    );
    println!("|---|---|{}", "--:|".repeat(STAGES.len() + 6));
    let asked: Vec<String> = std::env::args().skip(1).collect();
    // One of some names, if any of them is asked for, and else all.
    let is_asked = |name: &str, names: &[&str]| {
        let is_given = |name: &str| asked.iter().any(|one| one == name);
        is_given(name) || !names.iter().any(|one| is_given(one))
    };
    for object in OBJECTS {
        if !is_asked(object, &OBJECTS) {
            continue;
        }
        let given = [("size", "512"), ("object", object)];
        let given = given.map(|(key, value)| (key.to_owned(), value.to_owned()));
        let scene = mitsuba::load(&bundled_file("cornell-caustics"), &given).unwrap();
        for (preset, slabs, bar) in FRAMES {
            if is_asked(preset, &FRAMES.map(|frame| frame.0)) {
                let bar = bar.filter(|_| object == "knot");
                row(object, &scene, [preset, slabs], bar);
            }
        }
    }
}

/// A line of the table.
fn row(name: &str, scene: &Scene, [preset, slabs]: [&str; 2], bar: Option<f64>) {
    const COUNTED: usize = 9;
    let values = values(&CausticsVolume, &[("preset", preset), ("slabs", slabs)]);
    let context = Context::default();
    let prepared = CausticsVolume.prepare(scene, meter(scene), &values, &context);
    let mut prepared = prepared.unwrap();
    let mut frame = || prepared.frame(scene, meter(scene), &context).unwrap();
    let cpu = cpu::milliseconds(0.5, || drop(frame()));
    let mut made: Vec<_> = (0..COUNTED)
        .map(|_| {
            let start = Instant::now();
            let frame = frame();
            (start.elapsed().as_secs_f64(), frame)
        })
        .collect();
    made.sort_by(|one, other| one.0.total_cmp(&other.0));
    let (seconds, frame) = &made[COUNTED / 2];
    let stages = STAGES.map(|name| {
        let passes = frame.work.iter().filter(|stage| stage.name == name);
        let seconds: f64 = passes.map(|stage| stage.seconds).sum();
        format!("{:.1}", 1e3 * seconds)
    });
    let work = |name: &str| frame.counters.get(name) as f64;
    println!(
        "| {name} | {preset} | {slabs} | {} | {:.1} | {:.1} | {} | {:.2} | {:.2} |",
        bar.map_or("-".into(), |bar| format!("{bar}")),
        1e3 * seconds,
        cpu,
        stages.join(" | "),
        work("steps") / 1e6,
        work("fragments") / 1e6,
    );
}
