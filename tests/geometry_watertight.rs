//! No ray is lost between the triangles of a closed mesh.
//!
//! That the search finds the very hit that trying every face finds is tested beside it, in
//! `src/geometry/mesh_tree.rs`.

mod geometry_support;

use geometry_support::{Random, bumpy_torus, closest, icosphere, placed, world_of};
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

/// Takes minutes: `cargo test --release --test geometry_watertight -- --ignored`.
#[test]
#[ignore = "ten million rays"]
fn no_ray_of_ten_million_leaves_a_closed_ball() {
    let parts = icosphere(6);
    let world = world_of(parts.clone());
    assert_eq!(leaks(&parts, &world, 10_000_000, |p| p), 0);
}

#[test]
fn a_bumpy_solid_keeps_its_rays() {
    let parts = bumpy_torus(120, 60);
    let world = world_of(parts.clone());
    // Within the solid: its core is a circle, and the tube is at least 0.27 thick.
    let inside = |p: DVec3| p.with_z(0.0).normalize_or(DVec3::X) + 0.5 * p;
    assert_eq!(leaks(&parts, &world, 300_000, |p| inside(p * 0.5)), 0);
}

/// Whole numbers below 2^53 have exact images and products of 106 bits: the sign of an edge function is known from integers, where
/// its two products often round to the same double.
#[test]
fn an_edge_beside_the_ray_is_told_from_one_through_it_to_the_last_bit() {
    let mut random = Random(43);
    let reach = 2f64.powi(52);
    let (mut ties, mut hits, mut misses) = (0, 0, 0);
    while ties < 2000 {
        // p and q in about opposite directions from the ray, which is the z axis; r to the left of the line from p to q.
        let [x, y] = [(); 2].map(|()| (reach * random.signed()).round());
        let stretch = 0.5 + 0.4 * random.unit();
        let p = DVec3::new(x, y, 0.0);
        let q = (-p * stretch).round();
        let r = DVec3::new(-(q.y - p.y), q.x - p.x, 0.0);
        let [px, py, qx, qy] = [p.x, p.y, q.x, q.y].map(|value| value as i128);
        let is_left = px * qy - py * qx;
        let is_tie = p.x * q.y == p.y * q.x;
        if p.length() < 1.0 || !is_tie {
            continue;
        }
        ties += 1;
        let world = world_of(MeshParts {
            positions: vec![p, q, r],
            triangles: vec![[0, 1, 2]],
            ..MeshParts::default()
        });
        let ray = Ray::new(DVec3::new(0.0, 0.0, -reach), DVec3::Z);
        // The border counts.
        let expected = is_left >= 0;
        let met = closest(&world, &ray).is_some();
        assert_eq!(met, expected, "{p} {q} {r}: {is_left}");
        *(if met { &mut hits } else { &mut misses }) += 1;
    }
    println!("{hits} rays within, {misses} beside edges whose products round to the same");
    assert!(hits > 500 && misses > 500, "{hits} {misses}");
}
