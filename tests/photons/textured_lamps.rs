//! Surfaces that shine by a texture, against even lamps, sums of lamps, and the integral over their places.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use nephroid::internals::film::{Image, exr};
use nephroid::internals::geometry::Shape;
use nephroid::internals::mitsuba;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::{Scene, TexturePoint};
use nephroid::internals::transport::domain::LightSpace;

use super::metered::{above_a_floor, by_photons, directly};
use crate::support::paths;

/// Texels a side of a floor from -1 to 1.
const SIDE: usize = 8;

/// Columns and rows of the image.
const SIZE: [usize; 2] = [5, 3];

/// Passes all light straight on, as an event: photons through it are direct light.
const CLEAR: &str = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"8\"/><translate z=\"0.25\"/></transform>\
    <bsdf type=\"thindielectric\"><float name=\"int_ior\" value=\"1\"/><float name=\"ext_ior\" value=\"1\"/></bsdf></shape>";

const BALL: &str = "<shape type=\"sphere\"><transform name=\"to_world\"><scale value=\"0.4\"/><translate z=\"0.6\"/></transform>\
    <bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/></bsdf></shape>";

/// Texels of which one is black, and none like another.
fn texel(column: usize, row: usize) -> [f64; 3] {
    let index = (row * SIZE[0] + column) as f64;
    [index, 2.0 + 0.5 * index, 9.0 - 0.25 * index]
}

fn scene(elements: &str) -> Scene {
    load(elements).unwrap_or_else(|error| panic!("{error}"))
}

fn load(elements: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    let mut image = Image::new(SIZE[0], SIZE[1]);
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        let texels = (0..SIZE[0] * SIZE[1]).map(|index| texel(index % SIZE[0], index / SIZE[0])[c]);
        image.add_scalar(name, texels);
    }
    exr::write(&folder.path().join("picture.exr"), &image).unwrap();
    let mut spot = Image::new(64, 64);
    for name in ["R", "G", "B"] {
        let is_spot = |index: usize| index == 64 * 40 + 23;
        let texels = (0..64 * 64).map(|index| if is_spot(index) { 1000.0 } else { 0.125 });
        spot.add_scalar(name, texels);
    }
    exr::write(&folder.path().join("spot.exr"), &spot).unwrap();
    for (name, value) in [("negative", "-0.1"), ("nan", "nan"), ("good", "0.3")] {
        let mut text = "ply\nformat ascii 1.0\nelement vertex 3\n".to_owned();
        for property in ["x", "y", "z", "r", "g", "b"] {
            text += &format!("property float {property}\n");
        }
        text += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        text += &format!("0 0 1 1 1 1\n0 1 1 {value} 1 1\n1 0 1 1 1 1\n3 0 1 2\n");
        std::fs::write(folder.path().join(format!("{name}.ply")), text).unwrap();
    }
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, above_a_floor(elements, SIDE)).unwrap();
    mitsuba::load(&path, &[]).map_err(|error| error.to_string())
}

/// The picture as radiance, with more parameters.
fn picture(more: &str) -> String {
    format!(
        "<texture name=\"radiance\" type=\"bitmap\"><string name=\"filename\" value=\"picture.exr\"/>\
         <boolean name=\"raw\" value=\"true\"/>{more}</texture>"
    )
}

const NEAREST: &str = "<string name=\"filter_type\" value=\"nearest\"/>";

/// Turns the image, and repeats it.
const TURNED: &str = "<transform name=\"to_uv\"><scale x=\"1.3\" y=\"0.7\"/><rotate z=\"1\" angle=\"33\"/>\
    <translate x=\"0.2\" y=\"-0.4\"/></transform>";

/// Boards, of which some squares are images.
fn boards() -> String {
    format!(
        "<texture name=\"radiance\" type=\"checkerboard\"><rgb name=\"color0\" value=\"0.4, 0.1, 0\"/>{}\
         <transform name=\"to_uv\"><scale x=\"2\" y=\"1.5\"/></transform></texture>",
        picture(TURNED).replace("\"radiance\"", "\"color1\"")
    )
}

fn lamp(plugin: &str, kind: &str, transform: &str, radiance: &str) -> String {
    format!(
        "<shape type=\"{kind}\" id=\"lamp\"><transform name=\"to_world\">{transform}</transform>\
         <emitter type=\"{plugin}\">{radiance}</emitter></shape>"
    )
}

