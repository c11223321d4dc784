//! Tables of errors on the floor.

use nephroid::internals::metric::Figure;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::{Budget, Context, Light};
use nephroid::internals::study::attribution::truth_by_beams;

use crate::judge::{Judge, OBJECTS, SIDE, mean, values};
use crate::support::approximation::bundled;
use crate::support::caustics_volume::{EXACT, exact_but, rendered};
use crate::support::figures::{figures, shown, table};
use crate::support::scenes::meter;

/// The scenes of `docs/caustic-map.md`.
const SHIPPED: [&str; 8] = [
    "glass-ball",
    "mirror-ring",
    "coffee-cup",
    "lens",
    "cube",
    "prism",
    "water",
    "diamond",
];

/// The truths, and their own errors.
pub fn truths(judge: &mut Judge) -> Vec<String> {
    let lines = OBJECTS.iter().map(|object| {
        let case = judge.floor(object);
        let error = case.truth.relative_error.map_or(f64::NAN, |it| 100.0 * it);
        let exact = object.volume(&[&EXACT[..], &[("photons", "5000")]].concat());
        let found = case.judged(&exact);
        vec![
            object.row(),
            object.depth.to_owned(),
            three_digits(mean(&case.truth.modelled)),
            three_digits(mean(&case.direct)),
            three_digits(error),
            shown(&found, Figure::Energy),
            shown(&found, Figure::L1),
        ]
    });
    let lines: Vec<_> = lines.collect();
    vec![table(
        &[
            "scene",
            ">events",
            ">caustic, W/m²",
            ">direct, W/m²",
            ">likely error, %",
            ">all exact: energy, %",
            ">L1, %",
        ],
        &lines,
    )]
}

/// What is left of the error with all stages exact and as many photons as the best preset has. Diamond and knot
/// are left out: their facets need more.
pub fn residuals(judge: &mut Judge) -> Vec<String> {
    const PHOTONS: (&str, &str) = ("photons", "50000");
    const DEPTH: u32 = 6;
    let mut lines = Vec::new();
    for object in OBJECTS.iter().filter(|it| !["A", "D"].contains(&it.letter)) {
        let case = judge.floor(object);
        let found = case.judged(&object.volume(&[&EXACT[..], &[PHOTONS]].concat()));
        let error = case.truth.relative_error.map_or(f64::NAN, |it| 100.0 * it);
        eprintln!("{}: {}", object.row(), shown(&found, Figure::L1));
        lines.push(vec![
            object.row(),
            three_digits(error),
            shown(&found, Figure::L1),
        ]);
    }
    for name in SHIPPED {
        let scene = bundled(name, SIDE);
        let light = Light::Specular { max_depth: DEPTH };
        let context = Context::default();
        let budget = Budget::error(1e-2);
        let truth = truth_by_beams(&scene, meter(&scene), light, &budget, &context).unwrap();
        let depth = DEPTH.to_string();
        let method = exact_but(&[PHOTONS, ("max-depth", &depth)]);
        let found = rendered(&method, &scene).estimate.total.values;
        let found = figures(&scene, meter(&scene), &truth.modelled, &found);
        eprintln!("{name}: {}", shown(&found, Figure::L1));
        let error = truth.relative_error.map_or(f64::NAN, |it| 100.0 * it);
        lines.push(vec![
            format!("`{name}`"),
            three_digits(error),
            shown(&found, Figure::L1),
        ]);
    }
    vec![table(
        &["scene", ">the truth's likely error, %", ">L1, %"],
        &lines,
    )]
}

/// Errors by preset and slabs.
pub fn quality(judge: &mut Judge) -> Vec<String> {
    let mut lines = Vec::new();
    for object in &OBJECTS {
        let case = judge.floor(object);
        for preset in ["lowest", "middle", "best"] {
            let mut cells = vec![object.row(), format!("`{preset}`")];
            let mut errors = Vec::new();
            let mut last = None;
            for slabs in ["1", "2", "3"] {
                let method = object.volume(&[("preset", preset), ("slabs", slabs)]);
                let seen = case.seen(&values(&method, &case.scene, "floor"));
                errors.push(seen.fidelity.l1.map_or(f64::NAN, |it| it.value));
                cells.push(shown(&seen.fidelity, Figure::L1));
                last = Some(seen);
            }
            let seen = last.expect("three runs");
            cells.push(three_digits(errors[2] / errors[0]));
            cells.extend([Figure::Energy, Figure::Displaced].map(|it| shown(&seen.fidelity, it)));
            cells.push(
                seen.similarity
                    .map_or(String::new(), |it| three_digits(it.ssim)),
            );
            cells.push(seen.flip.map_or(String::new(), |it| three_digits(it.mean)));
            lines.push(cells);
        }
    }
    vec![table(
        &[
            "scene",
            "preset",
            ">L1, 1 slab",
            ">2",
            ">3",
            ">3 by 1",
            ">energy",
            ">displaced [texels]",
            ">SSIM",
            ">FLIP",
        ],
        &lines,
    )]
}

/// L1 by preset with the light and the interfaces right.
pub fn cures(judge: &mut Judge) -> Vec<String> {
    let right = [("emission", "exact"), ("interface", "exact")];
    let mut lines = Vec::new();
    for object in &OBJECTS {
        let case = judge.floor(object);
        let mut cells = vec![object.row()];
        for preset in ["lowest", "middle", "best"] {
            let method = object.volume(&[&right[..], &[("preset", preset)]].concat());
            cells.push(shown(&case.judged(&method), Figure::L1));
        }
        for slabs in ["1", "2"] {
            let method = object.volume(&[&right[..], &[("slabs", slabs)]].concat());
            cells.push(shown(&case.judged(&method), Figure::L1));
        }
        let many = [("g-buffer", "1000"), ("photons", "200000")];
        let method = object.volume(&[&right[..], &many[..]].concat());
        let found = case.judged(&method);
        cells.extend([Figure::L1, Figure::Energy].map(|it| shown(&found, it)));
        lines.push(cells);
    }
    vec![table(
        &[
            "scene",
            ">`lowest`",
            ">`middle`",
            ">`best`",
            ">`best`, 1 slab",
            ">2 slabs",
            ">1000², 200,000",
            ">its energy",
        ],
        &lines,
    )]
}

/// How many slabs buy what pictures lack.
pub fn slabs(judge: &mut Judge) -> Vec<String> {
    let mut lines = Vec::new();
    for object in &OBJECTS {
        let case = judge.floor(object);
        for (name, settings) in [
            ("by default", vec![]),
            ("`layers=exact` alone", vec![("layers", "exact")]),
            (
                "all exact but `layers`",
                [&EXACT[..], &[("layers", "near-far"), ("photons", "5000")]].concat(),
            ),
        ] {
            let mut cells = vec![object.row(), name.to_owned()];
            for slabs in ["1", "2", "3", "4", "5"] {
                let method = object.volume(&[&settings[..], &[("slabs", slabs)]].concat());
                let found = case.judged(&method);
                cells.push(format!(
                    "{} ({})",
                    shown(&found, Figure::L1),
                    shown(&found, Figure::Energy)
                ));
            }
            lines.push(cells);
        }
    }
    vec![table(
        &[
            "L1 (energy), %",
            "stages",
            ">1 slab",
            ">2",
            ">3",
            ">4",
            ">5",
        ],
        &lines,
    )]
}
