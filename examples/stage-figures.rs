//! The tables of `docs/caustic-map.md` on figures and their stages:
//!
//! ```text
//! cargo run --release --example stage-figures [SCENE ...]
//! ```
//!
//! Each scene takes 128 runs, which take half a minute to two on two cores.

use std::collections::BTreeMap;

use nephroid::internals::method::Method;
use nephroid::internals::metric::Figure;
use nephroid::internals::mitsuba;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::{Budget, Context};
use nephroid::internals::study::attribution::{
    Attribution, AttributionError, ReducedSensor, SIDE, attribute, truth_by_beams,
};

/// The shipped scenes with light that caustic maps model.
const SCENES: [&str; 11] = [
    "glass-ball",
    "glass-ball-mesh",
    "glass-ball-behind-pane",
    "lens",
    "cube",
    "diamond",
    "prism",
    "water",
    "mirror-ring",
    "coffee-cup",
    "parabolic-mirror",
];

/// Likely error of the truth.
const TRUTH: f64 = 0.003;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let named: Vec<String> = std::env::args().skip(1).collect();
    let scenes: Vec<&str> = if named.is_empty() {
        SCENES.to_vec()
    } else {
        named.iter().map(String::as_str).collect()
    };
    let (mut figures, mut shares) = (String::new(), String::new());
    for scene in scenes {
        eprintln!("{scene}");
        let found = attributed(scene)?;
        let names: Vec<&str> = found
            .stages
            .iter()
            .map(|stage| stage.name.as_str())
            .collect();
        if figures.is_empty() {
            figures = "| scene | light | energy | L1 | misplaced | displaced [texels] | L2 | not modelled |\n\
                       |---|---|--:|--:|--:|--:|--:|--:|\n"
                .to_owned();
            shares = format!(
                "| scene | L1 | {} | all exact |\n|---|--:|{}--:|\n",
                names.join(" | "),
                "--:|".repeat(names.len())
            );
        }
        figures += &figure_line(scene, &found);
        shares += &share_line(scene, &found);
    }
    println!("{figures}\n{shares}");
    Ok(())
}

fn attributed(name: &str) -> Result<Attribution, AttributionError> {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.xml"));
    let scene = match mitsuba::load(&file, &[]) {
        Ok(scene) => scene,
        Err(error) => panic!("{error}"),
    };
    let map = Method::new("caustic-map", &BTreeMap::new())?;
    let meter = scene.sensors().iter().find(|one| !one.is_camera());
    let sensor = ReducedSensor::new(&scene, meter.expect("a receiver"), SIDE).sensor;
    let context = Context::default();
    let budget = Budget::error(TRUTH);
    let found = attribute(&map, &scene, &sensor, &context, &mut |_, _| (), |light| {
        truth_by_beams(&scene, &sensor, light, &budget, &context)
    })?;
    Ok(found.expect("nobody stops it"))
}

fn figure_line(scene: &str, found: &Attribution) -> String {
    let whole = |figure: Figure, factor: f64, offset: f64| {
        let value = found.of(figure).map(|shares| shares.whole + offset);
        value.map_or("-".to_owned(), |value| three_digits(factor * value))
    };
    format!(
        "| `{scene}` | `{}` | {} | {} | {} | {} | {} | {} |\n",
        found.light,
        whole(Figure::Energy, 100.0, 1.0),
        whole(Figure::L1, 100.0, 0.0),
        whole(Figure::Misplaced, 100.0, 0.0),
        whole(Figure::Displaced, 1.0, 0.0),
        whole(Figure::L2, 100.0, 0.0),
        three_digits(100.0 * found.not_modelled),
    )
}

fn share_line(scene: &str, found: &Attribution) -> String {
    let Some(l1) = found.of(Figure::L1) else {
        return String::new();
    };
    let values = l1.stages.iter().map(|stage| {
        let percent = 100.0 * stage.share.value;
        let sign = if percent > 0.0 { "+" } else { "" };
        format!("{sign}{}", three_digits(percent))
    });
    format!(
        "| `{scene}` | {} | {} | {} |\n",
        three_digits(100.0 * l1.whole),
        values.collect::<Vec<_>>().join(" | "),
        three_digits(100.0 * l1.residual),
    )
}