/// Lamps that face the floor, and their coordinates (u, v) → (x, y) for the oracles below.
const SHAPES: [(&str, &str); 4] = [
    (
        "rectangle",
        "<scale x=\"0.5\" y=\"0.3\"/><rotate x=\"1\" angle=\"160\"/><translate x=\"0.2\" z=\"1\"/>",
    ),
    (
        "disk",
        "<scale x=\"0.5\" y=\"0.3\"/><rotate x=\"1\" angle=\"160\"/><translate x=\"0.2\" z=\"1\"/>",
    ),
    (
        "cube",
        "<scale x=\"0.3\" y=\"0.2\" z=\"0.1\"/><rotate x=\"1\" angle=\"20\"/><translate x=\"0.2\" z=\"1\"/>",
    ),
    (
        "sphere",
        "<scale value=\"0.3\"/><rotate x=\"1\" angle=\"70\"/><translate x=\"0.2\" z=\"1\"/>",
    ),
];

/// Ends within the lamp: the texels of the border reach beyond.
const CLAMPED: &str = "<string name=\"wrap_mode\" value=\"clamp\"/><transform name=\"to_uv\">\
    <scale x=\"1.7\" y=\"1.4\"/><translate x=\"-0.3\" y=\"-0.2\"/></transform>";

fn textures() -> [(&'static str, String); 5] {
    [
        ("nearest", picture(NEAREST)),
        ("bilinear", picture("")),
        ("turned", picture(TURNED)),
        ("clamped", picture(CLAMPED)),
        ("boards", boards()),
    ]
}

/// A place of the lamp's surface with its normal, area and value.
struct Place {
    at: DVec3,
    normal: DVec3,
    area: f64,
    value: Rgb,
}

/// The lamp's surface in small pieces, by the parameters of its shape: the texture is looked up by the scene.
fn places(scene: &Scene, steps: usize) -> Vec<Place> {
    let world = scene.world();
    let index = scene
        .objects()
        .iter()
        .position(|it| it.id == "lamp")
        .unwrap();
    let shape = &world.shapes()[index];
    let emitter = scene
        .emitters()
        .iter()
        .find(|it| it.shape().is_some())
        .unwrap();
    let mesh = match shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    };
    let mut all = Vec::new();
    for face in 0..mesh.map_or(1, |mesh| mesh.triangle_count() as u32) {
        for step in 0..steps * steps {
            let (i, j) = (step % steps, step / steps);
            let mut at = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) / steps as f64;
            let mut size = 1.0 / (steps * steps) as f64;
            let point = match mesh {
                Some(mesh) => {
                    // The square's upper half is folded onto the lower: each place counts half a square's.
                    if at.x + at.y > 1.0 {
                        at = DVec2::ONE - at;
                    }
                    size *= mesh.face_area(face);
                    mesh.at_barycentric(face, at, DVec3::Z)
                }
                None => {
                    // Area by parameters is even, but for a disc's radius and a ball's latitude.
                    size *= match shape {
                        Shape::Disk(_) => shape.area() * 2.0 * at.x,
                        Shape::Sphere(_) => shape.area() * 0.25 * TAU * (0.5 * TAU * at.y).sin(),
                        _ => shape.area(),
                    };
                    shape.at_uv(at).unwrap()
                }
            };
            let mut uv = point.uv;
            if mesh.is_none() {
                uv = at;
            }
            let mesh = mesh.map(|mesh| (mesh, face, at));
            let texture = emitter.texture().unwrap();
            let value = scene.texture_value(texture, &TexturePoint { uv, mesh });
            all.push(Place {
                at: point.position,
                normal: point.geometric_normal,
                area: size,
                value: value * emitter.strength(),
            });
        }
    }
    all
}

/// ∫ value dA.
fn flux(places: &[Place]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for place in places {
        for (sum, value) in sum.iter_mut().zip(place.value.0) {
            *sum += value * place.area;
        }
    }
    sum
}

