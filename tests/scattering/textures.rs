//! Textures are Mitsuba's, point by point.
//!
//! The numbers are those of Mitsuba 3.9.1, `scalar_rgb`, written by `tests/mitsuba/texture_oracle.py`.

use glam::{DVec2, DVec3};
use nephroid::internals::film::{Image, exr};
use nephroid::internals::geometry::Ray;
use nephroid::internals::mitsuba::load;
use nephroid::internals::scene::{TextureId, TexturePoint};

use crate::support::bsdf::{Surface, folder, scene};

/// Relative to the values, which are of order 1: f32 arithmetic in uv and interpolation, the gradient times
/// the image's size.
const TOLERANCE: f64 = 4e-6;

/// One texture and what Mitsuba says of it.
struct Case {
    xml: String,
    /// u v, r g b, slope along u and v (or none).
    points: Vec<Vec<f64>>,
}

fn cases() -> Vec<Case> {
    let text = std::fs::read_to_string(folder().join("texture_oracle.txt")).unwrap();
    let mut cases: Vec<Case> = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        if let Some(xml) = line.strip_prefix("case ") {
            cases.push(Case {
                xml: xml.to_owned(),
                points: Vec::new(),
            });
        } else {
            let numbers = line.split(' ').map(|number| number.parse().unwrap());
            cases.last_mut().unwrap().points.push(numbers.collect());
        }
    }
    cases
}

#[test]
fn every_texture_is_mitsubas_at_every_point() {
    let mut compared = 0;
    for case in cases() {
        let scene = scene(&format!(
            "<shape type=\"rectangle\"><bsdf type=\"diffuse\">{}</bsdf></shape>",
            case.xml
        ));
        for point in &case.points {
            let at = TexturePoint {
                uv: DVec2::new(point[0], point[1]),
                mesh: None,
            };
            let value = scene.texture_value(TextureId(0), &at);
            for c in 0..3 {
                let error = (value.0[c] - point[2 + c]).abs();
                assert!(error <= TOLERANCE, "{}\n{point:?}: {value:?}", case.xml);
            }
            if let [x, y] = point[5..] {
                let slope = scene.texture_gradient(TextureId(0), &at);
                let error = (slope - DVec2::new(x, y)).abs().max_element();
                // Twelve texels of a factor up to 3 in to_uv.
                assert!(
                    error <= 36.0 * TOLERANCE,
                    "{}\n{point:?}: {slope}",
                    case.xml
                );
            }
            compared += 1;
        }
    }
    assert!(compared > 150, "{compared}");
}

#[test]
fn images_that_are_no_fractions_of_light_are_errors_or_warnings() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("scene.xml");
    let texture = "<texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"a.exr\"/></texture>";
    let xml = format!(
        "<scene version=\"3.0.0\"><shape type=\"sphere\"><bsdf type=\"diffuse\">{texture}</bsdf></shape></scene>"
    );
    std::fs::write(&path, xml).unwrap();
    let load_with = |texel: f64| {
        let mut image = Image::new(1, 1);
        image.add_rgb("", &[[0.5, texel, 0.5]]);
        exr::write(&folder.path().join("a.exr"), &image).unwrap();
        load(&path, &[])
    };
    assert!(load_with(0.75).unwrap().warnings().is_empty());
    let bright = load_with(1.5).unwrap();
    assert!(bright.warnings()[0].message.contains("holds 1.5"));
    for (wrong, expected) in [
        (
            -0.25,
            "holds -0.25, but a fraction of light must not be negative",
        ),
        (f64::NAN, "column 0, row 0 (counted from 0) is not finite"),
        (
            f64::INFINITY,
            "column 0, row 0 (counted from 0) is not finite",
        ),
    ] {
        let message = load_with(wrong).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    std::fs::write(folder.path().join("a.exr"), "no image").unwrap();
    let message = load(&path, &[]).unwrap_err().to_string();
    assert!(
        message.contains("texture \"bitmap\"") && message.contains("a.exr"),
        "{message}"
    );
}

/// A triangle in the plane z = 0 and what a ray straight down meets at x, y.
fn triangle(ply: &str, bsdf: &str, x: f64, y: f64) -> Surface {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("a.ply");
    std::fs::write(&path, ply).unwrap();
    let shape = format!(
        "<shape type=\"ply\"><string name=\"filename\" value=\"{}\"/>{bsdf}</shape>",
        path.display()
    );
    Surface::of(&shape, Ray::new(DVec3::new(x, y, 1.0), -DVec3::Z))
}

fn attribute(name: &str) -> String {
    format!(
        "<bsdf type=\"diffuse\"><texture type=\"mesh_attribute\" name=\"reflectance\">\
         <string name=\"name\" value=\"{name}\"/></texture></bsdf>"
    )
}

