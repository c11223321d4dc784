//! Flat glass, and what the middle of its light does not meet: receivers beside it, places that a camera sees
//! beside it, surfaces that cross each other.

use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::run::{Estimate, LayerName};
use nephroid::internals::scene::Scene;

use crate::support::beams::{assert_photons_are_within_bounds, beams_to};
use crate::support::scenes::loaded;
use crate::support::seen;

/// Texels or pixels a side, of what closed forms judge.
const SIDE: usize = 16;

/// Texels a side of a receiver that few photons meet.
const COARSE: usize = 4;

/// The probability that a right program fails a test, and in how many texels it may.
const ALPHA: (f64, usize) = (1e-6, 1 << 16);

const SUN: &str = r#"<emitter type="directional"><vector name="direction" x="0.3" y="0.1" z="-1"/>
  <rgb name="irradiance" value="1"/></emitter>"#;

const LAMP: &str = r#"<emitter type="point"><point name="position" x="-0.3" y="-0.2" z="3"/>
  <rgb name="intensity" value="9"/></emitter>"#;

const FILM: &str = r#"<film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/>
  <rfilter type="box"/></film>"#;

/// A pane of glass of half width 1 from z = 0.8 to 1.
const PANE: &str = r#"<shape type="cube"><transform name="to_world"><scale x="1" y="1" z="0.1"/><translate z="0.9"/></transform>
  <ref id="glass"/></shape>"#;

/// A diffuse floor at z = 0, much wider than what is below the pane.
const FLOOR: &str = r#"<shape type="rectangle"><transform name="to_world"><scale x="3" y="3"/></transform>
  <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>"#;

/// A shape on which an irradiance meter is.
fn receiver(plugin: &str, to_world: &str) -> String {
    format!(
        r#"<shape type="{plugin}"><transform name="to_world">{to_world}</transform><bsdf type="diffuse"/>
  <sensor type="irradiancemeter" id="meter">{FILM}</sensor></shape>"#
    )
}

/// A glass cube, placed.
fn cube(to_world: &str) -> String {
    format!(
        r#"<shape type="cube"><transform name="to_world">{to_world}</transform><ref id="glass"/></shape>"#
    )
}

fn scene(things: &[&str], side: usize) -> Scene {
    let xml = format!(
        r#"<scene version="3.0.0">
  <bsdf type="dielectric" id="glass"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
  {}</scene>"#,
        things.concat()
    );
    let folder = tempfile::tempdir().expect("a folder for the scene");
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, xml).expect("the scene's file");
    loaded(&file, side)
}

/// Part of the sun's irradiance on a level surface that goes straight through the pane: (1 − F)² cos θ.
fn straight_through() -> f64 {
    let cos = 1.0 / f64::sqrt(1.0 + 0.3 * 0.3 + 0.1 * 0.1);
    let passed = 1.0 - dielectric_reflectance(cos, 1.5);
    passed * passed * cos
}

/// Every texel's bounds of `LTTD` hold `truth`, and values are off by `error` at most in the root mean
/// square.
fn assert_even(name: &str, estimate: &Estimate, truth: f64, error: f64) {
    let wanted = LayerName::Path("LTTD".parse().expect("a signature"));
    let layer = estimate.layers.iter().find(|layer| layer.name == wanted);
    let layer = layer.expect("light goes straight through the pane");
    let bounds = layer.interval.as_ref().expect("beams have bounds");
    // Some hundreds of sums and products of numbers of the truth's size.
    let rounding = 1e3 * f64::EPSILON * truth;
    let mut squares = 0.0;
    for texel in 0..SIDE * SIDE {
        let (low, high) = (bounds.low[texel].0[0], bounds.high[texel].0[0]);
        assert!(
            low <= truth + rounding && truth <= high + rounding,
            "{name}, texel {} {}: {truth} is not in {low} .. {high}",
            texel % SIDE,
            texel / SIDE
        );
        squares += (layer.values[texel].0[0] - truth).powi(2);
    }
    let off = (squares / (SIDE * SIDE) as f64).sqrt() / truth;
    println!("{name}: off by {off:.1e}");
    assert!(off <= error, "{name}: {off}");
}

