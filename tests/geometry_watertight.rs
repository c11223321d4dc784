//! No ray is lost, and the search finds what trying everything finds.

mod geometry_support;

use geometry_support::{BruteForce, Random, bumpy_torus, closest, icosphere, placed, world_of};
use glam::DVec3;
use nephroid::geometry::{MeshParts, Ray, World};

/// A point on a vertex or an edge of a random face: where a test that is not watertight leaks.
fn delicate_point(parts: &MeshParts, random: &mut Random) -> DVec3 {
    let triangle = parts.triangles[random.below(parts.triangles.len())];
    let first = random.below(3);
    let [a, b] = [first, (first + 1) % 3].map(|i| parts.positions[triangle[i] as usize]);
    match random.below(3) {
        0 => a,
        1 => a + (b - a) * 0.5,
        _ => a + (b - a) * random.unit(),
    }
}

/// Rays from inside a ball towards its vertices and edges, of which none may get out.
fn leaks(parts: &MeshParts, world: &World, rays: usize, origin: impl Fn(DVec3) -> DVec3) -> usize {
    let mut random = Random(7);
    (0..rays)
        .filter(|_| {
            let start = origin(random.in_cube() * 0.5);
            let Some(direction) = (delicate_point(parts, &mut random) - start).try_normalize()
            else {
                return false;
            };
            closest(world, &Ray::new(start, direction)).is_none()
        })
        .count()
}

#[test]
fn no_ray_aimed_at_vertices_and_edges_leaves_a_closed_ball() {
    for (scale, offset) in [
        (1.0, DVec3::ZERO),
        (1e-6, DVec3::ZERO),
        (1e6, DVec3::ZERO),
        (1.0, DVec3::new(1048576.0, -524288.0, 3.0)),
    ] {
        let parts = placed(icosphere(4), scale, offset);
        let world = world_of(parts.clone());
        assert_eq!(
            leaks(&parts, &world, 100_000, |p| offset + scale * p),
            0,
            "scale {scale:e}, offset {offset}"
        );
    }
}

#[test]
fn the_tree_finds_what_trying_every_face_finds() {
    for parts in [bumpy_torus(40, 20), icosphere(3)] {
        let world = world_of(parts.clone());
        let brute_force = BruteForce::new(&parts);
        let mut random = Random(11);
        for i in 0..4000 {
            let origin = random.in_cube() * if i % 2 == 0 { 1.0 } else { 4.0 };
            let target = if i % 3 == 0 {
                random.in_cube()
            } else {
                delicate_point(&parts, &mut random)
            };
            let ray = Ray::new(origin, (target - origin).normalize());
            assert_eq!(closest(&world, &ray), brute_force.closest(&ray), "{ray:?}");
        }
    }
}
