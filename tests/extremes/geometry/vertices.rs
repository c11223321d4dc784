//! Vertices whose normals have no length or are opposed, and whose numbers are not finite.

use flate2::Compression;
use glam::DVec3;
use nephroid::internals::geometry::MeshParts;
use nephroid::internals::optics::dielectric_reflectance;

use super::runs::{IOR, assert_share, cube, load, met, photons, received, row, says};
use crate::support::geometry::icosphere;
use crate::support::mutation::{obj, ply, serialized, serialized_contents};

#[test]
fn normals_of_no_length_are_those_of_the_faces_and_opposed_ones_absorb() {
    let with_normals = |normal: DVec3| {
        let mut mesh = cube();
        mesh.normals = Some(vec![normal; mesh.positions.len()]);
        let scene = load("block.ply", &ply(&mesh, "ascii"), "", -DVec3::Z).unwrap();
        (photons(&scene), scene)
    };
    let passes = 1.0 - dielectric_reflectance(1.0, IOR);
    let (flat, _) = with_normals(DVec3::ZERO);
    assert_share(received(&flat, "LTTD"), passes * passes, "no length");
    // Light from above meets the upper side, whose normals say that it comes from below.
    let (opposed, scene) = with_normals(-DVec3::Z);
    assert!(
        says(
            &scene,
            "2 faces whose vertex normals point to the other side"
        ),
        "{:?}",
        scene.warnings()
    );
    assert_share(
        row(&opposed, "LD").absorbed.mean() / met(&opposed),
        1.0,
        "opposed",
    );
}

/// The file formats of meshes: the name of a file, how it is written, and whether errors name the vertex or
/// the line.
type Format = (&'static str, fn(&MeshParts) -> Vec<u8>, bool);

const FORMATS: [Format; 5] = [
    ("it.obj", |mesh| obj(mesh), false),
    ("it.ply", |mesh| ply(mesh, "ascii"), true),
    ("it.ply", |mesh| ply(mesh, "binary_little_endian"), true),
    ("it.ply", |mesh| ply(mesh, "binary_big_endian"), true),
    (
        "it.serialized",
        |mesh| serialized(&serialized_contents(mesh), Compression::fast()),
        true,
    ),
];

#[test]
fn numbers_that_are_not_finite_are_refused_by_the_number_of_their_vertex() {
    let mut sound = icosphere(0);
    let count = sound.positions.len();
    sound.normals = Some(sound.positions.clone());
    sound.uvs = Some(sound.positions.iter().map(|p| p.truncate()).collect());
    let mut refused = 0;
    for (name, written, names_vertex) in FORMATS {
        // What is refused below is refused for its one number alone.
        load(name, &written(&sound), "", -DVec3::Z).unwrap();
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for vertex in [0, 7, count - 1] {
                // x, y, z of the position, then of the normal, then u and v.
                for slot in 0..8 {
                    let mut mesh = sound.clone();
                    let normals = mesh.normals.as_mut().unwrap();
                    let uvs = mesh.uvs.as_mut().unwrap();
                    let line = match slot {
                        0..3 => {
                            mesh.positions[vertex][slot] = value;
                            vertex
                        }
                        3..6 => {
                            normals[vertex][slot - 3] = value;
                            count + vertex
                        }
                        _ => {
                            uvs[vertex][slot - 6] = value;
                            2 * count + vertex
                        }
                    } + 1;
                    let error = load(name, &written(&mesh), "", -DVec3::Z).unwrap_err();
                    let place = if names_vertex {
                        format!("vertex {vertex} ")
                    } else {
                        format!("line {line}: ")
                    };
                    assert!(
                        error.contains(&place) && error.contains("finite"),
                        "{name}, number {slot} of vertex {vertex} is {value}: {error}"
                    );
                    refused += 1;
                }
            }
        }
    }
    println!("{refused} files refused by the place of their number");
    // Finite in the file, and beyond what can be multiplied where it is placed.
    let mut mesh = icosphere(0);
    mesh.positions[7].y = 1e60;
    let far = r#"<transform name="to_world"><scale value="1e20"/></transform>"#;
    let error = load("it.obj", &obj(&mesh), far, -DVec3::Z).unwrap_err();
    assert!(error.contains("vertex") && error.contains("e80"), "{error}");
}
