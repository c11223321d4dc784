//! Scanned and modelled meshes, where there are any beside the crate (they are not part of it).

mod geometry_support;

use std::{fs, path::PathBuf};

use geometry_support::{Random, closest, mesh, world_of};
use glam::DVec3;
use nephroid::geometry::{MeshParts, Ray};

/// The binary PLY file of this name, or `None` (said aloud) where there is none.
///
/// Only what these files hold: `float x y z`, then faces as `uchar` and three `int`s.
fn shared(name: &str) -> Option<MeshParts> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/meshes")
        .join(name);
    let Ok(bytes) = fs::read(&path) else {
        println!("skipped {name}: no such file in ../shared/meshes");
        return None;
    };
    let end = bytes.windows(11).position(|w| w == b"end_header\n")? + 11;
    let header = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let count = |element: &str| -> usize {
        let line = header.lines().find(|line| line.starts_with(element));
        line.and_then(|line| line.rsplit(' ').next()?.parse().ok())
            .expect("a count")
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let positions = (0..vertices)
        .map(|i| {
            let x = |axis: usize| f64::from(f32::from_le_bytes(word(end + 12 * i + 4 * axis)));
            DVec3::new(x(0), x(1), x(2))
        })
        .collect();
    let first = end + 12 * vertices;
    let triangles = (0..faces)
        .map(|i| std::array::from_fn(|k| u32::from_le_bytes(word(first + 13 * i + 1 + 4 * k))))
        .collect();
    Some(MeshParts {
        positions,
        triangles,
        ..MeshParts::default()
    })
}

/// Closed, and without faces that cut each other, by the folder's own table.
const CLOSED: [&str; 10] = [
    "bunny_69k.ply",
    "dragon_41k.ply",
    "gargoyle_20k.ply",
    "gem_round_brilliant.ply",
    "gem_heart.ply",
    "teapot_60k_solid.ply",
    "torus_17k.ply",
    "glass_cup_44k.ply",
    "nefertiti_100k.ply",
    "fertility_20k.ply",
];

#[test]
fn closed_meshes_are_found_closed_and_outward() {
    for name in CLOSED {
        let Some(parts) = shared(name) else { continue };
        let found = mesh(parts).diagnose();
        assert!(found.is_closed() && !found.is_inward(), "{name}: {found}");
    }
}

#[test]
fn open_and_non_manifold_meshes_are_found_out() {
    for (name, open, non_manifold) in [
        ("bunny_69k_open_scan.ply", 223, 0),
        ("dragon_48k_nonmanifold.ply", 0, 2094),
        ("buddha_100k_asis.ply", 0, 50),
        ("suzanne_base.ply", 42, 1),
        ("water_pool_4k.ply", 166, 0),
    ] {
        let Some(parts) = shared(name) else { continue };
        let found = mesh(parts).diagnose();
        assert_eq!(found.open_edges.count, open, "{name}: {found}");
        assert_eq!(
            found.non_manifold_edges.count, non_manifold,
            "{name}: {found}"
        );
    }
}

#[test]
fn no_ray_from_within_a_closed_mesh_gets_out_by_its_vertices_and_edges() {
    for name in CLOSED {
        let Some(parts) = shared(name) else { continue };
        let world = world_of(parts.clone());
        let mut random = Random(17);
        let corner = |face: usize, k: usize| parts.positions[parts.triangles[face][k % 3] as usize];
        for _ in 0..30_000 {
            // Just inside of the middle of a face ...
            let face = random.below(parts.triangles.len());
            let [a, b, c] = [0, 1, 2].map(|k| corner(face, k));
            let Some(normal) = (b - a).cross(c - a).try_normalize() else {
                continue;
            };
            let reach = world.bounds().radius();
            let onto = Ray::new((a + b + c) / 3.0 + normal * (1e-6 * reach), -normal);
            let Some(hit) = closest(&world, &onto).filter(|hit| hit.face as usize == face) else {
                continue; // another face is nearer than a millionth of the mesh
            };
            let inside = world.surface_point(&onto, &hit).spawn(-normal).origin;
            // ... to a vertex, or to a point of an edge.
            let (face, k) = (random.below(parts.triangles.len()), random.below(3));
            let along = if random.below(2) == 0 {
                0.0
            } else {
                random.unit()
            };
            let target = corner(face, k) + (corner(face, k + 1) - corner(face, k)) * along;
            let ray = Ray::new(inside, (target - inside).normalize());
            assert!(closest(&world, &ray).is_some(), "{name}: {ray:?} got out");
        }
    }
}
