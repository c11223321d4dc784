//! The scene `pool`: its light all passes the water, and in flat water it is known.

use std::fs;

use glam::DVec2;
use nephroid::internals::generate::{SCENES, height_field, write_ply};
use nephroid::internals::mitsuba::load;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::reference::beams::run::Setup;
use nephroid::internals::reference::beams::{BeamSettings, run};
use nephroid::internals::run::{Budget, Estimate, Layer, Progress};
use nephroid::internals::scene::Scene;

use crate::support::beams::beams;
use crate::support::bundled_file;
use crate::support::scenes::loaded;

const SIDE: usize = 64;

const OCCLUDERS: [&str; 3] = ["none", "disc", "fence"];

/// Receivers of the scene.
const METERS: [&str; 2] = ["floor", "wall"];

fn pool(occluder: &str) -> Scene {
    let parameters = [("occluder", occluder), ("size", &SIDE.to_string())]
        .map(|(name, value)| (name.into(), value.into()));
    load(&bundled_file("pool"), &parameters).unwrap()
}

/// What beams say of a meter, to 10 %.
fn coarse(scene: &Scene, meter: &str) -> Estimate {
    let sensor = scene.sensors().iter().find(|it| it.id == meter).unwrap();
    let budget = Budget {
        relative_error: Some(0.1),
        ..Budget::default()
    };
    let settings = BeamSettings::default();
    run(scene, sensor, settings, &budget, &Progress::default())
        .unwrap()
        .0
}

/// Every shadow's edge lies off the films, so direct light is 0 without a bar.
#[test]
fn no_light_reaches_the_pool_but_through_the_water() {
    for occluder in OCCLUDERS {
        let scene = pool(occluder);
        for meter in METERS {
            let estimate = coarse(&scene, meter);
            let names: Vec<String> = estimate
                .layers
                .iter()
                .map(|it| it.name.to_string())
                .collect();
            assert_eq!(names, ["LD", "LTD"], "{meter}, {occluder}");
            let direct = &estimate.layers[0];
            let most = &direct.interval.as_ref().unwrap().high;
            let is_dark = direct.values.iter().chain(most).all(|it| it.is_black());
            assert!(is_dark, "{meter}, {occluder}");
        }
    }
}

/// Light that the water reflects crosses the wall's plane above the wall: a fifth of what falls on the wall. Bars
/// of all light must not take it for light on the film.
#[test]
fn light_beside_the_wall_does_not_widen_its_bars() {
    for occluder in OCCLUDERS {
        let estimate = coarse(&pool(occluder), "wall");
        let through = &estimate.layers[1];
        assert_eq!(through.name.to_string(), "LTD");
        let highest = |layer: &Layer| layer.interval.as_ref().unwrap().high.clone();
        let excess = highest(&estimate.total).into_iter().zip(highest(through));
        let excess = excess.map(|(all, one)| all.0[0] - one.0[0]);
        let excess = excess.fold(0.0, f64::max);
        let values = estimate.total.values.iter().map(|it| it.0[0]);
        let mean = values.sum::<f64>() / (SIDE * SIDE) as f64;
        println!("{occluder}: {excess} W/m² above LTD, mean {mean}");
        // Light left out is at most a quarter of the error asked for, a tenth. Bounds hold four times that: 0.1
        // of the mean. Twice that, as some thousand paths tell the flux within a few percent.
        assert!(excess <= 0.2 * mean, "{occluder}: {excess}, mean {mean}");
    }
}

/// The run ends, and says that the layer is dark. Without an end it would stop at the limit, and leave it out.
#[test]
fn an_error_asked_of_light_beside_the_film_is_reached() {
    let scene = pool("none");
    let sensor = scene.sensors().iter().find(|it| it.id == "wall").unwrap();
    // The run takes a million rays.
    let budget = Budget {
        relative_error: Some(0.1),
        work: Some(1 << 23),
        ..Budget::default()
    };
    let progress = Progress::default();
    let mut setup = Setup::new(&scene, sensor, BeamSettings::default(), &progress).unwrap();
    setup.ask(&[("LRD", 0.1)]).unwrap();
    let (estimate, report) = setup.run(&budget).unwrap();
    println!("{} rays", estimate.counters.rays);
    assert!(!estimate.incomplete);
    assert!(report.signatures.iter().any(|it| it.name == "LRD"));
    let mut layers = estimate.layers.iter();
    let reflected = layers.find(|it| it.name.to_string() == "LRD").unwrap();
    let most = &reflected.interval.as_ref().unwrap().high;
    assert!(most.iter().all(|it| it.is_black()));
}

/// Disc and fence shade about an eighth of the floor each. Fluxes are sums over thousands of texels that are each
/// within 10 %, with errors of both signs: far below the 10 % and more that are missing.
#[test]
fn each_occluder_takes_light_from_the_floor() {
    let flux = |occluder| {
        let estimate = coarse(&pool(occluder), "floor");
        let values = estimate.total.values.iter();
        values.map(|it| it.0[0]).sum::<f64>()
    };
    let whole = flux("none");
    for occluder in ["disc", "fence"] {
        let left = flux(occluder) / whole;
        println!("{occluder}: {left}");
        assert!((0.5..0.9).contains(&left), "{occluder}: {left}");
    }
}

/// The texels about the floor's middle are in no shadow: those of ball and box fall 0.3 m and more beside it.
#[test]
fn in_flat_water_the_middle_of_the_floor_has_the_irradiance_that_passes() {
    let folder = tempfile::tempdir().unwrap();
    let pool = SCENES.iter().find(|it| it.name == "pool").unwrap();
    for (name, bytes) in pool.contents(1) {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let mut flat = Vec::new();
    let mesh = height_field(DVec2::new(2.25, 1.75), 1.5, &[], 2);
    write_ply(&mesh, "flat water", &mut flat).unwrap();
    fs::write(folder.path().join("pool.ply"), flat).unwrap();
    let scene = loaded(&folder.path().join("pool.xml"), SIDE);
    let (estimate, _) = beams(&scene, 0.01);
    let cos = 30.0_f64.to_radians().cos();
    let truth = 1000.0 * cos * (1.0 - dielectric_reflectance(cos, 1.33));
    // The scene file has the sun's direction to 8 digits.
    let rounding = 1e-7 * truth;
    let bounds = estimate.total.interval.as_ref().unwrap();
    for row in SIDE / 2 - 1..=SIDE / 2 {
        for column in SIDE / 2 - 1..=SIDE / 2 {
            let texel = row * SIDE + column;
            let (low, high) = (bounds.low[texel].0[0], bounds.high[texel].0[0]);
            assert!(
                low - rounding <= truth && truth <= high + rounding,
                "{low} .. {high}, {truth}"
            );
            // What was asked for.
            let value = estimate.total.values[texel].0[0];
            assert!((value - truth).abs() <= 0.01 * truth, "{value}, {truth}");
        }
    }
}
