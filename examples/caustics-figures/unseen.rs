//! Ellipses on shipped scenes that nobody looked at while they were made.

use std::collections::BTreeMap;

use nephroid::internals::method::Method;
use nephroid::internals::metric::Figure;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::{Budget, Context, LayerName};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::signature::Signature;

use crate::beyond::{SPLATS, STAGES};
use crate::judge::{SIDE, likely_l1, rendered};
use crate::support::approximation::bundled;
use crate::support::caustics_volume::{EXACT, volume};
use crate::support::figures::{figures, save_picture, shown, table};
use crate::support::light_volume::sensor;

/// Scenes of a bumpy ball, a prism that turns, and a pool, with the light [W/m²] that is white.
const SCENES: [(&str, f64); 3] = [
    ("turntable-bumpy", 10.0),
    ("turntable-prism", 5.0),
    ("pool", 2000.0),
];

/// Most events of a path.
const DEPTH: &str = "6";

/// Photons of a truth.
const PHOTONS: u64 = 1 << 24;

/// All light by way of mirrors and glass on the floor, by photons; and the likely L1 of it.
fn truth(scene: &Scene) -> (Vec<Rgb>, f64) {
    let depth = BTreeMap::from([("max-depth".to_owned(), DEPTH.to_owned())]);
    let photons = Method::new("photons", &depth).unwrap();
    let budget = Budget::work(PHOTONS);
    let rendering = photons.run(scene, sensor(scene, "floor"), &budget, &Context::default());
    let estimate = rendering.expect("a meter").estimate;
    let direct = LayerName::Path(Signature::DIRECT);
    let mut values = vec![Rgb::BLACK; estimate.total.values.len()];
    let mut squares = values.clone();
    for layer in estimate.layers.iter().filter(|it| it.name != direct) {
        for (texel, (value, error)) in layer.values.iter().zip(&layer.standard_error).enumerate() {
            values[texel] += *value;
            squares[texel] += *error * *error;
        }
    }
    let errors: Vec<Rgb> = squares.iter().map(|it| Rgb(it.0.map(f64::sqrt))).collect();
    let own = likely_l1(&values, &errors);
    (values, own)
}

/// L1 by discs and by ellipses; the picture has the truth, and discs and ellipses of each preset with all else
/// exact.
pub fn unseen() -> Vec<String> {
    let (mut lines, mut pictures) = (Vec::new(), Vec::new());
    for (name, white) in SCENES {
        let scene = bundled(name, SIDE);
        let (truth, own) = truth(&scene);
        eprintln!("{name}: {own}");
        let mut images = vec![truth.clone()];
        for preset in ["lowest", "best"] {
            let mut cells = vec![
                format!("`{name}`"),
                format!("`{preset}`"),
                three_digits(100.0 * own),
            ];
            for (index, stages) in STAGES.into_iter().chain([&EXACT[..]]).enumerate() {
                for splat in SPLATS {
                    let own = [("preset", preset), ("splat", splat), ("max-depth", DEPTH)];
                    let found = rendered(&volume(&[stages, &own].concat()), &scene, "floor");
                    let found = found.estimate.total.values;
                    let judged = figures(&scene, sensor(&scene, "floor"), &truth, &found);
                    cells.push(shown(&judged, Figure::L1));
                    if index == STAGES.len() {
                        images.push(found);
                    }
                }
            }
            lines.push(cells);
        }
        let shown = images
            .iter()
            .map(|image| image.iter().map(|it| *it / white).collect());
        pictures.push(shown.collect());
    }
    save_picture("caustics-volume-ellipses.png", [SIDE, SIDE], 1.0, &pictures);
    vec![table(
        &[
            "scene",
            "preset",
            ">the truth's own likely L1",
            ">default: quads",
            ">ellipses",
            ">light right: quads",
            ">ellipses",
            ">and not smoothed: quads",
            ">ellipses",
            ">all else exact: quads",
            ">ellipses",
        ],
        &lines,
    )]
}
