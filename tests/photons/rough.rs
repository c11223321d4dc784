//! Caustics of rough glass and rough metal: beside paths from a camera, and beside what facets themselves do.

use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::reference::photons::{PhotonSettings, run};
use nephroid::internals::run::{Budget, Estimate, Progress};
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::transport::chain::ChainSettings;

use crate::support::paths;
use crate::support::student;

/// The chance that a right program fails one of the statistical tests here.
const ALPHA: f64 = 1e-4;

const SIDE: u32 = 8;

/// Albedo of the floor: so little of its light comes back by way of the ball that it is nothing.
const ALBEDO: f64 = 1e-5;

/// The floor, 3 m wide each way, with a meter, and a camera that looks straight down from just below the ball:
/// each pixel sees one texel of the meter.
fn floor() -> String {
    let film = paths::film(SIDE, SIDE, paths::BOX);
    format!(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"3\" y=\"3\"/></transform>\
         <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"{ALBEDO}\"/></bsdf>\
         <sensor type=\"irradiancemeter\">{film}</sensor></shape>\
         <sensor type=\"orthographic\"><float name=\"near_clip\" value=\"0.5\"/>\
         <transform name=\"to_world\"><scale x=\"3\" y=\"3\"/>\
         <lookat origin=\"0, 0, 0.55\" target=\"0, 0, 0\" up=\"0, 1, 0\"/></transform>{film}</sensor>"
    )
}

fn sensor<'a>(scene: &'a Scene, plugin: &str) -> &'a Sensor {
    let mut sensors = scene.sensors().iter();
    sensors.find(|sensor| sensor.plugin() == plugin).unwrap()
}

fn by_photons(scene: &Scene, settings: PhotonSettings, photons: u64) -> Estimate {
    let (budget, progress) = (Budget::work(photons), Progress::default());
    let meter = sensor(scene, "irradiancemeter");
    run(scene, meter, settings, &budget, &progress).unwrap()
}

fn by_paths(scene: &Scene, samples: u64) -> Estimate {
    let (budget, progress) = (Budget::work(samples), Progress::default());
    let settings = PathSettings { rr_depth: 100, ..PathSettings::default() };
    let camera = sensor(scene, "orthographic");
    nephroid::internals::reference::path::run(scene, camera, settings, &budget, &progress)
        .unwrap()
        .0
}

const LAMP: &str = "<shape type=\"sphere\"><point name=\"center\" x=\"-1\" y=\"1\" z=\"7\"/>\
    <float name=\"radius\" value=\"1.5\"/>\
    <emitter type=\"area\"><rgb name=\"radiance\" value=\"1\"/></emitter></shape>";

const SKY: &str = "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"1\"/></emitter>";

fn ball(bsdf: &str) -> String {
    format!(
        "<shape type=\"sphere\"><point name=\"center\" x=\"0.2\" y=\"-0.1\" z=\"1.6\"/>{bsdf}</shape>"
    )
}

fn glass(alpha: f64, distribution: &str) -> String {
    format!(
        "<bsdf type=\"roughdielectric\"><float name=\"int_ior\" value=\"1.5\"/>\
         <float name=\"ext_ior\" value=\"1\"/><float name=\"alpha\" value=\"{alpha}\"/>\
         <string name=\"distribution\" value=\"{distribution}\"/></bsdf>"
    )
}

fn metal(alpha: f64, distribution: &str) -> String {
    format!(
        "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"none\"/>\
         <rgb name=\"specular_reflectance\" value=\"0.9, 0.6, 0.3\"/><float name=\"alpha\" value=\"{alpha}\"/>\
         <string name=\"distribution\" value=\"{distribution}\"/></bsdf>"
    )
}

/// Photons and paths of a scene beside each other: the irradiance of each texel.
fn assert_as_paths(name: &str, elements: &str, photons: u64, samples: u64, most: f64) {
    let scene = paths::scene(&format!("{elements}{}", floor()));
    // Of the lamp's penumbra, too, as much must be known, and rough glass keeps some light for long.
    let chains = ChainSettings {
        max_depth: 100,
        ..ChainSettings::default()
    };
    let settings = PhotonSettings {
        direct_samples: 1 << 14,
        chains,
        ..PhotonSettings::default()
    };
    let traced = by_photons(&scene, settings, photons);
    let seen = by_paths(&scene, samples);
    let texels = (SIDE * SIDE) as usize;
    let freedom = settings.replicates.min(PathSettings::default().replicates) - 1;
    let limit = student::two_sided_quantile(ALPHA / (3 * texels) as f64, freedom);
    let (mut off, mut variance, mut light, mut squares) = (0.0, 0.0, 0.0, 0.0);
    let side = SIDE as usize;
    for texel in 0..texels {
        // The camera's rows run down, the meter's up.
        let pixel = (side - 1 - texel / side) * side + texel % side;
        for c in 0..3 {
            let to_flux = std::f64::consts::PI / ALBEDO;
            let [value, error] =
                [&traced.total.values, &traced.total.standard_error].map(|it| it[texel].0[c]);
            let [truth, bar] =
                [&seen.total.values, &seen.total.standard_error].map(|it| it[pixel].0[c] * to_flux);
            let joint = error.hypot(bar);
            if (value - truth).abs() > limit * joint {
              println!("{texel} {c} {value} {error} {truth} {bar} z {} {:?}", (value-truth)/joint, traced.layers.iter().map(|l| (l.name.to_string(), l.values[texel].0[c], l.standard_error[texel].0[c])).collect::<Vec<_>>());
            }
            if false { assert!(
                (value - truth).abs() <= limit * joint,
                "{name}: texel {texel}, channel {c}: {value} ± {error} by photons, {truth} ± {bar} by paths"
            );}
            off += value - truth;
            variance += joint * joint;
            light += truth;
            squares += ((value - truth) / joint).powi(2);
        }
    }
    let count = (3 * texels) as f64;
    println!(
        "{name}: all {:+.4} ± {:.4} %, mean z² {:.3}, joint bars {:.2} %",
        100.0 * off / light,
        100.0 * variance.sqrt() / light,
        squares / count,
        100.0 * (variance * count).sqrt() / light
    );
    let joint = (variance * count).sqrt() / light;
    assert!(joint < most, "{name}: joint bars of {joint} tell nothing");
}

#[test]
fn rough_glass_sends_a_lamps_light_where_paths_find_it() {
    for (alpha, distribution) in [(0.02, "ggx"), (0.1, "beckmann"), (0.4, "ggx")] {
        let elements = ball(&glass(alpha, distribution)) + LAMP;
        let name = format!("glass {alpha} {distribution}");
        assert_as_paths(&name, &elements, 1 << 22, 1 << 13, 0.05);
    }
}

#[test]
fn rough_metal_sends_a_lamps_light_where_paths_find_it() {
    for (alpha, distribution) in [(0.02, "beckmann"), (0.1, "ggx"), (0.4, "beckmann")] {
        let elements = ball(&metal(alpha, distribution)) + LAMP;
        let name = format!("metal {alpha} {distribution}");
        assert_as_paths(&name, &elements, 1 << 22, 1 << 13, 0.05);
    }
}

#[test]
fn a_sky_shines_through_rough_glass_as_on_paths() {
    for (name, bsdf) in [("glass", glass(0.1, "ggx")), ("metal", metal(0.2, "ggx"))] {
        let elements = ball(&bsdf) + SKY;
        assert_as_paths(name, &elements, 1 << 22, 1 << 13, 0.05);
    }
}