/// All of the receiver is in the light of a pane whose middle's light goes to the floor behind it.
#[test]
fn a_receiver_before_a_floor_catches_what_goes_its_way() {
    let low = r#"<scale value="0.15"/><translate x="0.7" y="0.4" z="0.2"/>"#;
    let tilted = format!(r#"<rotate y="1" angle="10"/>{low}"#);
    // The receiver's plane goes on beyond it, above the floor or through it.
    let slope = f64::to_radians(10.0);
    let onto_slope = (slope.cos() - 0.3 * slope.sin()).abs();
    for (name, plugin, to_world, facing) in [
        ("disk", "disk", low, 1.0),
        ("rectangle", "rectangle", low, 1.0),
        ("tilted disk", "disk", tilted.as_str(), onto_slope),
        ("tilted rectangle", "rectangle", tilted.as_str(), onto_slope),
    ] {
        let scene = scene(&[SUN, PANE, FLOOR, &receiver(plugin, to_world)], SIDE);
        for error in [0.1, 0.01] {
            let (estimate, _) = beams_to(4, &scene, error);
            // Texels of a disk's rim are partly off it: none here, its film is (radius, angle).
            assert_even(name, &estimate, straight_through() * facing, error);
        }
    }
}

/// The camera's film ends far from where the middle of the pane's light falls.
#[test]
fn a_camera_sees_light_that_falls_beside_the_middle_of_a_panes() {
    let plate = r#"<shape type="rectangle"><transform name="to_world"><scale x="0.15" y="0.15"/>
      <translate x="0.6" y="0.3" z="0.02"/></transform>
      <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>"#;
    let camera = |at: &str, down_to: &str| {
        format!(
            r#"<sensor type="perspective" id="camera"><float name="fov" value="15"/>
      <transform name="to_world"><lookat origin="{at}" target="{down_to}" up="0,1,0"/></transform>{FILM}</sensor>"#
        )
    };
    let of_floor = camera("0.8,0.5,0.6", "0.8,0.5,0");
    let of_plate = camera("0.6,0.3,0.6", "0.6,0.3,0.02");
    // A shape that the camera does not see, which the middle's light falls on.
    let blocker = r#"<shape type="sphere"><float name="radius" value="0.1"/>
      <point name="center" x="0.2" y="0.1" z="0.3"/><bsdf type="diffuse"/></shape>"#;
    for (name, things) in [
        ("floor", [SUN, PANE, FLOOR, &of_floor]),
        ("plate", [SUN, PANE, &format!("{FLOOR}{plate}"), &of_plate]),
        (
            "blocker",
            [SUN, PANE, &format!("{FLOOR}{blocker}"), &of_floor],
        ),
    ] {
        let scene = scene(&things, SIDE);
        for error in [0.1, 0.01] {
            let (estimate, _) = seen::by_beams(&scene, "camera", error);
            let truth = straight_through() * 0.5 * std::f64::consts::FRAC_1_PI;
            assert_even(name, &estimate, truth, error);
        }
    }
}

#[test]
fn photons_agree_where_flat_surfaces_cross() {
    let floor = receiver("rectangle", r#"<scale x="1.2" y="1.2"/>"#);
    let turned = r#"<scale value="0.4"/><rotate x="1" y="0.3" angle="30"/>"#;
    let other = r#"<scale value="0.3"/><rotate x="1" angle="70"/><translate x="0.3" z="0.9"/>"#;
    let blade = r#"<shape type="rectangle"><transform name="to_world"><scale x="0.3" y="0.25"/>
      <rotate x="1" angle="70"/><translate x="0.2" z="0.9"/></transform>
      <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>"#;
    let slope = r#"<shape type="rectangle"><transform name="to_world"><scale x="3" y="3"/>
      <rotate y="1" angle="10"/><translate x="0.4" y="0.3"/></transform>
      <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>"#;
    let high = cube(&format!(r#"{turned}<translate z="0.9"/>"#));
    let sunk = cube(&format!(r#"{turned}<translate z="0.1"/>"#));
    let low = PANE.replace("0.9", "0.15");
    for (name, things, depth) in [
        ("a blade in a cube", vec![blade, &high], 3),
        ("two cubes", vec![&high, &cube(other)], 4),
        ("a cube sunk in the floor", vec![&sunk], 3),
        ("a floor that a slope crosses", vec![PANE, slope], 3),
        ("a pane that a blade crosses", vec![&low, blade], 3),
    ] {
        for (light, emitter) in [("sun", SUN), ("lamp", LAMP)] {
            let things = [&[emitter, &floor], &things[..]].concat();
            let scene = scene(&things, SIDE);
            let (estimate, _) = beams_to(depth, &scene, 0.05);
            let name = format!("{name}, {light}");
            let judged =
                assert_photons_are_within_bounds(&name, &scene, (depth, &estimate), 1 << 19, ALPHA);
            println!(
                "{name}: {judged} texels of {} layers",
                estimate.layers.len()
            );
            assert!(judged >= 20, "{name}: {judged}");
        }
    }
}

/// The receiver is round and above the floor; a lamp's light is bent.
#[test]
fn photons_agree_on_a_ball_below_a_pane() {
    let ball = receiver(
        "sphere",
        r#"<scale value="0.15"/><translate x="0.7" y="0.4" z="0.2"/>"#,
    );
    for (light, emitter) in [("sun", SUN), ("lamp", LAMP)] {
        let scene = scene(&[emitter, PANE, FLOOR, &ball], COARSE);
        let (estimate, _) = beams_to(3, &scene, 0.02);
        let judged =
            assert_photons_are_within_bounds(light, &scene, (3, &estimate), 1 << 20, ALPHA);
        println!("{light}: {judged} texels");
        assert!(judged >= 5, "{light}: {judged}");
    }
}

/// A lamp just above a pane lights a spot that none of its corners sees; receivers are round, and the middle
/// of the pane's light goes beside them.
#[test]
fn photons_agree_below_a_pane_that_a_lamp_is_close_to() {
    let lamp = r#"<emitter type="point"><point name="position" x="-0.02" y="-0.086" z="0.16"/>
  <rgb name="intensity" value="0.0625"/></emitter>"#;
    let pane = cube(
        r#"<scale x="0.72" y="1.18" z="0.028"/><rotate x="0.383" y="-0.57" z="0.727" angle="58.3"/>
  <rotate x="0.779" y="-0.178" z="-0.601" angle="-49.6"/><translate x="0.338" y="0.083" z="0.143"/>"#,
    );
    let place = r#"<translate x="0.08" y="0.355" z="-0.453"/>"#;
    for (plugin, shape) in [
        ("disk", r#"<scale x="1.5" y="1.5"/>"#),
        ("sphere", r#"<scale value="0.4"/>"#),
        (
            "cylinder",
            r#"<scale x="0.2" y="0.2" z="2"/><translate z="-1"/><rotate x="1" angle="90"/>"#,
        ),
    ] {
        let receiver = receiver(plugin, &format!("{shape}{place}"));
        let scene = scene(&[lamp, &pane, &receiver], SIDE);
        let (estimate, _) = beams_to(2, &scene, 0.02);
        let judged =
            assert_photons_are_within_bounds(plugin, &scene, (2, &estimate), 1 << 20, ALPHA);
        println!("{plugin}: {judged} texels");
        assert!(judged >= 20, "{plugin}: {judged}");
    }
}
