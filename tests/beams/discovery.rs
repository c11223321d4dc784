//! Small, thin and far things: the discovery finds their light, and nothing of it is lost.

use std::path::Path;

use nephroid::internals::generate::{geodesic_sphere, write_ply};
use nephroid::internals::reference::beams::BeamSettings;
use nephroid::internals::reference::beams::run::Setup as BeamSetup;
use nephroid::internals::reference::closed_form;
use nephroid::internals::reference::closed_form::{FlatSlab, TexelGrid};
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup as PhotonSetup;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, LayerName, Progress};
use nephroid::internals::scene::Scene;

use crate::support::beams::{
    PANE, RECTANGLES, assert_photons_are_within_bounds, beams_to, known_by,
};
use crate::support::scenes::{meter, over_floor};
use crate::support::{Photons, bundled};

/// Texels a side of the receiver, which is the square of half width 1 in the plane z = 0.
const SIDE: usize = 32;

/// The probability that a right program fails a test of photons against beams.
const ALPHA: (f64, usize) = (1e-6, 1 << 16);

/// A scene of these things and the receiver, in a folder where meshes may be.
fn scene(folder: &Path, things: &str) -> Scene {
    over_floor(folder, things, SIDE)
}

const SUN: &str = r#"<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/>
    <rgb name="irradiance" value="100,100,100"/></emitter>"#;

/// At normal incidence n = 1.5 reflects 4 % at each of two surfaces.
const THROUGH: f64 = 0.96 * 0.96;

/// Bounds of the light that goes straight through.
fn through(estimate: &Estimate) -> [Vec<f64>; 2] {
    known_by(estimate)
        .into_iter()
        .find(|one| one.signature.to_string() == "LTTD")
        .map(|one| [one.low, one.high])
        .unwrap()
}

/// A ball of glass of radius 0.4 with 80,000 faces, and one of radius 0.01 beside it, whose light falls where
/// the large one's does not: 1/1600 of the light, that photons find without being told.
#[test]
fn a_bead_beside_a_mesh_of_80_000_faces_is_not_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = Vec::new();
    write_ply(&geodesic_sphere(0.4, 63), "ball", &mut bytes).unwrap();
    std::fs::write(folder.path().join("ball.ply"), bytes).unwrap();
    let [x, y, radius] = [0.7, 0.68, 0.01];
    let things = format!(
        r#"{SUN}
  <shape type="ply"><string name="filename" value="ball.ply"/>
    <transform name="to_world"><translate x="-0.4" y="-0.4" z="0.6"/></transform><ref id="glass"/></shape>
  <shape type="sphere"><point name="center" x="{x}" y="{y}" z="0.02"/><float name="radius" value="{radius}"/>
    <ref id="glass"/></shape>"#
    );
    let scene = scene(folder.path(), &things);
    let (estimate, _) = beams_to(2, &scene, 0.01);
    let [low, high] = through(&estimate);
    // Of parallel light a ball of index n lets ∫ (1 − F)² 2 sin i cos i di through: by the midpoint rule,
    // whose error falls as the square of its step: 1e-8 of what is smooth, 1e-6 at grazing incidence.
    let steps = 1 << 14;
    let passed: f64 = (0..steps)
        .map(|step| {
            let i = std::f64::consts::FRAC_PI_2 * (f64::from(step) + 0.5) / f64::from(steps);
            let kept = 1.0 - nephroid::internals::optics::dielectric_reflectance(i.cos(), 1.5);
            kept * kept * (2.0 * i).sin() * std::f64::consts::FRAC_PI_2 / f64::from(steps)
        })
        .sum();
    let truth = 100.0 * std::f64::consts::PI * radius * radius * passed;
    // It leaves the ball turned by 2 (i − t), at most 96 degrees, and most of it lands within some
    // centimetres: those more than 60 degrees off the axis, beyond three texels, are below a thousandth.
    let texel = 2.0 / SIDE as f64;
    let near = |texel_index: &usize| {
        let (column, row) = (texel_index % SIDE, texel_index / SIDE);
        let at = |index: usize| -1.0 + texel * (index as f64 + 0.5);
        (at(column) - x).abs().max((at(row) - y).abs()) <= 4.0 * texel
    };
    let sum = |values: &[f64]| {
        (0..SIDE * SIDE)
            .filter(near)
            .map(|one| values[one])
            .sum::<f64>()
            * texel
            * texel
    };
    println!("{truth} in {} .. {}", sum(&low), sum(&high));
    assert!(sum(&low) <= truth && truth * 0.999 <= sum(&high));
    // Bounds are not so wide that they would hold for no bead, too.
    assert!(sum(&low) > 0.5 * truth);
}

