//! Which stage makes the error, and all stages exact.

use std::time::Instant;

use nephroid::internals::method::Method;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::{Budget, Context, Light};
use nephroid::internals::setting::Given;
use nephroid::internals::study::attribution::{attribute, truth_by, truth_by_beams};

use crate::judge::{floor, l1, percent, sum, turntable};
use crate::support::figures::{attributions, table};
use crate::support::light_volume::sensor;
use crate::support::local_irradiance::{exact_but, tables};

/// Texels a row, and rows.
const FEW: &str = "64";

/// Scenes whose truth is beams. Of others it is photons.
const BY_BEAMS: [&str; 4] = ["ball", "cube", "prism", "ring"];

/// The light of all stages exact against beams.
pub fn exact() -> Vec<String> {
    let lines = BY_BEAMS.map(|name| {
        let scene = turntable(name, &[("size", FEW)]);
        let floor_sensor = sensor(&scene, "floor");
        let light = Light::Specular { max_depth: 16 };
        let budget = Budget::error(0.01);
        let truth = truth_by_beams(&scene, floor_sensor, light, &budget, &Context::default());
        let truth = truth.unwrap();
        let own = floor(&exact_but(&[("photons", "524288")]), &scene);
        vec![
            format!("`{name}`"),
            truth.relative_error.map_or("-".into(), percent),
            percent(l1(&truth.modelled, &own)),
            percent(sum(&own) / sum(&truth.modelled)),
        ]
    });
    vec![table(
        &["scene", ">likely error of beams, %", ">L1, %", ">energy, %"],
        &lines,
    )]
}

/// Shapley's values of L1 on the floors of the turntables.
pub fn stages() -> Vec<String> {
    let mut all = Vec::new();
    for name in ["ball", "cube", "prism", "ring", "terrain", "bumpy"] {
        let reference = if BY_BEAMS.contains(&name) {
            "beams"
        } else {
            "photons"
        };
        let reference = Method::new(reference, &Given::new()).expect("a reference");
        let scene = turntable(name, &[("size", FEW)]);
        let floor_sensor = sensor(&scene, "floor");
        let method = tables(&[("photons", "16384"), ("cells", "32")]);
        let (start, context) = (Instant::now(), Context::default());
        let budget = Budget::error(0.01);
        let truth = |light| truth_by(&reference, &scene, floor_sensor, light, &budget, &context);
        let found = attribute(
            &method,
            &scene,
            floor_sensor,
            &context,
            &mut |_, _| (),
            truth,
        );
        let found = found.expect("light on the floor").expect("nobody stops it");
        all.push((format!("`{name}`"), found, start.elapsed().as_secs_f64()));
        eprintln!("{}", attributions(&all[all.len() - 1..]).join("\n"));
        let found = &all[all.len() - 1].1;
        let (truth, twins) = (found.truth_error, found.twin_error);
        eprintln!("errors of the truth {truth:?}, and of twins {twins:?}");
    }
    attributions(&all)
}

/// Errors of means of two and of sixteen randomised sets that have as many photons together.
pub fn sets() -> Vec<String> {
    let scene = turntable("ball", &[("size", FEW)]);
    let image = |photons: u64, seed: u64| {
        let [photons, seed] = [photons, seed].map(|number| number.to_string());
        let given = [("photons", &photons[..]), ("seed", &seed[..])];
        floor(&exact_but(&given), &scene)
    };
    let truth = image(1 << 23, 1000);
    let lines = [1 << 16, 1 << 18, 1 << 20].map(|photons: u64| {
        let error = |sets: u64| {
            let mut mean = vec![Rgb::BLACK; truth.len()];
            for seed in 1..=sets {
                for (sum, value) in mean.iter_mut().zip(image(photons / sets, seed)) {
                    *sum += value * (1.0 / sets as f64);
                }
            }
            let pairs = truth.iter().zip(&mean);
            let squares: f64 = pairs.map(|(a, b)| (a.mean() - b.mean()).powi(2)).sum();
            (squares * truth.len() as f64).sqrt() / sum(&truth)
        };
        let errors = [1, 2, 16].map(error);
        let mut line = vec![format!("2^{}", photons.ilog2())];
        line.extend(errors.map(percent));
        line.push(three_digits(errors[2] / errors[1]));
        line
    });
    vec![table(
        &[
            ">photons",
            ">1 set: error, %",
            ">2 sets",
            ">16 sets",
            ">16 by 2",
        ],
        &lines,
    )]
}