#[test]
fn direct_light_is_the_integral_over_the_lamp() {
    for (kind, transform) in SHAPES {
        for (name, texture) in textures() {
            let scene = scene(&lamp("area", kind, transform, &texture));
            let places = places(&scene, 240);
            let found = directly(&scene, 4096);
            for texel in [9, 27, 36, 52] {
                let corner = DVec2::new((texel % SIDE) as f64, (texel / SIDE) as f64);
                let mut expected = [0.0; 3];
                // 2 x 2 Gauss points of a texel, from 0.7 m away.
                for (i, j) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
                    let within = DVec2::splat(0.5) + DVec2::new(i, j) / 12_f64.sqrt();
                    let floor = ((corner + within) * 2.0 / SIDE as f64 - 1.0).extend(0.0);
                    for place in &places {
                        let offset = place.at - floor;
                        let cosines = offset.z * -offset.dot(place.normal);
                        if offset.dot(place.normal) >= 0.0 || offset.z <= 0.0 {
                            continue;
                        }
                        let squared = offset.length_squared();
                        let part = 0.25 * cosines / (squared * squared) * place.area;
                        for (sum, value) in expected.iter_mut().zip(place.value.0) {
                            *sum += value * part;
                        }
                    }
                }
                let (value, error) = found[texel];
                for c in 0..3 {
                    // The oracle's pieces cross jumps of the texture, 1/240 of a side wide, and it ends sharply
                    // at a ball's horizon.
                    let off = (value.0[c] - expected[c]).abs();
                    assert!(
                        off <= 3.29 * error.0[c] + 5e-3 * expected[c],
                        "{kind}, {name}, {texel}: {value:?} for {expected:?}, error {error:?}"
                    );
                    // Of 4096 samples, whose places on a ball are even: each is off by some of itself, their mean by
                    // 1/64 of that. Boards have pieces with bright and dark squares.
                    let most = match (kind, name) {
                        (_, "boards") => 6e-2,
                        ("sphere", _) => 2e-2,
                        _ => 1e-2,
                    };
                    let relative = error.0[c] / value.0[c];
                    assert!(relative <= most, "{kind}, {name}: {relative}");
                }
            }
        }
    }
}

#[test]
fn photons_through_a_clear_pane_are_direct_light() {
    for plugin in ["area", "directionalarea"] {
        for (kind, transform) in SHAPES {
            for (name, texture) in textures() {
                let light = lamp(plugin, kind, transform, &texture);
                let expected = directly(&scene(&light), 8192);
                let found = by_photons(&scene(&format!("{light}{CLEAR}")), 1 << 17);
                let layer = &found.total;
                let all = layer.values.iter().zip(&layer.standard_error).zip(expected);
                for ((value, error), (expected, other)) in all {
                    for c in 0..3 {
                        // Student's t of 15 degrees is beyond 6 once in 40,000; corners of light may get no photon.
                        let bound = 6.0 * (error.0[c] + other.0[c]) + 5e-3;
                        assert!(
                            (value.0[c] - expected.0[c]).abs() <= bound,
                            "{plugin}, {kind}, {name}: {value:?} {expected:?} {error:?} {other:?}"
                        );
                    }
                }
                let sum = |values: &[Rgb]| values.iter().map(|it| it.mean()).sum::<f64>();
                let relative = sum(&layer.standard_error) / sum(&layer.values);
                assert!(relative < 0.08, "{plugin}, {kind}, {name}: {relative}");
            }
        }
    }
}

