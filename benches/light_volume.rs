//! A frame of light volumes, stage by stage: `cargo bench --bench light_volume`.
//!
//! `water` on its floor of 512², and the four views of `pool` at 1024 x 768, with 120² vertices of water and the
//! defaults. The figures are the median of nine frames of a meter and of three of a view; the hierarchy is made
//! once. CPU time is that of all threads, of a frame with its preparation.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use nephroid::internals::mitsuba;
use nephroid::internals::scene::Scene;
use support::cpu;
use support::light_volume::{run_on, volume};
use support::measured::times;
use support::scenes::bundled_file;

/// Stages whose time is shown.
const STAGES: [&str; 6] = [
    "surface",
    "flux",
    "shadow",
    "shadow-cull",
    "clamp",
    "inside",
];

fn main() {
    println!("{} threads", rayon::current_num_threads());
    println!(
        "| sensor | ms a frame | CPU ms | {} | beams | M fragments |",
        STAGES.join(" | ")
    );
    println!("|---|{}", "--:|".repeat(STAGES.len() + 4));
    let given = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
        let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        pairs.iter().map(owned).collect()
    };
    let water = mitsuba::load(&bundled_file("water"), &given(&[("size", "512")])).unwrap();
    row("water", &water, "floor", 9);
    let pool = mitsuba::load(&bundled_file("pool"), &[]).unwrap();
    for view in ["view-50", "view-35", "view-100", "view-25"] {
        row("pool", &pool, view, 3);
    }
}

/// A line of the table.
fn row(name: &str, scene: &Scene, sensor: &str, frames: usize) {
    let frames = times(frames);
    let method = volume(&[]);
    let before = cpu::seconds();
    let mut made: Vec<_> = (0..frames)
        .map(|_| run_on(&method, scene, sensor))
        .collect();
    let cpu = (cpu::seconds() - before) / frames as f64;
    made.sort_by_key(|frame| frame.frame_time);
    let frame = &made[frames / 2];
    let stages = STAGES.map(|name| {
        let found = frame.stages.iter().find(|stage| stage.name == name);
        format!("{:.1}", 1e3 * found.map_or(0.0, |stage| stage.seconds))
    });
    let work = |name: &str| {
        let found = frame.counters.iter().find(|one| one.name == name);
        found.map_or(0, |one| one.count) as f64
    };
    println!(
        "| {name}, {sensor} | {:.1} | {:.1} | {} | {} | {:.2} |",
        1e3 * frame.frame_time.unwrap_or_default().as_secs_f64(),
        1e3 * cpu,
        stages.join(" | "),
        work("beams"),
        work("fragments") / 1e6,
    );
}
