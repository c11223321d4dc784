//! Maps (u, v) that cannot carry texels, and those that nearly cannot.

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Mesh, MeshParts, Shape};

use super::scenes::{ROUNDING, film, mesh, receiver, refusal, scene};

#[test]
fn a_uv_map_that_cannot_carry_texels_is_refused_with_its_shape() {
    let flat = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let positions = flat.map(|(x, y)| DVec3::new(x, y, 0.0));
    let faces = [[0, 1, 2], [0, 2, 3]];
    let with = |uvs: [(f64, f64); 4]| {
        refusal(mesh(
            &positions,
            &uvs.map(|(u, v)| DVec2::new(u, v)),
            &faces,
        ))
    };
    let who = "sensor \"meter\" measures shape \"sheet\" (ply), which has ";

    let tiled = with([(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)]);
    assert_eq!(
        tiled,
        format!(
            "{who}(u, v) = (3, 0) at a corner of face 0 (counted from 0): allowed on a receiver are 0 \
             to 1, without repetition"
        )
    );
    let folded = with([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1.0, 0.2)]);
    assert_eq!(
        folded,
        format!(
            "{who}faces 0 and 1 (counted from 0) on the same (u, v): on a receiver each (u, v) may lie \
             on one face only"
        )
    );
    let line = with([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.5)]);
    assert!(
        line.starts_with(&format!("{who}faces whose (u, v) are a line or a point; ")),
        "{line}"
    );
    let none = Mesh::new(MeshParts {
        positions: positions.to_vec(),
        triangles: faces.to_vec(),
        ..MeshParts::default()
    });
    assert!(refusal(none.unwrap()).starts_with(&format!("{who}no texture coordinates: ")));
}

#[test]
fn uvs_off_by_the_rounding_of_a_file_are_taken() {
    // Six digits, or f32: the border texels hold what lies a hair beyond.
    let flat = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let positions = flat.map(|(x, y)| DVec3::new(x, y, 0.0));
    let uvs = flat.map(|(x, y): (f64, f64)| DVec2::new(x * 1.000_000_5, y - 1e-7));
    let mesh = mesh(&positions, &uvs, &[[0, 1, 2], [0, 2, 3]]);
    let scene = scene(Shape::Mesh(mesh), film(4, 4), Vec::new());
    let receiver = receiver(&scene);
    let sum: f64 = (0..16).map(|texel| receiver.texel_area(texel)).sum();
    assert!((sum - 1.0).abs() < ROUNDING, "{sum}");
}
