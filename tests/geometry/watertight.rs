//! No ray is lost between the triangles of a closed mesh.
//!
//! That the search finds the very hit that trying every face finds is tested beside it, in
//! `src/geometry/face_tree/mod.rs`.

use glam::DVec3;
use nephroid::internals::geometry::{MeshParts, Ray};

use crate::support::geometry::{
    Leaks, Random, bumpy_torus, closest, icosphere, leaks, placed, within_torus, world_of,
};

/// Rays from within a solid and from without towards its vertices and edges: none may get out, none in.
/// `inside`: the places within, from those of the cube [-1, 1]³; `seen`: how many of the points a ray from
/// without must meet first.
fn assert_that_nothing_leaks(
    solid: &MeshParts,
    rays: usize,
    seen: usize,
    inside: impl Fn(DVec3) -> DVec3,
) {
    for (scale, offset) in [
        (1.0, DVec3::ZERO),
        (1e-6, DVec3::ZERO),
        (1e6, DVec3::ZERO),
        (1.0, DVec3::new(1048576.0, -524288.0, 3.0)),
    ] {
        let parts = placed(solid.clone(), scale, offset);
        let world = world_of(parts.clone());
        let found = leaks(&parts, &world, (scale, offset), rays, &inside);
        println!("scale {scale:e}, offset {offset}: {found:?}");
        let none = Leaks {
            rays,
            seen: found.seen,
            ..Leaks::default()
        };
        assert_eq!(found, none, "scale {scale:e}, offset {offset}");
        assert!(found.seen >= seen, "{} points are met first", found.seen);
    }
}

#[test]
fn no_ray_aimed_at_vertices_and_edges_leaves_a_closed_ball_or_enters_it_unseen() {
    // All of a convex solid's surface is seen from without.
    assert_that_nothing_leaks(&icosphere(4), 50_000, 50_000, |p| 0.5 * p);
}

/// Takes minutes: `cargo test --release --test geometry watertight:: -- --ignored`.
#[test]
#[ignore = "ten million rays each way"]
fn no_ray_of_ten_million_leaves_a_closed_ball() {
    let parts = icosphere(6);
    let world = world_of(parts.clone());
    let rays = 10_000_000;
    let found = leaks(&parts, &world, (1.0, DVec3::ZERO), rays, |p| 0.5 * p);
    assert_eq!((found.out, found.into), (0, 0));
}

#[test]
fn a_bumpy_solid_keeps_its_rays_and_lets_none_in_unseen() {
    // The rest lies behind another part of it.
    assert_that_nothing_leaks(&bumpy_torus(120, 60), 50_000, 10_000, within_torus);
}

/// Whole numbers below 2^53 have exact images and products of 106 bits: the sign of an edge function is known
/// from integers, where its two products often round to the same double.
#[test]
fn an_edge_beside_the_ray_is_told_from_one_through_it_to_the_last_bit() {
    let mut random = Random(43);
    let reach = 2f64.powi(52);
    let (mut ties, mut hits, mut misses) = (0, 0, 0);
    while ties < 2000 {
        // p and q in about opposite directions from the ray, which is the z axis; r to the left of the line
        // from p to q.
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
