//! Surfaces that shine along their normals, against suns and points, windows and shadows.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use nephroid::internals::mitsuba;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::{Budget, Context, Estimate};
use nephroid::internals::scene::{Emitter, Scene};
use nephroid::internals::transport::direct::AREA_SAMPLES;
use nephroid::internals::transport::domain::LightSpace;

use super::metered::{above_a_floor, by_photons, directly};
use crate::support::paths;

/// Texels a side of a floor from -1 to 1.
const SIDE: usize = 24;

/// Radiant exitance [W/m²] of all lamps here.
const EXITANCE: [f64; 3] = [2.0, 3.0, 5.0];

const LIGHT: &str =
    "<emitter type=\"directionalarea\"><rgb name=\"radiance\" value=\"2, 3, 5\"/></emitter>";

/// Passes all light straight on, as an event: photons through it are direct light.
const CLEAR: &str = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"4\"/><translate z=\"0.25\"/></transform>\
    <bsdf type=\"thindielectric\"><float name=\"int_ior\" value=\"1\"/><float name=\"ext_ior\" value=\"1\"/></bsdf></shape>";

fn load(elements: &str) -> Result<Scene, String> {
    load_with(elements, &[])
}

/// A scene beside some files.
fn load_with(elements: &str, files: &[(&str, String)]) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, above_a_floor(elements, SIDE)).unwrap();
    mitsuba::load(&path, &[]).map_err(|error| error.to_string())
}

fn scene(elements: &str) -> Scene {
    load(elements).unwrap_or_else(|error| panic!("{error}"))
}

fn lamp(kind: &str, transform: &str) -> String {
    format!(
        "<shape type=\"{kind}\"><transform name=\"to_world\">{transform}</transform>{LIGHT}</shape>"
    )
}

/// The part of a texel that is inside a convex polygon, counter-clockwise: Sutherland and Hodgman.
fn part_inside(texel: usize, polygon: &[DVec2]) -> f64 {
    let size = 2.0 / SIDE as f64;
    let low = DVec2::new((texel % SIDE) as f64, (texel / SIDE) as f64) * size - 1.0;
    let mut piece: Vec<DVec2> = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]
        .map(|corner| low + corner * size)
        .to_vec();
    for (index, a) in polygon.iter().enumerate() {
        let b = polygon[(index + 1) % polygon.len()];
        let side = |point: DVec2| (b - *a).perp_dot(point - *a);
        let mut kept = Vec::new();
        for (at, p) in piece.iter().enumerate() {
            let q = piece[(at + 1) % piece.len()];
            let (sp, sq) = (side(*p), side(q));
            if sp >= 0.0 {
                kept.push(*p);
            }
            if sp * sq < 0.0 {
                kept.push(*p + (q - *p) * (sp / (sp - sq)));
            }
        }
        piece = kept;
    }
    let twice: f64 = (0..piece.len())
        .map(|at| piece[at].perp_dot(piece[(at + 1) % piece.len()]))
        .sum();
    0.5 * twice / (size * size)
}

/// Direct light is `part` of each texel at `level` times the exitance; photons through a clear pane agree.
///
/// Edges are bisected to 2⁻¹⁴ of an eighth of a texel; what their bend leaves open is booked.
fn assert_lit(name: &str, light: &str, level: f64, part: &dyn Fn(usize) -> f64) {
    assert_lit_by(name, light, &[], level, part);
}