#[test]
fn a_lamp_100_km_away_is_as_good_as_the_sun() {
    let height = 1e5;
    // The receiver is seen at 1e-5: irradiance falls by that squared to its corners.
    let intensity = 100.0 * height * height;
    let lamp = format!(
        r#"<emitter type="point"><point name="position" x="0" y="0" z="{height}"/>
    <rgb name="intensity" value="{intensity}, {intensity}, {intensity}"/></emitter>"#
    );
    let pane = FlatSlab {
        thickness: 0.1,
        ior: 1.5,
    };
    let truth = pane
        .sheet(height, intensity, closed_form::KnownPath::Through(0))
        .map(&TexelGrid::square(1.0, SIDE));
    let folder = tempfile::tempdir().unwrap();
    for things in [PANE, RECTANGLES] {
        for error in [0.1, 1e-3] {
            let scene = scene(folder.path(), &format!("{lamp}{things}"));
            let [low, high] = through(&beams_to(2, &scene, error).0);
            for texel in 0..truth.len() {
                // At a distance of 1e5 a direction's rounding of 1e-16 moves light by 1e-11 m of a texel's
                // 0.06, and the closed form takes differences of angles of 1e-5: 1e-9 and more to spare.
                let rounding = 1e-7 * truth[texel];
                assert!(
                    low[texel] - rounding <= truth[texel] && truth[texel] <= high[texel] + rounding,
                    "{error}, texel {texel}: {} not in {} .. {}",
                    truth[texel],
                    low[texel],
                    high[texel]
                );
            }
        }
    }
    // Curved glass, from far away and from infinity: the bounds of both hold, so they meet.
    let ball = r#"<shape type="sphere"><point name="center" x="0.1" y="0.05" z="0.7"/>
    <float name="radius" value="0.3"/><ref id="glass"/></shape>"#;
    let run = |light: &str| {
        let scene = scene(folder.path(), &format!("{light}{ball}"));
        known_by(&beams_to(4, &scene, 1e-3).0)
    };
    let (far, sun) = (run(&lamp), run(SUN));
    assert_eq!(far.len(), sun.len());
    for (far, sun) in far
        .iter()
        .zip(&sun)
        .filter(|(one, _)| !one.signature.is_empty())
    {
        assert_eq!(far.signature, sun.signature);
        let brightest = sun.high.iter().copied().fold(0.0, f64::max);
        for texel in 0..SIDE * SIDE {
            // The light is 1e-5 less parallel: no texel's share changes by more than some 1e-4 of the
            // brightest.
            let off = 1e-4 * brightest;
            assert!(
                far.low[texel] <= sun.high[texel] + off && sun.low[texel] <= far.high[texel] + off,
                "{} texel {texel}",
                far.signature
            );
        }
    }
}

/// A wire of a thirtieth of a texel across the light, under a pane and above it: its shadow is as wide as
/// itself.
#[test]
fn the_shadow_of_a_thin_wire_is_within_bounds_on_every_texel() {
    let texel = 2.0 / SIDE as f64;
    let (y, radius): (f64, f64) = (0.287, 1e-3);
    let folder = tempfile::tempdir().unwrap();
    for (what, things) in [("mesh", PANE), ("rectangles", RECTANGLES)] {
        for z in [1.0, 3.0] {
            let wire = format!(
                r#"<shape type="cylinder"><point name="p0" x="-2" y="{y}" z="{z}"/><point name="p1" x="2" y="{y}" z="{z}"/>
    <float name="radius" value="{radius}"/><bsdf type="diffuse"/></shape>"#
            );
            let scene = scene(folder.path(), &format!("{SUN}{wire}{things}"));
            for error in [0.1, 0.01, 1e-3] {
                let [low, high] = through(&beams_to(2, &scene, error).0);
                for row in 0..SIDE {
                    let from = -1.0 + texel * row as f64;
                    let shaded = ((y + radius).min(from + texel) - (y - radius).max(from)).max(0.0);
                    let truth = 100.0 * THROUGH * (1.0 - shaded / texel);
                    for column in 0..SIDE {
                        let at = row * SIDE + column;
                        // Rounding of some tens of operations.
                        let rounding = 1e-10 * truth;
                        assert!(
                            low[at] - rounding <= truth && truth <= high[at] + rounding,
                            "{what}, wire at {z}, {error}, texel {column} {row}: {truth} not in {} .. {}",
                            low[at],
                            high[at]
                        );
                    }
                }
            }
        }
    }
}

/// Each signature that brings photons a 1e-5th of the caustic's light, in slivers of light space as it may be, is
/// known to the discovery.
#[test]
fn what_photons_find_the_discovery_finds() {
    for name in [
        "coffee-cup",
        "mirror-ring",
        "glass-ball",
        "lens",
        "diamond",
        "glass-ball-mesh",
    ] {
        const DEPTH: u32 = 10;
        let scene = bundled(name, SIDE);
        let settings = BeamSettings {
            max_depth: DEPTH,
            ..BeamSettings::default()
        };
        let progress = Progress::default();
        let setup = BeamSetup::new(&scene, meter(&scene), settings, &progress).unwrap();
        let discovered: Vec<_> = setup.signatures().collect();
        let mut photons = Photons::new(1 << 20);
        photons.settings.max_layers = 256;
        photons.settings.chains.max_depth = DEPTH;
        let witness = photons.estimate(&scene);
        let received =
            |row: &nephroid::internals::transport::ledger::FluxByFate| row.received.mean();
        let total: f64 = witness.ledger.rows.values().map(received).sum();
        let mut found = 0;
        for (signature, row) in &witness.ledger.rows {
            if received(row) < 1e-5 * total {
                continue;
            }
            found += 1;
            assert!(
                signature.is_empty() || discovered.contains(signature),
                "{name}: {signature} is not found"
            );
        }
        println!("{name}: {found} of {}", discovered.len());
        assert!(found >= 2, "{name}");
    }
}

