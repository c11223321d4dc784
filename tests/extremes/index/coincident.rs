//! Surfaces between the same glass, and surfaces at the same place.

use nephroid::internals::scene::Scene;

use super::nested::film;
use super::shells::{FLOOR, SIDE, Shells, followed};
use crate::support::extremes::{U, beams, distance, layer, red, scene};

fn sun(things: &str) -> Scene {
    scene(
        &format!(
            r#"<emitter type="directional"><vector name="direction" x="0.3" y="0.1" z="-1"/><rgb name="irradiance" value="1000"/></emitter>
{things}{FLOOR}"#
        ),
        None,
        SIDE,
    )
}

/// A wide flat surface.
fn surface(height: f64, below: f64, above: f64) -> String {
    format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="5"/><translate z="{height:?}"/></transform>
<bsdf type="dielectric"><float name="int_ior" value="{below:?}"/><float name="ext_ior" value="{above:?}"/></bsdf></shape>"#
    )
}

/// Texels are 0.25 wide, and corners of light up to 10 off with some 16 roundings each: 4 · 16 u · 10 / 0.25,
/// for each map.
#[test]
fn blocks_of_the_same_glass_with_one_surface_between_them_are_one_block() {
    let one = sun(&[surface(2.0, 1.5, 1.0), surface(1.0, 1.0, 1.5)].concat());
    let two = sun(&[
        surface(2.0, 1.5, 1.0),
        surface(1.5, 1.5, 1.5),
        surface(1.0, 1.0, 1.5),
    ]
    .concat());
    let one = red(layer(&beams(&one, 1e-3, 2), "LTTD").expect("light"));
    let two = red(layer(&beams(&two, 1e-3, 3), "LTTTD").expect("light"));
    let apart = distance(&one, &two);
    println!("matched media with a surface between them: change {apart:.1e}");
    assert!(apart <= 2.0 * 4.0 * 16.0 * U * 10.0 / 0.25, "{apart:e}");
}

/// Number of a scene's warnings about surfaces at the same place.
fn coincidences(scene: &Scene) -> usize {
    let warnings = scene.warnings().iter();
    warnings
        .filter(|warning| warning.message.contains("at the same place"))
        .count()
}

#[test]
fn surfaces_at_the_same_place_are_met_once_and_the_scene_says_so() {
    // Glass that holds water with no gap at all: light enters the first declared, and never the second.
    let full = film(0.0).scene(SIDE);
    assert_eq!(coincidences(&full), 1, "{:?}", full.warnings());
    assert!(followed(&film(0.0), &full, 0.3).is_none());
    assert!(followed(&Shells::ball(1.0, 1.33), &full, 0.3).is_some());
    assert_eq!(coincidences(&film(1e-12).scene(SIDE)), 0);

    let cube = |height: f64, x: f64| {
        format!(
            r#"<shape type="cube"><transform name="to_world"><scale value="0.25"/><translate x="{x:?}" z="{height:?}"/></transform>
<bsdf type="dielectric"/></shape>"#
        )
    };
    let tube = |from: f64, to: f64| {
        format!(
            r#"<shape type="cylinder"><point name="p0" x="0" y="0" z="{from:?}"/><point name="p1" x="0" y="0" z="{to:?}"/>
<float name="radius" value="0.5"/><bsdf type="dielectric"/></shape>"#
        )
    };
    let disk = |x: f64| {
        format!(
            r#"<shape type="disk"><transform name="to_world"><scale value="0.5"/><translate x="{x:?}" z="1"/></transform>
<bsdf type="diffuse"/></shape>"#
        )
    };
    for (what, things, expected) in [
        ("a block that stands on the floor", cube(0.25, 0.0), 1),
        ("a block above it", cube(0.25 + 1e-12, 0.0), 0),
        ("a block beside the floor", cube(0.25, 2.25), 0),
        (
            "two blocks in one place",
            cube(0.75, 0.0) + &cube(0.75, 0.0),
            1,
        ),
        (
            "blocks that share an edge",
            cube(1.25, 0.5) + &cube(0.75, 0.0),
            0,
        ),
        (
            "two sheets in one plane",
            surface(1.0, 1.5, 1.0) + &surface(1.0, 1.33, 1.5),
            1,
        ),
        ("a disc on a sheet", surface(1.0, 1.5, 1.0) + &disk(0.0), 1),
        (
            "a disc that touches a sheet's side",
            surface(1.0, 1.5, 1.0) + &disk(5.5),
            0,
        ),
        ("tubes that overlap", tube(1.0, 2.0) + &tube(1.5, 3.0), 1),
        ("tubes end to end", tube(1.0, 2.0) + &tube(2.0, 3.0), 0),
        ("nothing that refracts", disk(0.0) + &disk(0.1), 0),
    ] {
        let scene = sun(&things);
        assert_eq!(
            coincidences(&scene),
            expected,
            "{what}: {:?}",
            scene.warnings()
        );
    }
}