fn assert_lit_by(
    name: &str,
    light: &str,
    files: &[(&str, String)],
    level: f64,
    part: &dyn Fn(usize) -> f64,
) {
    let scene =
        |elements: &str| load_with(elements, files).unwrap_or_else(|error| panic!("{error}"));
    let found = directly(&scene(light), AREA_SAMPLES);
    for (texel, (irradiance, error)) in found.iter().enumerate() {
        for (c, exitance) in EXITANCE.into_iter().enumerate() {
            let expected = part(texel) * level * exitance;
            let off = (irradiance.0[c] - expected).abs();
            assert!(
                off <= error.0[c] + 1e-4 * exitance,
                "{name}, {texel}: {irradiance:?} for {expected}, error {error:?}"
            );
            assert!(error.0[c] <= 1e-3 * exitance, "{name}: {error:?}");
        }
    }
    let lit = found.iter().filter(|(it, _)| it.0[0] > 0.0).count();
    assert!(lit > 20 && lit < found.len(), "{name}: {lit} texels");
    let through = by_photons(&scene(&format!("{light}{CLEAR}")), 1 << 18);
    let layer = &through.total;
    for (texel, (value, error)) in layer.values.iter().zip(&layer.standard_error).enumerate() {
        let expected = part(texel) * level * EXITANCE[0];
        // Student's t of 15 degrees is beyond 6 once in 40,000. A corner of the light with 1e-3 of a texel may
        // get no photon at all.
        let off = (value.0[0] - expected).abs();
        assert!(
            off <= 6.0 * error.0[0] + 2e-3 * EXITANCE[0],
            "{name}, {texel}: {value:?} for {expected}, error {error:?}"
        );
    }
    let direct = &through.layers[0].values;
    assert!(
        direct.iter().all(|it| it.is_black()),
        "{name}: all by way of the pane"
    );
}

/// A polygon for a disc; it is short of it by π²/(2 n²) of the radius, 5e-6 of a texel.
fn ellipse(center: DVec2, half: DVec2) -> Vec<DVec2> {
    const SIDES: usize = 2000;
    let corner = |index: usize| {
        let angle = std::f64::consts::TAU * index as f64 / SIDES as f64;
        center + half * DVec2::from_angle(angle)
    };
    (0..SIDES).map(corner).collect()
}

#[test]
fn a_rectangle_lights_what_is_straight_before_it() {
    // Facing down, from -0.13 to 0.47 and from -0.55 to 0.25.
    let down = "<scale x=\"0.3\" y=\"0.4\"/><rotate x=\"1\" angle=\"180\"/><translate x=\"0.17\" y=\"-0.15\" z=\"1\"/>";
    let window = [(-0.13, -0.55), (0.47, -0.55), (0.47, 0.25), (-0.13, 0.25)].map(DVec2::from);
    let part = |texel: usize| part_inside(texel, &window);
    assert_lit("rectangle", &lamp("rectangle", down), 1.0, &part);
    let up = down.replace("<rotate x=\"1\" angle=\"180\"/>", "");
    let dark = directly(&scene(&lamp("rectangle", &up)), AREA_SAMPLES);
    assert!(dark.iter().all(|(it, _)| it.is_black()), "its back is dark");
}

#[test]
fn a_tilted_rectangle_lights_by_the_cosine_and_keeps_its_flux() {
    // Turned by 30 degrees about y: light comes down with cos 30°, and the window is longer by 1/cos 30°.
    let tilt = "<scale x=\"0.3\" y=\"0.4\"/><rotate x=\"1\" angle=\"180\"/><rotate y=\"1\" angle=\"30\"/><translate z=\"1\"/>";
    let light = lamp("rectangle", tilt);
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    // Rotation takes (0, 0, -1) to (-sin, 0, -cos): the middle falls at x = -tan 30°.
    let window = [(-1.0, -0.4), (1.0, -0.4), (1.0, 0.4), (-1.0, 0.4)]
        .map(|(x, y): (f64, f64)| DVec2::new(0.3 * x / cos - sin / cos, y));
    let part = |texel: usize| part_inside(texel, &window);
    assert_lit("tilted", &light, cos, &part);
    let size = 4.0 / (SIDE * SIDE) as f64;
    let flux: f64 = directly(&scene(&light), AREA_SAMPLES)
        .iter()
        .map(|(it, _)| it.0[2] * size)
        .sum();
    assert!((flux - EXITANCE[2] * 0.6 * 0.8).abs() < 1e-4, "{flux}");
}