/// A tube of glass and a disk of thin glass beside it, whose light falls on a plate that a camera sees from
/// near by: of thousands of places that are spread over both, few send light there, and fewer by way of both
/// or of the tube's inside.
#[test]
fn what_photons_find_of_dim_light_before_a_camera_the_discovery_finds() {
    const DEPTH: u32 = 5;
    let things = r#"<scene version="3.0.0">
  <emitter type="point"><point name="position" x="-7.72" y="0.29" z="2.69"/><rgb name="intensity" value="64"/></emitter>
  <shape type="cylinder"><transform name="to_world"><scale x="0.17" y="0.17" z="0.34"/>
    <rotate x="0.685014" y="-0.585409" z="-0.433649" angle="-44"/>
    <rotate x="0.674764" y="0.668732" z="-0.312236" angle="-84"/>
    <translate x="-0.53" y="0.07" z="-0.51"/></transform>
    <bsdf type="dielectric"><float name="int_ior" value="1.8"/><float name="ext_ior" value="1"/></bsdf></shape>
  <shape type="disk"><transform name="to_world"><scale x="0.3" y="0.3"/>
    <rotate x="0.314638" y="-0.645058" z="0.69635" angle="152"/>
    <rotate x="-0.918875" y="0.01267" z="-0.394346" angle="-56"/>
    <translate x="-1.2" y="0.28" z="-0.47"/></transform>
    <bsdf type="thindielectric"><float name="int_ior" value="2.4"/></bsdf></shape>
  <shape type="rectangle"><transform name="to_world"><scale x="0.3" y="0.3"/><rotate x="1" angle="10"/>
    <lookat origin="1.38,0,-0.59" target="0.43,0,-0.29" up="-0.47,-0.86,-0.19"/></transform>
    <bsdf type="diffuse"/></shape>
  <sensor type="perspective" id="camera"><float name="fov" value="90"/>
    <transform name="to_world"><lookat origin="0.1,-0.45,-0.31" target="1.47,0,-0.6" up="0.65,-0.1,0.76"/></transform>
    <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="12"/><rfilter type="box"/></film>
  </sensor></scene>"#;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, things).unwrap();
    let scene = Scene::new(nephroid::internals::mitsuba::load_parts(&file, &[]).unwrap()).unwrap();
    let progress = Progress::default();
    let settings = BeamSettings {
        max_depth: DEPTH,
        ..BeamSettings::default()
    };
    let setup = BeamSetup::new(&scene, &scene.sensors()[0], settings, &progress).unwrap();
    let discovered: Vec<_> = setup.signatures().collect();
    let mut photons = PhotonSettings {
        max_layers: 64,
        ..PhotonSettings::default()
    };
    photons.chains.max_depth = DEPTH;
    let budget = Budget {
        work: Some(1 << 22),
        ..Budget::default()
    };
    let witness = PhotonSetup::new(&scene, &scene.sensors()[0], photons, &progress)
        .and_then(|setup| setup.run(&budget))
        .unwrap();
    let sum = |values: &[nephroid::internals::radiometry::Rgb]| {
        values.iter().map(|rgb| rgb.mean()).sum::<f64>()
    };
    let total = sum(&witness.total.values);
    let mut found = 0;
    for layer in &witness.layers {
        let LayerName::Path(signature) = layer.name else {
            continue;
        };
        let share = sum(&layer.values) / total;
        println!("{signature}: {:.2} %", 100.0 * share);
        if !signature.is_empty() && share > 5e-3 {
            found += 1;
            assert!(discovered.contains(&signature), "{signature} is not found");
        }
    }
    assert!(found >= 5, "{found}");
}

#[test]
fn photons_agree_with_beams_from_slivers_of_light_space() {
    // Two balls of glass that nearly touch: light by way of both, and between them, sets out from thin
    // crescents.
    let ball = |x: f64, z: f64| {
        format!(
            r#"<shape type="sphere"><point name="center" x="{x}" y="0" z="{z}"/>
    <float name="radius" value="0.3"/><ref id="glass"/></shape>"#
        )
    };
    let folder = tempfile::tempdir().unwrap();
    let things = format!("{SUN}{}{}", ball(-0.302, 0.5), ball(0.302, 0.5));
    let scene = scene(folder.path(), &things);
    // For larger errors, the faintest are left out.
    for error in [3e-3, 1e-3] {
        let (estimate, report) = beams_to(5, &scene, error);
        let judged =
            assert_photons_are_within_bounds("balls", &scene, (5, &estimate), 1 << 21, ALPHA);
        println!(
            "{error}: {judged} texels, {} signatures",
            report.signatures.len()
        );
        assert!(judged >= 50);
    }
}
