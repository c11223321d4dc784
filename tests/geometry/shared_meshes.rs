//! Scanned and modelled meshes are found closed or open as they are, and keep their rays in; skipped where
//! there are none beside the crate.

use nephroid::internals::geometry::Ray;

use crate::support::geometry::{Random, closest, mesh, world_of};
use crate::support::shared_meshes::shared_mesh;

/// Closed, and without faces that cut each other, by the folder's own table.
const CLOSED: [&str; 10] = [
    "bunny_69k",
    "dragon_41k",
    "gargoyle_20k",
    "gem_round_brilliant",
    "gem_heart",
    "teapot_60k_solid",
    "torus_17k",
    "glass_cup_44k",
    "nefertiti_100k",
    "fertility_20k",
];

#[test]
fn closed_meshes_are_found_closed_and_outward() {
    for name in CLOSED {
        let Some(parts) = shared_mesh(name) else {
            continue;
        };
        let mesh = mesh(parts);
        let found = mesh.diagnose();
        assert!(found.is_closed() && !found.is_inward(), "{name}: {found}");
    }
}

#[test]
fn open_and_non_manifold_meshes_are_found_out() {
    for (name, open, non_manifold) in [
        ("bunny_69k_open_scan", 223, 0),
        ("dragon_48k_nonmanifold", 0, 2094),
        ("buddha_100k_asis", 0, 50),
        ("suzanne_base", 42, 1),
        ("water_pool_4k", 166, 0),
    ] {
        let Some(parts) = shared_mesh(name) else {
            continue;
        };
        let mesh = mesh(parts);
        let found = mesh.diagnose();
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
        let Some(parts) = shared_mesh(name) else {
            continue;
        };
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