#[test]
fn discs_and_the_faces_of_a_cube_light_what_is_straight_before_them() {
    let down = "<scale x=\"0.6\" y=\"0.35\"/><rotate x=\"1\" angle=\"180\"/><translate x=\"0.1\" z=\"0.7\"/>";
    let disc = ellipse(DVec2::new(0.1, 0.0), DVec2::new(0.6, 0.35));
    let part = |texel: usize| part_inside(texel, &disc);
    assert_lit("disk", &lamp("disk", down), 1.0, &part);
    // Two triangles of each face; the others light nothing here.
    let cube = "<scale x=\"0.31\" y=\"0.43\" z=\"0.1\"/><rotate z=\"1\" angle=\"25\"/><translate x=\"0.1\" z=\"0.7\"/>";
    let turn = DVec2::from_angle(25_f64.to_radians());
    let face = [(-0.31, -0.43), (0.31, -0.43), (0.31, 0.43), (-0.31, 0.43)]
        .map(|it| turn.rotate(DVec2::from(it)) + DVec2::new(0.1, 0.0));
    let part = |texel: usize| part_inside(texel, &face);
    assert_lit("cube", &lamp("cube", cube), 1.0, &part);
}

#[test]
fn a_balls_light_is_that_of_a_point_in_its_middle() {
    let sphere = lamp(
        "sphere",
        "<scale value=\"0.2\"/><translate x=\"0.3\" z=\"0.9\"/>",
    );
    let point = "<emitter type=\"point\"><point name=\"position\" x=\"0.3\" y=\"0\" z=\"0.9\"/>\
        <rgb name=\"intensity\" value=\"0.08, 0.12, 0.2\"/></emitter>";
    let block = "<shape type=\"cube\"><transform name=\"to_world\"><scale value=\"0.1\"/>\
        <translate x=\"-0.2\" z=\"0.2\"/></transform><bsdf type=\"diffuse\"/></shape>";
    for shape in ["", block] {
        let [a, b] = [&sphere[..], point]
            .map(|light| directly(&scene(&format!("{light}{shape}")), AREA_SAMPLES));
        for ((a, error), (b, other)) in a.iter().zip(&b) {
            for c in 0..3 {
                // Of the point, shafts tell which texels see it; of the ball, rays do.
                let bound = error.0[c] + other.0[c] + 1e-4 * b.0[c];
                assert!(
                    (a.0[c] - b.0[c]).abs() <= bound,
                    "{a:?} {b:?} {error:?} {other:?}"
                );
            }
        }
    }
    let through = by_photons(&scene(&format!("{sphere}{CLEAR}")), 1 << 20);
    let expected = directly(&scene(point), AREA_SAMPLES);
    let layer = &through.total;
    let all = layer.values.iter().zip(&layer.standard_error);
    for ((value, error), (expected, _)) in all.zip(&expected) {
        let off = (value.0[1] - expected.0[1]).abs();
        assert!(off <= 6.0 * error.0[1], "{value:?} {expected:?} {error:?}");
        assert!(error.0[1] <= 0.2 * expected.0[1]);
    }
}

#[test]
fn shadows_are_those_of_what_lies_between_the_lamp_and_the_floor() {
    let down = "<scale value=\"0.7\"/><rotate x=\"1\" angle=\"180\"/><translate z=\"1\"/>";
    let block = |height: f64| {
        format!(
            "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"0.22\" y=\"0.31\"/>\
             <translate z=\"{height}\"/></transform><bsdf type=\"diffuse\"/></shape>"
        )
    };
    let light = lamp("rectangle", down);
    let whole = [(-0.7, -0.7), (0.7, -0.7), (0.7, 0.7), (-0.7, 0.7)].map(DVec2::from);
    let shade = [(-0.22, -0.31), (0.22, -0.31), (0.22, 0.31), (-0.22, 0.31)].map(DVec2::from);
    let part = |texel: usize| part_inside(texel, &whole) - part_inside(texel, &shade);
    assert_lit("between", &format!("{light}{}", block(0.5)), 1.0, &part);
    let part = |texel: usize| part_inside(texel, &whole);
    assert_lit("behind", &format!("{light}{}", block(1.5)), 1.0, &part);
}

