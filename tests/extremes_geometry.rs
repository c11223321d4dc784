//! Meshes at their worst, from the single ray to the whole run: what holds, and what is said where it cannot.
//!
//! `tests/geometry_*.rs` test the parts (hits, spawned rays, diagnostics); here a mesh file goes in and a map with its
//! ledger comes out.

mod geometry_support;

use std::sync::atomic::{AtomicU64, Ordering};

use geometry_support::{Random, closest, icosphere, placed, world_of};
use glam::DVec3;
use nephroid::geometry::{MeshParts, Ray, World};
use rayon::prelude::*;

/// A closed ball of slivers: meridians from pole to pole in bundles of `bundle`, 1e-8 rad apart, with one vertex each on the
/// equator. Length by width of a face: √2 / 1e-8 = 1.4e8.
fn sliver_ball(bundles: u32, bundle: u32) -> MeshParts {
    let mut positions = vec![DVec3::Z, -DVec3::Z];
    for i in 0..bundles {
        for j in 0..bundle {
            let longitude =
                std::f64::consts::TAU * f64::from(i) / f64::from(bundles) + 1e-8 * f64::from(j);
            positions.push(DVec3::new(longitude.cos(), longitude.sin(), 0.0));
        }
    }
    let around = bundles * bundle;
    let triangles = (0..around).flat_map(|k| {
        let (here, next) = (2 + k, 2 + (k + 1) % around);
        [[0, here, next], [1, next, here]]
    });
    MeshParts {
        triangles: triangles.collect(),
        positions,
        ..MeshParts::default()
    }
}

/// A ray from inside a convex solid, symmetric in x about the plane `x = middle`, to a place where a test that is not watertight leaks: a vertex, the
/// middle of an edge or any place on it; or parallel to x through a vertex, so that two coordinates agree to the bit and every edge function
/// of the vertex is exactly 0.
fn delicate_ray(parts: &MeshParts, (scale, middle): (f64, DVec3), random: &mut Random) -> Ray {
    loop {
        let triangle = parts.triangles[random.below(parts.triangles.len())];
        let first = random.below(3);
        let [a, b] = [first, (first + 1) % 3].map(|i| parts.positions[triangle[i] as usize]);
        let mut start = middle + random.in_cube() * (0.3 * scale);
        let target = match random.below(4) {
            0 => a,
            1 => a + (b - a) * 0.5,
            2 => a + (b - a) * random.unit(),
            _ => {
                start = DVec3::new(
                    middle.x + 0.9 * random.signed() * (a.x - middle.x),
                    a.y,
                    a.z,
                );
                a
            }
        };
        if let Some(direction) = (target - start).try_normalize() {
            return Ray::new(start, direction);
        }
    }
}

/// How many of the rays out of a solid meet nothing.
fn leaks(parts: &MeshParts, world: &World, place: (f64, DVec3), rays: u64) -> u64 {
    /// Rays of one thread at a time.
    const BATCH: u64 = 1 << 14;
    let lost = AtomicU64::new(0);
    (0..rays.div_ceil(BATCH)).into_par_iter().for_each(|batch| {
        let mut random = Random(batch);
        for _ in 0..BATCH.min(rays - batch * BATCH) {
            let ray = delicate_ray(parts, place, &mut random);
            if closest(world, &ray).is_none() {
                lost.fetch_add(1, Ordering::Relaxed);
            }
        }
    });
    lost.into_inner()
}

/// Aims `rays` at the vertices and edges of closed solids, slivers among them, over twelve decades of size; none may get out.
fn assert_that_nothing_leaks(rays: u64) {
    let places = [
        (1.0, DVec3::ZERO),
        (1e-6, DVec3::ZERO),
        (1e6, DVec3::ZERO),
        (1.0, DVec3::new(1048576.0, -524288.0, 3.0)),
    ];
    let solids = [icosphere(2), icosphere(4), sliver_ball(8, 16)];
    let share = rays / (places.len() * solids.len()) as u64;
    for solid in &solids {
        for place in places {
            let parts = placed(solid.clone(), place.0, place.1);
            let world = world_of(parts.clone());
            assert_eq!(
                leaks(&parts, &world, place, share),
                0,
                "{} faces, {place:?}",
                parts.triangles.len()
            );
        }
    }
}

#[test]
fn no_ray_of_a_million_aimed_at_vertices_and_edges_leaves_a_closed_mesh() {
    assert_that_nothing_leaks(1_200_000);
}

/// Takes ten minutes on two cores: `cargo test --release --test extremes_geometry a_billion -- --ignored`.
#[test]
#[ignore = "a billion rays"]
fn no_ray_of_a_billion_aimed_at_vertices_and_edges_leaves_a_closed_mesh() {
    assert_that_nothing_leaks(1_000_000_000);
}