#[test]
fn cells_have_all_of_a_lamps_flux() {
    let around = CLEAR.replace("rectangle", "cube").replace("0.25", "0");
    for (plugin, factor) in [("area", 0.5 * TAU), ("directionalarea", 1.0)] {
        for (kind, transform) in [SHAPES[0], SHAPES[2]] {
            for (name, texture) in textures() {
                let scene = scene(&format!(
                    "{}{around}",
                    lamp(plugin, kind, transform, &texture)
                ));
                let light = LightSpace::new(&scene).unwrap();
                let mut whole = Rgb::BLACK;
                for chart in light.charts() {
                    whole += chart.flux_bound(&light.root(chart));
                }
                // The square around the disc of directions.
                let share = if plugin == "area" { factor / 4.0 } else { 1.0 };
                let expected = flux(&places(&scene, 600));
                let mut by_cells = Rgb::BLACK;
                for cell in light.cells() {
                    by_cells += light.charts()[cell.chart()].flux_bound(cell.patch());
                }
                for c in 0..3 {
                    let (found, expected) = (whole.0[c] * share, expected[c] * factor);
                    // Midpoints of 600² pieces cross the jumps of a texture.
                    assert!(
                        (found - expected).abs() <= 3e-3 * expected,
                        "{plugin}, {kind}, {name}: {found} for {expected}"
                    );
                    let of_cells = by_cells.0[c] / whole.0[c];
                    if plugin == "directionalarea" {
                        assert!(
                            (of_cells - 1.0).abs() <= 1e-12,
                            "{kind}, {name}: {of_cells}"
                        );
                    } else {
                        // All of the disc's directions, and little of the square's corners.
                        let disc = TAU / 8.0;
                        assert!(
                            of_cells >= disc && of_cells <= 1.25 * disc,
                            "{kind}, {name}: {of_cells}"
                        );
                    }
                    if kind == "rectangle" && (name == "nearest" || name == "bilinear") {
                        // Of a blend that repeats, too: its weights sum to 1 over the square.
                        let texels =
                            (0..15).map(|index| texel(index % SIZE[0], index / SIZE[0])[c]);
                        let exact = texels.sum::<f64>() / 15.0 * 4.0 * 0.5 * 0.3 * factor;
                        assert!(
                            (found - exact).abs() <= 1e-12 * exact,
                            "{plugin}, {name}: {found}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_texture_of_one_value_makes_an_even_lamp() {
    let even = "<rgb name=\"radiance\" value=\"0.5, 0.5, 0.5\"/>";
    let board = |other: &str| {
        format!(
            "<texture name=\"radiance\" type=\"checkerboard\"><rgb name=\"color0\" value=\"0.5, 0.5, 0.5\"/>\
             <rgb name=\"color1\" value=\"{other}, {other}, {other}\"/></texture>"
        )
    };
    for plugin in ["area", "directionalarea"] {
        for (kind, transform) in SHAPES {
            let of = |radiance: &str| {
                let scene = scene(&format!(
                    "{}{BALL}",
                    lamp(plugin, kind, transform, radiance)
                ));
                by_photons(&scene, 1 << 14)
            };
            let (a, b, close) = (of(even), of(&board("0.5")), of(&board("0.500000001")));
            for texel in 0..SIDE * SIDE {
                let [x, y, z] = [&a, &b, &close].map(|it| it.total.values[texel]);
                let [p, q] = [&a, &close].map(|it| it.total.standard_error[texel]);
                for c in 0..3 {
                    assert!(
                        (x.0[c] - y.0[c]).abs() <= 1e-12 * x.0[c],
                        "{plugin}, {kind}: {x:?} {y:?}"
                    );
                    // No shortcut here: other points, chosen piece by piece.
                    assert!(
                        (x.0[c] - z.0[c]).abs() <= 6.0 * p.0[c].hypot(q.0[c]) + 1e-3 * x.0[c],
                        "{plugin}, {kind}, {texel}: {x:?} {z:?} {p:?} {q:?}"
                    );
                }
            }
            let [x, z] = [&a, &close].map(|it| it.ledger.emitted.0[1]);
            assert!((x - z).abs() <= 1e-8 * x, "{plugin}, {kind}: {x} {z}");
        }
    }
}

#[test]
fn a_bright_spot_that_samples_miss_is_in_the_bar() {
    let spot = picture(NEAREST).replace("picture.exr", "spot.exr");
    let (_, transform) = SHAPES[1];
    for plugin in ["area", "directionalarea"] {
        for kind in ["rectangle", "disk"] {
            // So fine on the rectangle that each piece has many spots.
            let fine = "<transform name=\"to_uv\"><scale value=\"30\"/></transform></texture>";
            let texture = match kind {
                "disk" => spot.clone(),
                _ => spot.replace("</texture>", fine),
            };
            let light = lamp(plugin, kind, transform, &texture);
            let few = directly(&scene(&light), 128);
            let many = directly(&scene(&light), 1 << 19);
            for ((value, error), (truth, other)) in few.iter().zip(&many) {
                // Bars are 3.29 standard errors.
                let off = (value.0[0] - truth.0[0]).abs();
                assert!(
                    off <= 3.29 * (error.0[0] + other.0[0]),
                    "{plugin}, {kind}: {value:?} {error:?} {truth:?}"
                );
            }
            let unsure = few.iter().filter(|(_, error)| error.0[0] > 0.0).count();
            assert!(unsure > 4, "{plugin}, {kind}: {unsure}");
        }
    }
}

#[test]
fn light_below_zero_is_refused_by_name() {
    let lamp = |name: &str| {
        format!(
            "<shape type=\"ply\" id=\"it\"><string name=\"filename\" value=\"{name}.ply\"/>\
             <emitter type=\"area\"><texture name=\"radiance\" type=\"mesh_attribute\">\
             <string name=\"name\" value=\"vertex_color\"/></texture></emitter></shape>"
        )
    };
    load(&lamp("good")).unwrap();
    let message = load(&lamp("negative")).unwrap_err();
    assert!(
        message.contains("vertex_color") && message.contains(">= 0") && message.contains("\"it\""),
        "{message}"
    );
    load(&lamp("nan")).unwrap_err();
    let missing = lamp("good").replace("vertex_color", "vertex_heat");
    let message = load(&missing).unwrap_err();
    assert!(message.contains("vertex_heat"), "{message}");
}

#[test]
fn a_lamp_of_two_halves_is_the_sum_of_two_lamps() {
    // Halves by u: a board of one square by two, whose second colour is on the right.
    let board = "<texture name=\"radiance\" type=\"checkerboard\"><rgb name=\"color0\" value=\"0.9, 0.2, 0.1\"/>\
        <rgb name=\"color1\" value=\"0.1, 0.3, 0.5\"/><transform name=\"to_uv\"><scale x=\"1\" y=\"0.5\"/></transform></texture>";
    let down = "<rotate x=\"1\" angle=\"180\"/><translate z=\"1.5\"/>";
    let whole = lamp(
        "area",
        "rectangle",
        &format!("<scale x=\"0.5\" y=\"0.3\"/>{down}"),
        board,
    );
    let half = |at: f64, color: &str| {
        let transform = format!("<scale x=\"0.25\" y=\"0.3\"/><translate x=\"{at}\"/>{down}");
        let radiance = format!("<rgb name=\"radiance\" value=\"{color}\"/>");
        lamp("area", "rectangle", &transform, &radiance).replace(" id=\"lamp\"", "")
    };
    let both = half(-0.25, "0.9, 0.2, 0.1") + &half(0.25, "0.1, 0.3, 0.5");
    for more in ["", BALL] {
        let [a, b] = [&whole, &both]
            .map(|light| by_photons(&scene(&format!("{light}{more}")), 1 << 18).total);
        for texel in 0..SIDE * SIDE {
            let ([x, y], [p, q]) = (
                [&a, &b].map(|it| it.values[texel]),
                [&a, &b].map(|it| it.standard_error[texel]),
            );
            for c in 0..3 {
                let error = p.0[c].hypot(q.0[c]);
                // An even lamp's bar, by a rule instead of samples, may be 0.
                assert!(
                    (x.0[c] - y.0[c]).abs() <= 6.0 * error + 1e-3 * y.0[c],
                    "{texel}: {x:?} {y:?} {p:?} {q:?}"
                );
            }
        }
        let sum = |values: &[Rgb]| values.iter().map(|it| it.mean()).sum::<f64>();
        assert!(sum(&a.standard_error) <= 0.05 * sum(&a.values));
    }
}

#[test]
fn photons_start_with_the_lamps_flux() {
    let around = CLEAR.replace("rectangle", "cube").replace("0.25", "0");
    for (kind, transform) in SHAPES {
        for (name, texture) in textures() {
            let scene = scene(&format!(
                "{}{around}",
                lamp("area", kind, transform, &texture)
            ));
            let expected = flux(&places(&scene, 400));
            let emitted = by_photons(&scene, 1 << 16).ledger.emitted;
            for c in 0..3 {
                // The noise of 2¹⁶ weights that differ by about their mean, in points that cover the lamp evenly:
                // 1/256 at most, and 6 of it.
                let expected = expected[c] * 0.5 * TAU;
                let off = (emitted.0[c] - expected).abs();
                assert!(
                    off <= 0.024 * expected,
                    "{kind}, {name}: {emitted:?} for {expected}"
                );
            }
        }
    }
}

#[test]
fn textured_lamps_give_the_same_bits_on_any_number_of_threads() {
    let light = lamp("area", "rectangle", SHAPES[0].1, &picture(""));
    let scene = scene(&format!("{light}{BALL}"));
    paths::assert_same_on_threads(&[2, 5], || by_photons(&scene, 1 << 14));
}