#[test]
fn colours_of_vertices_are_interpolated_and_those_of_faces_are_not() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
               property float r\nproperty float g\nproperty float b\nelement face 1\n\
               property list uchar int vertex_indices\nproperty float red\nproperty float green\nproperty float blue\n\
               end_header\n0 0 0 1 0 0\n1 0 0 0 1 0\n1 1 0 0 0 1\n0 1 0 1 0 0\n4 0 1 2 3 0.25 0.5 0.75\n";
    for (x, y) in [(0.5, 0.25), (0.25, 0.5)] {
        let albedo = |name: &str| {
            let surface = triangle(ply, &attribute(name), x, y);
            let at = TexturePoint::new(&surface.scene, &surface.hit, &surface.point);
            surface.scene.texture_value(TextureId(0), &at).0
        };
        // The fan's first triangle holds (0.5, 0.25): weights 1 - x, x - y, y.
        if y < x {
            assert_eq!(albedo("vertex_color"), [0.5, 0.25, 0.25]);
        }
        // Both triangles of a polygon have its colour.
        assert_eq!(albedo("face_color"), [0.25, 0.5, 0.75]);
    }
}

#[test]
fn attributes_of_any_name_are_looked_up() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float heat_0\nproperty float x\nproperty float y\n\
               property float z\nproperty float tint_x\nproperty float tint_y\nproperty float tint_z\nelement face 1\n\
               property uchar flags\nproperty float glow_1\nproperty list uchar int vertex_indices\nend_header\n\
               0.5 0 0 0 1 0 0\n0.25 1 0 0 0 1 0\n0.75 0 1 0 0 0 1\n9 0.125 3 0 1 2\n";
    // The weights of the corners at (1/2, 1/4) are 1/4, 1/2 and 1/4.
    for (name, value) in [
        ("vertex_heat", [0.4375; 3]),
        ("vertex_tint", [0.25, 0.5, 0.25]),
        ("face_glow", [0.125; 3]),
    ] {
        let surface = triangle(ply, &attribute(name), 0.5, 0.25);
        let at = TexturePoint::new(&surface.scene, &surface.hit, &surface.point);
        assert_eq!(
            surface.scene.texture_value(TextureId(0), &at).0,
            value,
            "{name}"
        );
    }
}

/// On each shape, the derivatives of the position are what finite differences of `at_uv` say; on a mesh
/// those of the face, and a closed form.
#[test]
fn tangents_are_the_derivatives_of_the_position() {
    let to_world = "<transform name=\"to_world\"><scale value=\"1.5\"/><rotate x=\"0.6\" y=\"0.8\" angle=\"40\"/>\
                    <translate x=\"0.2\" y=\"0.1\"/></transform>";
    for shape in ["sphere", "rectangle", "disk", "cylinder"] {
        let scene = scene(&format!("<shape type=\"{shape}\">{to_world}</shape>"));
        let shape = &scene.world().shapes()[0];
        let mut met = 0;
        for (x, y) in [(0.3, 0.2), (0.5, 0.4), (0.1, 0.45), (0.9, 0.1), (-0.4, 0.2)] {
            let ray = Ray::new(DVec3::new(x, y, 5.0), -DVec3::Z);
            let world = scene.world();
            let Some(hit) = world.closest_hit(&ray, f64::INFINITY, &mut Default::default()) else {
                continue;
            };
            met += 1;
            let point = world.surface_point(&ray, &hit);
            let [dp_du, dp_dv] = world.tangents(&hit, &point);
            let (uv, step) = (point.uv, 1e-6);
            for (found, along) in [(dp_du, DVec2::X), (dp_dv, DVec2::Y)] {
                let at = |sign: f64| shape.at_uv(uv + along * (sign * step)).unwrap().position;
                let expected = (at(1.0) - at(-1.0)) / (2.0 * step);
                // Rounding over the step, and the third derivative (2π)³ times step²/6 and a radius.
                let tolerance = 10.0 * f64::EPSILON / step + 100.0 * step * step;
                assert!(found.abs_diff_eq(expected, tolerance), "{found} {expected}");
            }
        }
        assert!(met >= 2);
    }
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0 0 0\n2 0 0 0.5 0.25\n0 2 0 0 1\n3 0 1 2\n";
    let surface = triangle(ply, "", 0.5, 0.5);
    let [dp_du, dp_dv] = surface.scene.world().tangents(&surface.hit, &surface.point);
    // (u, v) = (x/4, x/8 + y/2), so (x, y) = (4u, 2v - u).
    assert!(
        dp_du.abs_diff_eq(DVec3::new(4.0, -1.0, 0.0), 1e-14),
        "{dp_du}"
    );
    assert!(
        dp_dv.abs_diff_eq(DVec3::new(0.0, 2.0, 0.0), 1e-14),
        "{dp_dv}"
    );
}
