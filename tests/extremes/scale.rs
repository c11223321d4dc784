//! A scene has no size: in other units it has the same light.
//!
//! Lengths are scaled by s and radiant intensities by s², so that irradiance [W/m²] stays as it is.

use std::fmt::Write as _;

use nephroid::internals::geometry::Shape;
use nephroid::internals::reference::path;
use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, Progress};
use nephroid::internals::scene::Scene;

use crate::support::extremes::{
    BALL, DIAMOND, Placement, RING, Template, WATER, beams, beams_to, camera, distance, photons,
    photons_to, red, scene, scene_with,
};

/// Chains of light from points, spots and the sun, by each kind of shape.
const SCENES: [Template; 4] = [BALL, RING, DIAMOND, WATER];

/// A cube of glass under a lamp with an area. Radiance stays as it is, whatever the scale.
const CUBE: Template = Template {
    name: "glass cube",
    mesh: None,
    xml: r#"
<shape type="rectangle">
  <transform name="to_world"><scale value="0.2"/><rotate x="1" angle="180"/><translate x="0.3" z="2.5"/>{placed}</transform>
  <bsdf type="diffuse"/>
  <emitter type="area"><rgb name="radiance" value="40, 30, 20"/></emitter>
</shape>
<shape type="cube">
  <transform name="to_world"><scale x="0.5" y="0.4" z="0.3"/><rotate z="1" angle="20"/><rotate x="1" angle="10"/><translate z="0.9"/>{placed}</transform>
  <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="rectangle">
  <transform name="to_world"><scale value="1.1"/>{placed}</transform>
  <bsdf type="diffuse"/>{meter}
</shape>"#,
};

/// A camera that looks down at what the others have on the floor.
const CAMERA: Template = Template {
    name: "camera",
    mesh: None,
    xml: r#"
<sensor type="perspective">
  <float name="fov" value="32"/>
  <float name="near_clip" value="{length 0.01}"/>
  <float name="far_clip" value="{length 100}"/>
  <transform name="to_world"><lookat origin="{length 0.4}, {length -2.2}, {length 3}" target="0, 0, 0" up="0, 0, 1"/></transform>
  {film}
</sensor>"#,
};

/// A grey sky, which chains of light refuse: paths from a camera see it.
const SKY: &str =
    r#"<emitter type="constant"><rgb name="radiance" value="0.5, 0.7, 0.9"/></emitter>"#;

/// Texels a side.
const SIDE: usize = 16;

/// Every number that two runs deliver about every texel.
fn assert_same_bits(name: &str, home: &Estimate, scaled: &Estimate) {
    assert_eq!(home.layers.len(), scaled.layers.len(), "{name}");
    assert_eq!(home.counters, scaled.counters, "{name}");
    for (a, b) in home.layers.iter().zip(&scaled.layers) {
        assert_eq!(a.name, b.name, "{name}");
        let at = |a: &[nephroid::internals::radiometry::Rgb],
                  b: &[nephroid::internals::radiometry::Rgb]| {
            let bits = |value: &nephroid::internals::radiometry::Rgb| value.0.map(f64::to_bits);
            a.iter().zip(b).position(|(a, b)| bits(a) != bits(b))
        };
        assert_eq!(at(&a.values, &b.values), None, "{name} {}", a.name);
        assert_eq!(
            at(&a.standard_error, &b.standard_error),
            None,
            "{name} {}: error",
            a.name
        );
        assert_eq!(
            a.interval.is_some(),
            b.interval.is_some(),
            "{name} {}",
            a.name
        );
        if let (Some(a_bounds), Some(b_bounds)) = (&a.interval, &b.interval) {
            assert_eq!(at(&a_bounds.low, &b_bounds.low), None, "{name} {}", a.name);
            assert_eq!(
                at(&a_bounds.high, &b_bounds.high),
                None,
                "{name} {}",
                a.name
            );
        }
    }
}

