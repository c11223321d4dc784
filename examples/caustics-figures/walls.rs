//! Light on the walls, by the light that enters; and light that goes out by sides, or back.

use nephroid::internals::method::Method;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::{Budget, Context, LayerName, Rendering};
use nephroid::internals::transport::signature::Signature;

use crate::judge::{OBJECTS, mean, rendered, values};
use crate::support::caustics_volume::{EXACT, volume};
use crate::support::figures::table;
use crate::support::light_volume::sensor;

/// Texels a row of meters, and rows: only their sums are wanted.
const SIDE: usize = 32;

/// Photons of the truth.
const PHOTONS: u64 = 1 << 18;

/// Caustics by the truth's, wall by wall.
pub fn walls() -> Vec<String> {
    let mut lines = Vec::new();
    for object in &OBJECTS {
        let scene = object.scene(SIDE);
        for wall in ["floor", "left", "right", "back"] {
            let photons = Method::new("photons", &std::collections::BTreeMap::new()).unwrap();
            let budget = Budget::work(PHOTONS);
            let context = Context::default();
            let truth = photons.run(&scene, sensor(&scene, wall), &budget, &context);
            let estimate = truth.expect("a spot").estimate;
            let direct = LayerName::Path(Signature::DIRECT);
            let caustics = estimate.layers.iter().filter(|it| it.name != direct);
            let truth: f64 = caustics.map(|layer| mean(&layer.values)).sum();
            let mut cells = vec![object.row(), wall.to_owned(), three_digits(truth)];
            let light = ("emission", "exact");
            let ways = ("interface", "exact");
            let surfaces = ("layers", "exact");
            // A sweep in any order culls nothing, but projectors have pictures of exit faces only: hence
            // `cull=none`.
            for settings in [
                vec![],
                vec![light],
                vec![ways],
                vec![light, ways],
                vec![light, ways, surfaces],
                vec![light, ways, surfaces, ("sweep", "exact"), ("cull", "none")],
            ] {
                let few = [&settings[..], &[("photons", "20000")]].concat();
                let found = mean(&values(&volume(&few), &scene, wall));
                cells.push(three_digits(100.0 * found / truth));
            }
            lines.push(cells);
        }
    }
    vec![table(
        &[
            "scene",
            "wall",
            ">truth, W/m²",
            ">default, %",
            ">`emission`",
            ">`interface`",
            ">both",
            ">and `layers`",
            ">and `sweep`, `cull=none`",
        ],
        &lines,
    )]
}

/// Flux in percent of what enters, by a reason.
fn lost(rendering: &Rendering, reason: &str) -> f64 {
    let all = |reason: &str| -> f64 {
        let entries = rendering.flux.iter().filter(|it| it.reason == reason);
        entries.map(|it| it.flux.mean()).sum()
    };
    -100.0 * all(reason) / all("enters the volume")
}

/// Light by what becomes of it in the volume.
pub fn faces() -> Vec<String> {
    const SIDES: &str = "entry,x-,x+,y-,y+";
    let mut lines = Vec::new();
    for object in &OBJECTS {
        let scene = object.scene(SIDE);
        for (name, settings) in [
            ("default", vec![]),
            ("`interface=exact`", vec![("interface", "exact")]),
            (
                "all exact but `splat`",
                [&EXACT[..], &[("splat", "quads"), ("photons", "20000")]].concat(),
            ),
        ] {
            let of = |more: &[(&str, &str)]| {
                rendered(&volume(&[&settings[..], more].concat()), &scene, "floor")
            };
            let found = of(&[]);
            // A sweep in any order culls nothing.
            let by_sides = if name.starts_with("all") {
                "-".to_owned()
            } else {
                let culled = lost(&of(&[("cull", SIDES)]), "leaves by a face that culls");
                three_digits(culled - lost(&found, "leaves by a face that culls"))
            };
            let mut cells = vec![object.row(), name.to_owned()];
            for reason in [
                "meets nothing that mirrors or refracts",
                "ends in total reflection",
                "goes back towards the entry",
                "leaves by a face that culls",
            ] {
                cells.push(three_digits(lost(&found, reason).abs()));
            }
            cells.push(by_sides);
            let outside = ["meets no surface", "leaves the projectors' pictures"];
            let outside: f64 = outside.iter().map(|it| lost(&found, it)).sum();
            cells.push(three_digits(outside.abs()));
            lines.push(cells);
        }
    }
    vec![table(
        &[
            "scene",
            "stages",
            ">meets nothing",
            ">total reflection",
            ">goes back",
            ">leaves by the entry",
            ">leaves by sides",
            ">lands nowhere",
        ],
        &lines,
    )]
}