#[test]
fn a_strip_between_a_shadow_and_the_lamps_end_is_found() {
    // From 0.05 to 0.2 of a row of texels, where none of their Gauss points (0.21 and 0.79) is.
    let (row, texel) = (14.0 / 12.0 - 1.0, 1.0 / 12.0);
    let (from, to) = (row + 0.05 * texel, row + 0.2 * texel);
    let down = format!(
        "<scale x=\"0.95\" y=\"{}\"/><rotate x=\"1\" angle=\"180\"/><translate y=\"{}\" z=\"1\"/>",
        0.5 * (to + 0.5),
        0.5 * (to - 0.5)
    );
    let block = format!(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"1.2\" y=\"{}\"/>\
         <translate y=\"{}\" z=\"0.5\"/></transform><bsdf type=\"diffuse\"/></shape>",
        0.5 * (from + 0.9),
        0.5 * (from - 0.9)
    );
    let strip = [(-0.95, from), (0.95, from), (0.95, to), (-0.95, to)].map(DVec2::from);
    let part = |texel: usize| part_inside(texel, &strip);
    let light = format!("{}{block}", lamp("rectangle", &down));
    assert_lit("strip", &light, 1.0, &part);
}

/// A quad of half sides 0.3 and 0.4 at z = 1, with vertex normals.
fn quad(normals: [DVec3; 4]) -> [(&'static str, String); 1] {
    let mut text = String::new();
    for (x, y) in [(-0.3, -0.4), (0.3, -0.4), (0.3, 0.4), (-0.3, 0.4)] {
        text += &format!("v {x} {y} 1\n");
    }
    for normal in normals {
        text += &format!("vn {} {} {}\n", normal.x, normal.y, normal.z);
    }
    [("quad.obj", text + "f 1//1 2//2 3//3\nf 1//1 3//3 4//4\n")]
}

fn mesh(more: &str) -> String {
    format!(
        "<shape type=\"obj\" id=\"it\"><string name=\"filename\" value=\"quad.obj\"/>{more}{LIGHT}</shape>"
    )
}

#[test]
fn leaning_vertex_normals_send_all_of_the_exitance_their_way() {
    // Normals 20 degrees off: light lands tan 20° further, and the floor has M / cos 20° · cos 20°.
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let mirror = "<transform name=\"to_world\"><scale x=\"-1\"/></transform>";
    let flip = "<boolean name=\"flip_normals\" value=\"true\"/>";
    for (name, normal, more, shift) in [
        ("leaning", DVec3::new(sin, 0.0, -cos), "", sin / cos),
        ("mirrored", DVec3::new(sin, 0.0, -cos), mirror, -sin / cos),
        ("flipped", DVec3::new(sin, 0.0, cos), flip, -sin / cos),
    ] {
        let window = [(-0.3, -0.4), (0.3, -0.4), (0.3, 0.4), (-0.3, 0.4)]
            .map(|(x, y)| DVec2::new(x + shift, y));
        let part = |texel: usize| part_inside(texel, &window);
        assert_lit_by(name, &mesh(more), &quad([normal; 4]), 1.0, &part);
    }
}

#[test]
fn a_mirrored_lamp_shines_to_the_side_that_it_did() {
    let window = [(-0.3, -0.4), (0.3, -0.4), (0.3, 0.4), (-0.3, 0.4)].map(DVec2::from);
    let part = |texel: usize| part_inside(texel, &window);
    let down = "<scale x=\"-0.3\" y=\"0.4\"/><rotate x=\"1\" angle=\"180\"/><translate z=\"1\"/>";
    assert_lit("rectangle", &lamp("rectangle", down), 1.0, &part);
    let cube = "<scale x=\"-0.3\" y=\"0.4\" z=\"0.1\"/><translate z=\"1\"/>";
    assert_lit("cube", &lamp("cube", cube), 1.0, &part);
}

#[test]
fn lamps_smaller_than_the_gaps_between_points_are_found() {
    // A tenth of a texel wide, between the Gauss points (0.21 and 0.79) and beside the middle.
    let (texel, size) = (12 * SIDE + 13, 2.0 / SIDE as f64);
    let middle = DVec2::new((13.0 + 0.35) * size - 1.0, (12.0 + 0.4) * size - 1.0);
    let shape = |kind: &str, half: f64| {
        let place = format!(
            "<scale value=\"{half}\"/><rotate x=\"1\" angle=\"180\"/><translate x=\"{}\" y=\"{}\" z=\"1\"/>",
            middle.x, middle.y
        );
        lamp(kind, &place)
    };
    let half = 0.05 * size;
    for (kind, share) in [
        ("rectangle", 0.01),
        ("cube", 0.01),
        ("disk", 0.0025 * std::f64::consts::PI),
    ] {
        let light = shape(kind, half);
        for (at, (irradiance, error)) in directly(&scene(&light), AREA_SAMPLES).iter().enumerate() {
            let expected = if at == texel {
                share * EXITANCE[1]
            } else {
                0.0
            };
            let off = (irradiance.0[1] - expected).abs();
            assert!(off <= 1e-9 * EXITANCE[1], "{kind}, {at}: {irradiance:?}");
            assert_eq!(error.0[1], 0.0, "{kind}, {at}");
        }
        // A block whose end halves the light: what cannot be told is in the bar.
        let block = format!(
            "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"0.5\" y=\"0.5\"/>\
             <translate x=\"{}\" z=\"0.5\"/></transform><bsdf type=\"diffuse\"/></shape>",
            middle.x + 0.5
        );
        let found = directly(&scene(&format!("{light}{block}")), AREA_SAMPLES);
        let (irradiance, error) = found[texel];
        let expected = 0.5 * share * EXITANCE[1];
        assert!(
            (irradiance.0[1] - expected).abs() <= error.0[1] && error.0[1] <= share * EXITANCE[1],
            "{kind}: {irradiance:?} {error:?}"
        );
    }
}

/// A ball of glass whose caustic has a closed form in sunlight.
const BALL: &str = "<shape type=\"sphere\"><transform name=\"to_world\"><scale value=\"0.4\"/><translate z=\"0.8\"/></transform>\
    <bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/></bsdf></shape>";

#[test]
fn a_lamp_that_covers_a_glass_ball_makes_the_suns_caustic() {
    let sun = "<emitter type=\"directional\"><vector name=\"direction\" x=\"0\" y=\"0\" z=\"-1\"/>\
        <rgb name=\"irradiance\" value=\"2, 3, 5\"/></emitter>";
    let below_sun = scene(&format!("{sun}{BALL}"));
    let method = nephroid::Method::new("closed-form", &BTreeMap::new()).unwrap();
    let (sensor, context) = (&below_sun.sensors()[0], Context::default());
    let truth = method
        .run(&below_sun, sensor, &Budget::default(), &context)
        .unwrap();
    let down = "<scale value=\"0.45\"/><rotate x=\"1\" angle=\"180\"/><translate z=\"1.6\"/>";
    for kind in ["rectangle", "disk"] {
        let found = by_photons(&scene(&format!("{}{BALL}", lamp(kind, down))), 1 << 20);
        let layers = |estimate: &Estimate, name: &str| {
            let layer = estimate
                .layers
                .iter()
                .find(|it| it.name.to_string() == name);
            layer.unwrap().clone()
        };
        let (a, b) = (layers(&found, "LTTD"), layers(&truth.estimate, "LTTD"));
        let mut lit = 0;
        for texel in 0..SIDE * SIDE {
            let (value, error) = (a.values[texel].0[1], a.standard_error[texel].0[1]);
            let expected = b.values[texel].0[1];
            assert!(
                (value - expected).abs() <= 6.0 * error + 1e-3,
                "{kind}, {texel}: {value} for {expected}, error {error}"
            );
            lit += usize::from(expected > 1.0);
        }
        assert!(lit > 4, "{lit}");
    }
}

#[test]
fn cells_of_flat_lamps_have_their_flux_exactly() {
    // All of the lamp's light meets the pane: the cells make up all of it.
    for (kind, area) in [("rectangle", 4.0 * 0.12), ("cube", 24.0)] {
        let size = if kind == "cube" {
            ""
        } else {
            "<scale x=\"0.3\" y=\"0.4\"/>"
        };
        let down = format!("{size}<rotate x=\"1\" angle=\"180\"/><translate z=\"1.3\"/>");
        let around = CLEAR.replace("rectangle", "cube").replace("0.25", "0");
        let light = LightSpace::new(&scene(&format!("{}{around}", lamp(kind, &down)))).unwrap();
        let flux = light.flux_bound();
        for (c, exitance) in EXITANCE.into_iter().enumerate() {
            let expected = exitance * area;
            assert!(
                (flux.0[c] - expected).abs() <= 1e-12 * expected,
                "{kind}: {flux:?}"
            );
        }
    }
}

#[test]
fn lamps_that_have_no_single_direction_are_refused_where_they_are_read() {
    let flip = "<boolean name=\"flip_normals\" value=\"true\"/>";
    for (shape, reason) in [
        (
            format!("<shape type=\"cylinder\" id=\"it\">{LIGHT}</shape>"),
            "which is bent",
        ),
        (
            format!("<shape type=\"sphere\" id=\"it\">{flip}{LIGHT}</shape>"),
            "point inward",
        ),
    ] {
        let message = load(&shape).unwrap_err();
        assert!(
            message.contains(reason) && message.contains("\"it\"") && message.contains("xml:1:"),
            "{message}"
        );
    }
    let bent = [
        DVec3::NEG_Z,
        DVec3::NEG_Z,
        DVec3::NEG_Z,
        DVec3::new(0.6, 0.0, -0.8),
    ];
    let message = load_with(&mesh(""), &quad(bent)).unwrap_err();
    assert!(
        message.contains("vertex normals differ within a face") && message.contains("\"it\""),
        "{message}"
    );
    // 513 times two triangles.
    let mut text = String::new();
    for column in 0..=513 {
        let x = f64::from(column) / 513.0;
        text += &format!("v {x} 0 1\nv {x} 1 1\n");
    }
    for column in 0..513 {
        let at = 2 * column + 1;
        text += &format!(
            "f {at} {} {}\nf {} {} {}\n",
            at + 1,
            at + 2,
            at + 1,
            at + 3,
            at + 2
        );
    }
    let message = load_with(&mesh(""), &[("quad.obj", text)]).unwrap_err();
    assert!(
        message.contains("too many triangles") && message.contains("at most 1024"),
        "{message}"
    );
    let message = load(LIGHT).unwrap_err();
    assert!(message.contains("must be inside the shape"), "{message}");
}

#[test]
fn methods_that_cannot_start_along_normals_say_so() {
    let down = "<rotate x=\"1\" angle=\"180\"/><translate z=\"1.6\"/>";
    let scene = scene(&format!("{}{BALL}", lamp("rectangle", down)));
    let sensor = &scene.sensors()[0];
    for name in [
        "beams",
        "caustic-map",
        "caustics-volume",
        "local-irradiance",
        "closed-form",
    ] {
        let method = nephroid::Method::new(name, &BTreeMap::new()).unwrap();
        let result = method.run(&scene, sensor, &Budget::default(), &Context::default());
        let message = result.map(|_| ()).unwrap_err().to_string();
        assert!(message.contains("directionalarea"), "{name}: {message}");
    }
    let choice = nephroid::Method::choose(&scene, sensor).unwrap();
    assert_eq!(choice.method.name(), "photons");
    assert!(
        choice.reason.contains("along the normals"),
        "{}",
        choice.reason
    );
}

#[test]
fn lamps_along_normals_give_the_same_bits_on_any_number_of_threads() {
    let down = "<scale value=\"0.45\"/><rotate x=\"1\" angle=\"180\"/><translate z=\"1.6\"/>";
    let scene = scene(&format!("{}{BALL}", lamp("disk", down)));
    paths::assert_same_on_threads(&[2, 5], || by_photons(&scene, 1 << 14));
}

#[test]
fn the_lamp_is_read_with_mitsubas_meaning() {
    let scene = scene(&lamp("rectangle", ""));
    let Emitter::DirectionalArea {
        exitance, texture, ..
    } = scene.emitters()[0]
    else {
        panic!("{:?}", scene.emitters());
    };
    assert_eq!((exitance, texture), (Rgb(EXITANCE), None));
    assert!(scene.emitters()[0].is_delta());
}