/// A scene's map by both methods, scaled.
fn maps(template: &Template, scale: f64) -> [(&'static str, Estimate); 2] {
    maps_of(&template.scene(Placement::scaled(scale), SIDE))
}

fn maps_of(scene: &Scene) -> [(&'static str, Estimate); 2] {
    [
        ("beams", beams(scene, 1e-2, 4)),
        ("photons", photons(scene, 1 << 14, 4)),
    ]
}

/// A power of two rounds nothing, so nothing may change: not a bit of any value or error, not a ray.
#[test]
fn scaled_by_powers_of_two_maps_have_the_same_bits() {
    for template in SCENES {
        let home = maps(&template, 1.0);
        for exponent in [-60, 3, 40] {
            let scaled = maps(&template, f64::powi(2.0, exponent));
            for ((method, a), (_, b)) in home.iter().zip(&scaled) {
                assert_same_bits(
                    &format!("{} by {method}, 2^{exponent}", template.name),
                    a,
                    b,
                );
            }
        }
    }
}

/// Lamps with areas, cubes, cameras and skies: of each method that takes them.
#[test]
fn lamps_cubes_skies_and_cameras_have_the_same_bits_too() {
    /// Texels or pixels a side.
    const FEW: usize = 8;
    let run = |scale: f64| {
        let place = Placement::scaled(scale);
        let text = CUBE.placed(place) + &CAMERA.placed(place);
        let lit = scene(&text, None, FEW);
        // Beams refuse lamps with areas.
        let ball = scene(&(BALL.placed(place) + &CAMERA.placed(place)), None, FEW);
        let below = scene(&(text + SKY), None, FEW);
        let samples = Budget {
            work: Some(64),
            ..Budget::default()
        };
        let by_paths = path::run(
            &below,
            camera(&below),
            PathSettings::default(),
            &samples,
            &Progress::default(),
        );
        [
            ("photons", photons(&lit, 1 << 14, 4)),
            (
                "photons to the camera",
                photons_to(&lit, camera(&lit), 1 << 14, 4),
            ),
            (
                "beams to the camera",
                beams_to(&ball, camera(&ball), 0.1, 2),
            ),
            ("paths to the camera", by_paths.expect("paths start").0),
        ]
    };
    let home = run(1.0);
    for (method, estimate) in &home {
        let lit = red(&estimate.total)
            .iter()
            .filter(|value| **value > 0.0)
            .count();
        println!("{method}: {lit} of {} texels have light", FEW * FEW);
        assert!(lit > FEW * FEW / 8, "{method}: {lit}");
    }
    for exponent in [-60, 3, 40] {
        for ((method, a), (_, b)) in home.iter().zip(&run(f64::powi(2.0, exponent))) {
            assert_same_bits(&format!("{method}, 2^{exponent}"), a, b);
        }
    }
}

/// A scene in millimetres or kilometres has other roundings. They count as often as a path amplifies them: by
/// hundreds at most here, of some 1e-16 each. What decides where beams are divided does not flip.
#[test]
fn in_other_units_maps_are_the_same_to_a_billionth() {
    println!("scaled by s: largest change of a texel, relative to the brightest");
    for template in SCENES {
        let home = maps(&template, 1.0);
        for scale in [1e-6, 1e-3, 1e3, 1e6] {
            let scaled = maps(&template, scale);
            for ((method, a), (_, b)) in home.iter().zip(&scaled) {
                let apart = distance(&red(&a.total), &red(&b.total));
                println!("  {:10} {method:8} x {scale:e}: {apart:.1e}", template.name);
                assert!(
                    apart <= 1e-9,
                    "{} by {method} x {scale:e}: {apart:e}",
                    template.name
                );
            }
        }
    }
}

/// The glass ball with its numbers as they are, in any unit: `center`, `radius`, `position`.
const BALL_IN_NUMBERS: Template = Template {
    name: "glass ball",
    mesh: None,
    xml: r#"
<emitter type="point">
  <point name="position" x="0" y="0" z="{length 4}"/><rgb name="intensity" value="{area 100}"/>
</emitter>
<shape type="sphere">
  <point name="center" x="0" y="0" z="{length 1.4}"/><float name="radius" value="{length 1}"/>
  <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="rectangle">
  <transform name="to_world"><scale x="{length 2}" y="{length 2}"/></transform>
  <bsdf type="diffuse"/>{meter}
</shape>"#,
};

/// Its sphere in millimetres, whatever the scene's unit is, and its lamp moved where it is.
const BALL_IN_BOTH: Template = Template {
    name: "glass ball",
    mesh: None,
    xml: r#"
<emitter type="point">
  <transform name="to_world"><translate z="{length 4}"/></transform><rgb name="intensity" value="{area 100}"/>
</emitter>
<shape type="sphere">
  <point name="center" x="0" y="0" z="1400"/><float name="radius" value="1000"/>
  <transform name="to_world"><scale value="{length 0.001}"/></transform>
  <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="rectangle">
  <transform name="to_world"><scale x="{length 2}" y="{length 2}"/></transform>
  <bsdf type="diffuse"/>{meter}
</shape>"#,
};

/// The metal ring with its numbers as they are: `p0`, `p1`, `radius`, and the places of `lookat`.
const RING_IN_NUMBERS: Template = Template {
    name: "metal ring",
    mesh: None,
    xml: r#"
<emitter type="spot">
  <transform name="to_world"><lookat origin="{length -1.3}, {length 0.2}, {length 2.1}" target="{length 0.4}, {length 0.1}, 0" up="0, 0, 1"/></transform>
  <rgb name="intensity" value="{area 30}"/>
  <float name="cutoff_angle" value="35"/>
</emitter>
<shape type="cylinder">
  <point name="p0" x="0" y="0" z="0"/><point name="p1" x="0" y="0" z="{length 0.5}"/><float name="radius" value="{length 0.9}"/>
  <bsdf type="twosided"><bsdf type="conductor"><string name="material" value="Au"/></bsdf></bsdf>
</shape>
<shape type="disk">
  <transform name="to_world"><scale value="{length 0.2}"/><translate x="{length 0.1}" y="{length 0.1}" z="{length 0.3}"/></transform>
  <bsdf type="diffuse"/>
</shape>
<shape type="rectangle">
  <transform name="to_world"><scale x="{length 1.1}" y="{length 1.1}"/></transform>
  <bsdf type="diffuse"/>{meter}
</shape>"#,
};

/// The diamond in the sun, with `$to_world` among its parameters.
macro_rules! diamond {
    ($to_world:literal) => {
        concat!(
            r#"
<emitter type="directional">
  <vector name="direction" x="0.3" y="0.1" z="-1"/>
  <rgb name="irradiance" value="1000"/>
</emitter>
<shape type="obj">
  <string name="filename" value="mesh.obj"/><boolean name="face_normals" value="true"/>
"#,
            $to_world,
            r#"  <bsdf type="dielectric"><float name="int_ior" value="2.418"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="rectangle">
  <transform name="to_world"><scale x="{length 1.2}" y="{length 1.2}"/></transform>
  <bsdf type="diffuse"/>{meter}
</shape>"#,
        )
    };
}

/// The diamond with its vertices where they are.
const DIAMOND_IN_NUMBERS: Template = Template {
    name: "diamond",
    mesh: None,
    xml: diamond!(""),
};

/// The diamond in millimetres, whatever the scene's unit is.
const DIAMOND_IN_BOTH: Template = Template {
    name: "diamond",
    mesh: None,
    xml: diamond!("<transform name=\"to_world\"><scale value=\"{length 0.001}\"/></transform>\n"),
};

/// The template's first mesh as it is in its scene, in a unit: an OBJ file, whose text says every digit.
fn obj(template: &Template, unit: f64) -> String {
    let scene = template.scene(Placement::HOME, 1);
    let mut text = String::new();
    for shape in scene.world().shapes() {
        let Shape::Mesh(mesh) = shape else { continue };
        for place in mesh.positions() {
            let [x, y, z] = (*place * unit).to_array();
            writeln!(text, "v {x:?} {y:?} {z:?}").expect("a string grows");
        }
        for [a, b, c] in mesh.triangles().iter().map(|face| face.map(|one| one + 1)) {
            writeln!(text, "f {a} {b} {c}").expect("a string grows");
        }
    }
    assert!(text.contains("f 1"), "{}", template.name);
    text
}

/// A file may give places by numbers in some unit, by `to_world`, or by both: the map is the same.
/// As above, each way has roundings of its own, of some 1e-16 each.
#[test]
fn in_numbers_in_transforms_or_in_both_maps_are_the_same_to_a_billionth() {
    const MILLIMETRES: f64 = 1e3;
    println!(
        "units to a metre: largest change of a texel to the scene made by transforms in metres, relative to the brightest"
    );
    let mut compared = 0;
    for (home, ways) in [
        (
            BALL,
            &[("numbers", BALL_IN_NUMBERS), ("both", BALL_IN_BOTH)][..],
        ),
        (RING, &[("numbers", RING_IN_NUMBERS)]),
        (
            DIAMOND,
            &[("numbers", DIAMOND_IN_NUMBERS), ("both", DIAMOND_IN_BOTH)],
        ),
    ] {
        let at_home = maps(&home, 1.0);
        for (way, template) in ways {
            for unit in [MILLIMETRES, 1.0, 1e-3] {
                let text = template.placed(Placement::scaled(unit));
                let scene = if home.mesh.is_some() {
                    let of_mesh = if *way == "both" { MILLIMETRES } else { unit };
                    scene_with(&text, ("mesh.obj", &obj(&home, of_mesh)), SIDE)
                } else {
                    scene(&text, None, SIDE)
                };
                let here = maps_of(&scene);
                for ((method, a), (_, b)) in at_home.iter().zip(&here) {
                    let (a, b) = (red(&a.total), red(&b.total));
                    let apart = distance(&a, &b);
                    println!(
                        "  {:10} in {way:8} {method:8} x {unit:e}: {apart:.1e}",
                        home.name
                    );
                    assert!(a.iter().any(|value| *value > 0.0), "{}", home.name);
                    assert!(
                        apart <= 1e-9,
                        "{} in {way} by {method} x {unit:e}: {apart:e}",
                        home.name
                    );
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, 30);
}

/// A scene is refused if cubes of its lengths (determinants) underflow, or their fourth powers overflow.
#[test]
fn scenes_too_small_or_large_for_f64_are_refused() {
    for (scale, why) in [
        (1e-130, "the matrix cannot be inverted"),
        (
            1e80,
            "gives the sphere a size of 1e80; allowed is 1e-120 to 1e70",
        ),
    ] {
        let message = BALL.error(Placement::scaled(scale));
        assert!(message.contains(why), "{message}");
    }
}
