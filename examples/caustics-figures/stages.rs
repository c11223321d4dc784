//! Which stage makes the error.

use std::time::Instant;

use nephroid::internals::run::{Budget, Context};
use nephroid::internals::study::attribution::{attribute, truth_by_beams};

use crate::judge::{Judge, OBJECTS, SIDE};
use crate::support::approximation::bundled;
use crate::support::caustics_volume::volume;
use crate::support::figures::attributions;
use crate::support::scenes::meter;

/// The scenes of `docs/caustic-map.md` with light that volumes model, and photons of each.
const OTHERS: [(&str, &str, &str); 8] = [
    ("glass-ball", "16", "10000"),
    ("lens", "16", "10000"),
    ("cube", "16", "10000"),
    ("diamond", "16", "10000"),
    ("prism", "16", "10000"),
    ("water", "16", "10000"),
    ("mirror-ring", "16", "10000"),
    ("coffee-cup", "16", "10000"),
];

/// Shapley's values of L1.
pub fn stages(judge: &mut Judge) -> Vec<String> {
    let context = Context::default();
    let mut all = Vec::new();
    for object in &OBJECTS {
        let photons = match object.name {
            "diamond" | "knot" => "2000",
            "blocks" => "5000",
            _ => "10000",
        };
        let case = judge.floor(object);
        let method = object.volume(&[("photons", photons)]);
        let start = Instant::now();
        let found = attribute(
            &method,
            &case.scene,
            case.sensor(),
            &context,
            &mut |_, _| (),
            |_| Ok(case.truth.clone()),
        );
        let found = found.expect("light on the floor").expect("nobody stops it");
        all.push((object.row(), found, start.elapsed().as_secs_f64()));
        eprintln!("{} {:.0} s", object.name, start.elapsed().as_secs_f64());
    }
    for (name, depth, photons) in OTHERS {
        let scene = bundled(name, SIDE);
        let sensor = meter(&scene);
        let method = volume(&[("max-depth", depth), ("photons", photons)]);
        let start = Instant::now();
        let found = attribute(&method, &scene, sensor, &context, &mut |_, _| (), |light| {
            truth_by_beams(&scene, sensor, light, &Budget::error(0.01), &context)
        });
        let found = found.expect("light on the floor").expect("nobody stops it");
        all.push((format!("`{name}`"), found, start.elapsed().as_secs_f64()));
        eprintln!("{name} {:.0} s", start.elapsed().as_secs_f64());
    }
    attributions(&all)
}
