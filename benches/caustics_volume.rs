//! A frame of caustics volumes, pass by pass: `cargo bench --bench caustics_volume`, or of some objects and
//! presets alone: `cargo bench --bench caustics_volume -- knot lowest`.
//!
//! The five objects of `cornell-caustics` on its floor of 512², with one and three slabs, by the paper's lowest
//! and best settings. The figures are medians of nine frames of an animation, in which the object turns by a
//! degree and back: the pilot's advice is made once, and the scenes are there. Milliseconds and CPU time are of
//! all that a frame takes, also beside its stages. CPU time is the mean of as many frames as take half a second,
//! of all threads. MB are the most that the heap grew by over the scenes.
//!
//! The bars are those of the knot, by two cores: 200 ms by the best settings and 30 ms by the lowest; 96 MB, or
//! 160 MB with `update=changed`. Over 1000 frames the heap should not grow.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::time::Instant;

use nephroid::internals::approximation::caustics_volume::CausticsVolume;
use nephroid::internals::approximation::{Prepared, Technique as _};
use nephroid::internals::mitsuba;
use nephroid::internals::run::Context;
use nephroid::internals::scene::Scene;
use peak_alloc::PeakAlloc;
use support::cpu;
use support::measured::{is_measured, long, times};
use support::scenes::{bundled_file, meter};
use support::technique::values;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

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

/// Frames by preset, slabs and update, with the milliseconds on two cores and the MB above the scene that the
/// knot's may take.
const FRAMES: [([&str; 3], [Option<f64>; 2]); 4] = [
    (["lowest", "1", "full"], [Some(30.0), None]),
    (["best", "1", "full"], [None, None]),
    (["best", "3", "full"], [Some(200.0), Some(96.0)]),
    (["best", "3", "changed"], [None, Some(160.0)]),
];

fn main() {
    println!("{} threads", rayon::current_num_threads());
    println!(
        "| object | preset | slabs | update | bar, ms | ms a frame | CPU ms | {} | M steps | M fragments | bar, MB | MB |",
        STAGES.join(" | ")
    );
    println!("|---|---|--:|---|{}", "--:|".repeat(STAGES.len() + 7));
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
        let scenes = ["0", "1"].map(|turn| {
            let given = [("size", "512"), ("object", object), ("turn", turn)];
            let given = given.map(|(key, value)| (key.to_owned(), value.to_owned()));
            mitsuba::load(&bundled_file("cornell-caustics"), &given).unwrap()
        });
        for (given, bars) in FRAMES {
            if is_asked(given[0], &FRAMES.map(|(given, _)| given[0])) {
                let bars = bars.map(|bar| bar.filter(|_| object == "knot"));
                row(object, &scenes, given, bars);
            }
        }
        if object == "knot" {
            growth(&scenes[0]);
        }
    }
}

/// A volume that is ready for frames of a scene.
fn ready(scene: &Scene, [preset, slabs, update]: [&str; 3]) -> Box<dyn Prepared> {
    let given = [("preset", preset), ("slabs", slabs), ("update", update)];
    let values = values(&CausticsVolume, &given);
    let made = CausticsVolume.prepare(scene, meter(scene), &values, &Context::default());
    made.unwrap()
}

/// Says by how much the heap grows over 1000 frames, which should be nothing; over ten if nothing is measured.
fn growth(scene: &Scene) {
    let mut prepared = ready(scene, ["lowest", "1", "changed"]);
    let mut after = |frames: usize| {
        for _ in 0..frames {
            let made = prepared.frame(scene, meter(scene), &Context::default());
            drop(made.unwrap());
        }
        HEAP.current_usage()
    };
    let frames = if is_measured() { 1000 } else { 10 };
    let (few, many) = (after(10), after(frames));
    println!("heap after 10 frames: {few} bytes; {frames} frames later: {many} bytes");
}

/// A line of the table.
fn row(name: &str, scenes: &[Scene; 2], given: [&str; 3], bars: [Option<f64>; 2]) {
    let counted = times(9);
    let context = Context::default();
    let before = HEAP.current_usage();
    HEAP.reset_peak_usage();
    let mut prepared = ready(&scenes[0], given);
    let mut number = 0;
    let mut frame = || {
        number += 1;
        let scene = &scenes[number % 2];
        prepared.frame(scene, meter(scene), &context).unwrap()
    };
    let cpu = cpu::milliseconds(long(0.5), || drop(frame()));
    // Before frames are kept to be counted.
    let heap = (HEAP.peak_usage() - before) as f64 / 1e6;
    let mut made: Vec<_> = (0..counted)
        .map(|_| {
            let start = Instant::now();
            let frame = frame();
            (start.elapsed().as_secs_f64(), frame)
        })
        .collect();
    made.sort_by(|one, other| one.0.total_cmp(&other.0));
    let (seconds, frame) = &made[counted / 2];
    let stages = STAGES.map(|name| {
        let passes = frame.work.iter().filter(|stage| stage.name == name);
        let seconds: f64 = passes.map(|stage| stage.seconds).sum();
        format!("{:.1}", 1e3 * seconds)
    });
    let shown = |bar: Option<f64>| bar.map_or("-".into(), |bar| format!("{bar}"));
    let work = |name: &str| frame.counters.get(name) as f64;
    println!(
        "| {name} | {} | {} | {:.1} | {:.1} | {} | {:.2} | {:.2} | {} | {heap:.0} |",
        given.join(" | "),
        shown(bars[0]),
        1e3 * seconds,
        cpu,
        stages.join(" | "),
        work("steps") / 1e6,
        work("fragments") / 1e6,
        shown(bars[1]),
    );
}
