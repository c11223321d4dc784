//! A frame of caustic mapping, stage by stage: `cargo bench --bench caustic_map`, or of some splats alone:
//! `cargo bench --bench caustic_map -- thin-lens`.
//!
//! 512² photons, a refractor of about 70,000 triangles, exact refraction and hits, a map of 512² with splats
//! of each kind, read once a texel on a receiver of 512². The figures are the median of nine frames; the
//! scene and its trees are built once. The mesh is the bunny of the folder beside the crate, or a bumpy ball
//! of 82,000 triangles if there is none.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use support::approximation::{
    TIMED_SPLATS, bumpy_ball_over_floor, mesh_over_floor, rendered, shared_mesh, timed_map,
};
use support::cpu;
use support::measured::times;

const SIDE: usize = 512;
const FRAMES: usize = 9;

fn main() {
    let (name, scene) = match shared_mesh("bunny_69k") {
        Some(mesh) => ("bunny, 69,666 triangles", mesh_over_floor(mesh, SIDE)),
        None => ("bumpy ball, 81,920 triangles", bumpy_ball_over_floor(SIDE)),
    };
    println!("{name}, {} threads", rayon::current_num_threads());
    println!(
        "| splat | ms a frame | CPU ms | view | refraction | hit | splat | lookup | M rays | M fragments |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let is_asked = |splat: &str| {
        let mut named = asked.iter().filter(|one| !one.starts_with("--")).peekable();
        named.peek().is_none() || named.any(|one| one == splat)
    };
    for splat in TIMED_SPLATS.into_iter().filter(|splat| is_asked(splat)) {
        let map = timed_map(splat);
        let before = cpu::seconds();
        let frames = times(FRAMES);
        let mut made: Vec<_> = (0..frames).map(|_| rendered(&map, &scene)).collect();
        let cpu = (cpu::seconds() - before) / frames as f64;
        made.sort_by_key(|frame| frame.frame_time);
        let frame = &made[frames / 2];
        let stage = |name: &str| {
            let found = frame.stages.iter().find(|stage| stage.name == name);
            1e3 * found.map_or(0.0, |stage| stage.seconds)
        };
        let work = |name: &str| {
            let found = frame.counters.iter().find(|one| one.name == name);
            found.map_or(0, |one| one.count) as f64
        };
        println!(
            "| {splat} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.2} | {:.2} |",
            1e3 * frame.frame_time.unwrap_or_default().as_secs_f64(),
            1e3 * cpu,
            stage("view"),
            stage("refraction"),
            stage("hit"),
            stage("flux") + stage("splat"),
            stage("lookup"),
            work("rays") / 1e6,
            work("fragments") / 1e6,
        );
    }
}
