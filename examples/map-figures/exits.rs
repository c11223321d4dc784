//! Total reflection at an approximate exit, and normalisations of flux: which energies they leave.

use nephroid::internals::metric::Figure;
use nephroid::internals::metric::fidelity::Fidelity;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::{Budget, Context, Light};
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::study::attribution::truth_by_beams;

use crate::stages::{SCENES, TRUTH, WITH_TWO_INTERFACES, reduced};
use crate::support::approximation::{caustic_map, relative_rmse};
use crate::support::figures::{figures, shown, table};

/// A receiver with the truth of the light that a map models.
struct Case {
    scene: Scene,
    sensor: Sensor,
    truth: Vec<Rgb>,
}

impl Case {
    fn new(name: &str) -> Self {
        let (scene, sensor) = reduced(name);
        let light = Light::Path("LTTD".parse().expect("a signature"));
        let context = Context::default();
        let truth = truth_by_beams(&scene, &sensor, light, &Budget::error(TRUTH), &context);
        let truth = truth.expect("lights without size").modelled;
        Self {
            scene,
            sensor,
            truth,
        }
    }

    fn values(&self, settings: &[(&str, &str)]) -> Vec<Rgb> {
        let (budget, context) = (Budget::default(), Context::default());
        let map = caustic_map(settings);
        let found = map.run(&self.scene, &self.sensor, &budget, &context);
        found.expect("a map").estimate.total.values
    }

    fn figures(&self, settings: &[(&str, &str)]) -> Fidelity {
        let values = self.values(settings);
        figures(&self.scene, &self.sensor, &self.truth, &values)
    }
}

/// Both exits on all scenes: by all other defaults, and with Fresnel's equations, which take light from each.
pub fn exits() -> Vec<String> {
    let columns = [
        Figure::Energy,
        Figure::L1,
        Figure::Misplaced,
        Figure::Displaced,
        Figure::L2,
    ];
    let mut lines = Vec::new();
    for name in &SCENES[..WITH_TWO_INTERFACES] {
        let case = Case::new(name);
        for fresnel in ["none", "exact"] {
            for exit in ["clamp", "drop"] {
                let found = case.figures(&[("total-reflection", exit), ("fresnel", fresnel)]);
                let mut cells = vec![
                    format!("`{name}`"),
                    format!("`{fresnel}`"),
                    format!("`{exit}`"),
                ];
                cells.extend(columns.map(|figure| shown(&found, figure)));
                lines.push(cells);
            }
        }
    }
    vec![table(
        &[
            "scene",
            "`fresnel`",
            "`total-reflection`",
            ">energy",
            ">L1",
            ">misplaced",
            ">displaced [texels]",
            ">L2",
        ],
        &lines,
    )]
}

/// All normalisations and exits on `glass-ball`, beside an image without light.
pub fn normalisations() -> Vec<String> {
    let case = Case::new("glass-ball");
    let error = |values: &[Rgb]| {
        let found = relative_rmse(values, &case.truth);
        found.map_or("-".to_owned(), |it| three_digits(100.0 * it))
    };
    let mut lines = Vec::new();
    for flux in ["density-ratio", "uniform", "exact"] {
        for exit in ["clamp", "drop"] {
            let values = case.values(&[("flux", flux), ("total-reflection", exit)]);
            let found = figures(&case.scene, &case.sensor, &case.truth, &values);
            lines.push(vec![
                format!("`{flux}`"),
                format!("`{exit}`"),
                error(&values),
                shown(&found, Figure::L1),
                shown(&found, Figure::Energy),
            ]);
        }
    }
    let black = vec![Rgb::BLACK; case.truth.len()];
    lines.push(vec![
        "a black image".to_owned(),
        "-".to_owned(),
        error(&black),
        "100".to_owned(),
        "0".to_owned(),
    ]);
    vec![table(
        &[
            "`flux`",
            "`total-reflection`",
            ">relative RMSE, %",
            ">L1, %",
            ">energy, %",
        ],
        &lines,
    )]
}
