//! The cost of a frame, by splat: CPU time and counters.

use nephroid::internals::run::format::three_digits;

use crate::support::approximation::{
    TIMED_SPLATS, bumpy_ball_over_floor, mesh_over_floor, rendered, shared_mesh, timed_map,
};
use crate::support::cpu;
use crate::support::figures::table;

/// Texels of the meter.
const SIDE: usize = 512;

/// CPU seconds that each splat is measured for.
const LONG: f64 = 3.0;

/// Stages with time of their own.
const STAGES: [&str; 5] = ["view", "refraction", "hit", "splat", "lookup"];

/// Frames through the bunny of the folder beside the crate, or through a bumpy ball.
pub fn cost() -> Vec<String> {
    let (name, scene) = match shared_mesh("bunny_69k") {
        Some(mesh) => ("the bunny, 69,666 triangles", mesh_over_floor(mesh, SIDE)),
        None => (
            "a bumpy ball, 81,920 triangles",
            bumpy_ball_over_floor(SIDE),
        ),
    };
    let lines: Vec<Vec<String>> = TIMED_SPLATS
        .iter()
        .map(|splat| {
            let map = timed_map(splat);
            let all = cpu::milliseconds(LONG, || drop(rendered(&map, &scene)));
            let frame = rendered(&map, &scene);
            let work = |name: &str| {
                let found = frame.counters.iter().find(|one| one.name == name);
                found.map_or(0, |one| one.count) as f64
            };
            let seconds = |name: &str| {
                let stages = frame.stages.iter().filter(|stage| {
                    // Normalisation is as good as free, and booked beside splats.
                    stage.name == name || name == "splat" && stage.name == "flux"
                });
                stages.map(|stage| stage.seconds).sum::<f64>()
            };
            let whole: f64 = frame.stages.iter().map(|stage| stage.seconds).sum();
            let mut cells = vec![format!("`{splat}`"), format!("{all:.0}")];
            cells.extend(STAGES.map(|name| format!("{:.0}", 100.0 * seconds(name) / whole)));
            cells.extend(["rays", "fragments"].map(|name| three_digits(work(name) / 1e6)));
            cells
        })
        .collect();
    let mut head = vec!["splat", ">CPU ms a frame"];
    let stages = STAGES.map(|name| format!(">`{name}`, %"));
    head.extend(stages.iter().map(String::as_str));
    head.extend([">M rays", ">M fragments"]);
    vec![format!("Frames through {name}:"), table(&head, &lines)]
}
