//! Which stage makes the error.

use std::time::Instant;

use nephroid::internals::run::{Budget, Context};
use nephroid::internals::study::attribution::{
    Attribution, AttributionError, ReducedSensor, Truth, attribute, truth_by_beams,
};

use crate::judge::{Judge, OBJECTS};
use crate::support::approximation::bundled;
use crate::support::caustics_volume::volume;
use crate::support::figures::attributions;
use crate::support::scenes::meter;

/// The scenes of `docs/caustic-map.md` with light that volumes model.
const SHIPPED: [&str; 8] = [
    "glass-ball",
    "mirror-ring",
    "coffee-cup",
    "lens",
    "water",
    "cube",
    "prism",
    "diamond",
];

/// Texels a row, and rows, and photons: an attribution takes 149 runs.
const FEW: usize = 64;
const PHOTONS: &str = "2000";

/// Most events of a path in these.
const DEPTH: &str = "6";

/// An attribution with its row's name and its seconds.
type Row = (String, Attribution, f64);

fn row(
    name: String,
    attributing: impl FnOnce(&Context) -> Result<Option<Attribution>, AttributionError>,
) -> Row {
    let start = Instant::now();
    let found = attributing(&Context::default());
    let found = found.expect("light on the floor").expect("nobody stops it");
    let seconds = start.elapsed().as_secs_f64();
    let row = (name, found, seconds);
    // A section takes minutes: what is known is shown at once.
    eprintln!("{}", attributions(std::slice::from_ref(&row)).join("\n"));
    row
}

/// Shapley's values of L1 on the floors under five objects.
pub fn objects(judge: &mut Judge) -> Vec<String> {
    let mut all = Vec::new();
    for letter in ["C", "B", "E", "D", "A"] {
        let object = OBJECTS.iter().find(|it| it.letter == letter).unwrap();
        let case = judge.floor(object);
        let few = ReducedSensor::new(&case.scene, case.sensor(), FEW);
        let truth = Truth {
            modelled: few.means(&case.truth.modelled),
            ..case.truth.clone()
        };
        let method = object.volume(&[("photons", PHOTONS)]);
        all.push(row(object.row(), |context| {
            let truth = |_| Ok(truth);
            attribute(
                &method,
                &case.scene,
                &few.sensor,
                context,
                &mut |_, _| (),
                truth,
            )
        }));
    }
    all.sort_by(|a, b| a.0.cmp(&b.0));
    attributions(&all)
}

/// Shapley's values of L1 of the scenes of `docs/caustic-map.md`.
pub fn shipped(_: &mut Judge) -> Vec<String> {
    let all = SHIPPED.iter().map(|name| {
        let scene = bundled(name, FEW);
        let sensor = meter(&scene);
        let method = volume(&[("max-depth", DEPTH), ("photons", PHOTONS)]);
        row(format!("`{name}`"), |context| {
            let truth =
                |light| truth_by_beams(&scene, sensor, light, &Budget::error(0.02), context);
            attribute(&method, &scene, sensor, context, &mut |_, _| (), truth)
        })
    });
    attributions(&all.collect::<Vec<_>>())
}
