//! The error of the defaults, and which stage makes it: 128 runs a scene.

use nephroid::internals::metric::Figure;
use nephroid::internals::mitsuba;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::{Budget, Context};
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::study::attribution::{
    Attribution, AttributionError, ReducedSensor, SIDE, attribute, truth_by_beams,
};

use crate::support::approximation::caustic_map;
use crate::support::figures::{table, table_of_shares};
use crate::support::scenes::bundled_file;

/// The shipped scenes with light that caustic maps model. Light crosses two interfaces in the first ones.
pub const SCENES: [&str; 11] = [
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

/// Number of the first scenes, in which light crosses two interfaces.
pub const WITH_TWO_INTERFACES: usize = 7;

/// Likely error of the truth.
pub const TRUTH: f64 = 0.003;

/// Figures of all defaults, and the shares of stages in L1.
pub fn stages() -> Vec<String> {
    let (mut figures, mut shares) = (Vec::new(), Vec::new());
    let mut names = Vec::new();
    for scene in SCENES {
        eprintln!("{scene}");
        let found = attributed(scene).expect("a scene with light that maps model");
        names = found.stages.iter().map(|it| it.name.clone()).collect();
        figures.push(figure_line(scene, &found));
        shares.extend(share_line(scene, &found));
    }
    vec![
        table(
            &[
                "scene",
                "light",
                ">energy",
                ">L1",
                ">misplaced",
                ">displaced [texels]",
                ">L2",
                ">not modelled",
            ],
            &figures,
        ),
        table_of_shares(&names, &shares),
    ]
}

/// A shipped scene, its receiver with texels as large as attributions have.
pub fn reduced(name: &str) -> (Scene, Sensor) {
    let scene = match mitsuba::load(&bundled_file(name), &[]) {
        Ok(scene) => scene,
        Err(error) => panic!("{error}"),
    };
    let meter = scene.sensors().iter().find(|one| !one.is_camera());
    let sensor = ReducedSensor::new(&scene, meter.expect("a receiver"), SIDE).sensor;
    (scene, sensor)
}

fn attributed(name: &str) -> Result<Attribution, AttributionError> {
    let (scene, sensor) = reduced(name);
    let map = caustic_map(&[]);
    let context = Context::default();
    let budget = Budget::error(TRUTH);
    let found = attribute(&map, &scene, &sensor, &context, &mut |_, _| (), |light| {
        truth_by_beams(&scene, &sensor, light, &budget, &context)
    })?;
    Ok(found.expect("nobody stops it"))
}

fn figure_line(scene: &str, found: &Attribution) -> Vec<String> {
    let whole = |figure: Figure, factor: f64, offset: f64| {
        let value = found.of(figure).map(|shares| shares.whole + offset);
        value.map_or("-".to_owned(), |value| three_digits(factor * value))
    };
    vec![
        format!("`{scene}`"),
        format!("`{}`", found.light),
        whole(Figure::Energy, 100.0, 1.0),
        whole(Figure::L1, 100.0, 0.0),
        whole(Figure::Misplaced, 100.0, 0.0),
        whole(Figure::Displaced, 1.0, 0.0),
        whole(Figure::L2, 100.0, 0.0),
        three_digits(100.0 * found.not_modelled),
    ]
}

fn share_line(scene: &str, found: &Attribution) -> Option<Vec<String>> {
    let l1 = found.of(Figure::L1)?;
    let values = l1.stages.iter().map(|stage| {
        let percent = 100.0 * stage.share.value;
        let sign = if percent > 0.0 { "+" } else { "" };
        format!("{sign}{}", three_digits(percent))
    });
    let mut cells = vec![format!("`{scene}`"), three_digits(100.0 * l1.whole)];
    cells.extend(values);
    cells.push(three_digits(100.0 * l1.residual));
    Some(cells)
}
