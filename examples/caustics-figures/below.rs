//! The paper's Fig. 1: a ball of glass, and a box of glass put under it.

use nephroid::internals::metric::Figure;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::Scene;

use crate::judge::{SIDE, values};
use crate::support::caustic_scenes::ball_over;
use crate::support::caustics_volume::{exact_but, truth, volume};
use crate::support::figures::{figures, shown, table};
use crate::support::light_volume::sensor;

/// Likely error of the truths.
const TRUTH: f64 = 0.02;

/// How far an image changes, and how far it is from the truth, by slabs and layers.
pub fn below() -> Vec<String> {
    let scenes = [false, true].map(|has_box| ball_over(has_box, SIDE));
    let truths = scenes.each_ref().map(|scene| truth(scene, TRUTH));
    let found = |scene: &Scene, of: &[Rgb], image: &[Rgb]| {
        figures(scene, sensor(scene, "floor"), of, image)
    };
    let change = |images: &[Vec<Rgb>; 2]| {
        let found = found(&scenes[1], &images[0], &images[1]);
        [Figure::L1, Figure::Energy].map(|it| shown(&found, it))
    };
    let mut lines = Vec::new();
    let [l1, energy] = change(&truths);
    lines.push(vec![
        "the truth".to_owned(),
        l1,
        energy,
        "0".into(),
        "0".into(),
        "100".into(),
    ]);
    let mut variants: Vec<(String, Vec<(&str, &str)>)> = Vec::new();
    for slabs in ["1", "2", "3", "4", "5", "8"] {
        variants.push((format!("`slabs={slabs}`"), vec![("slabs", slabs)]));
    }
    for peels in ["2", "3", "4", "6"] {
        variants.push((
            format!("1 slab, `layers=peel`, `peels={peels}`"),
            vec![("slabs", "1"), ("layers", "peel"), ("peels", peels)],
        ));
    }
    variants.push((
        "1 slab, `layers=exact`".to_owned(),
        vec![("slabs", "1"), ("layers", "exact")],
    ));
    let right = [("interface", "exact"), ("slabs", "1")];
    for (name, layers) in [
        ("1 slab, `peels=4`, `interface=exact`", "peel"),
        ("1 slab, `layers=exact`, `interface=exact`", "exact"),
    ] {
        let settings = [&right[..], &[("layers", layers)]].concat();
        variants.push((name.to_owned(), settings));
    }
    let mut methods: Vec<_> = variants
        .into_iter()
        .map(|(name, settings)| (name, volume(&settings)))
        .collect();
    methods.push(("all exact".to_owned(), exact_but(&[("photons", "10000")])));
    for (name, method) in methods {
        let images = scenes
            .each_ref()
            .map(|scene| values(&method, scene, "floor"));
        let [l1, energy] = change(&images);
        let alone = found(&scenes[0], &truths[0], &images[0]);
        let both = found(&scenes[1], &truths[1], &images[1]);
        lines.push(vec![
            name,
            l1,
            energy,
            shown(&alone, Figure::L1),
            shown(&both, Figure::L1),
            shown(&both, Figure::Energy),
        ]);
    }
    vec![table(
        &[
            "",
            ">change by the box, L1, %",
            ">energy, %",
            ">ball: L1, %",
            ">ball and box: L1, %",
            ">energy, %",
        ],
        &lines,
    )]
}
