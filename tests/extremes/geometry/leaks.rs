//! Rays aimed at vertices and edges of closed meshes: none leaves, and none enters unseen.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use nephroid::internals::geometry::{MeshParts, Ray, World};
use rayon::prelude::*;

use crate::support::geometry::{Random, icosphere, is_lost, placed, world_of};

/// A closed ball of slivers: meridians from pole to pole in bundles of `bundle`, 1e-8 rad apart, with one
/// vertex each on the equator. Length by width of a face: √2 / 1e-8 = 1.4e8.
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

/// A line out of a solid.
struct Line {
    /// Within, or on the surface where `is_deep` is false.
    start: DVec3,
    /// On the surface.
    target: DVec3,
    is_deep: bool,
}

/// A line out of a convex solid, symmetric in x about the plane `x = middle`, through a place where a test
/// that is not watertight leaks: a vertex, the middle of an edge or any place on it; or parallel to x through
/// a vertex, so that two coordinates agree to the bit and every edge function of the vertex is exactly 0.
fn delicate_line(parts: &MeshParts, (scale, middle): (f64, DVec3), random: &mut Random) -> Line {
    let triangle = parts.triangles[random.below(parts.triangles.len())];
    let first = random.below(3);
    let [a, b] = [first, (first + 1) % 3].map(|i| parts.positions[triangle[i] as usize]);
    let start = middle + random.in_cube() * (0.3 * scale);
    let (start, target, is_deep) = match random.below(4) {
        0 => (start, a, true),
        1 => (start, a + (b - a) * 0.5, true),
        2 => (start, a + (b - a) * random.unit(), true),
        // The vertex opposite is at the other end of the way from start. Where no edge is as long (0.32 at
        // most, but for those to the poles, which are in the plane of symmetry), the way is not along the
        // surface.
        _ => (
            DVec3::new(
                middle.x + 0.9 * random.signed() * (a.x - middle.x),
                a.y,
                a.z,
            ),
            a,
            (a.x - middle.x).abs() > 0.2 * scale,
        ),
    };
    Line {
        start,
        target,
        is_deep,
    }
}

/// Rays through places where a test that is not watertight leaks.
#[derive(Default)]
struct Rays {
    /// From within a solid.
    out: AtomicU64,
    /// Rays of these that meet nothing.
    lost_out: AtomicU64,
    /// From without.
    into: AtomicU64,
    /// Rays of these that meet nothing before they are within.
    lost_into: AtomicU64,
}

impl Rays {
    /// Sends rays along so many lines through a convex solid, from within and from without.
    fn send(&self, parts: &MeshParts, world: &World, place: (f64, DVec3), lines: u64) {
        /// Lines of one thread at a time.
        const BATCH: u64 = 1 << 14;
        let count = |counter: &AtomicU64, is_so: bool| {
            counter.fetch_add(u64::from(is_so), Ordering::Relaxed);
        };
        let batches = (0..lines.div_ceil(BATCH)).into_par_iter();
        batches.for_each(|batch| {
            let mut random = Random(batch);
            let mut left = BATCH.min(lines - batch * BATCH);
            while left > 0 {
                let line = delicate_line(parts, place, &mut random);
                let through = line.target - line.start;
                let Some(direction) = through.try_normalize() else {
                    continue;
                };
                left -= 1;
                let ray = Ray::new(line.start, direction);
                count(&self.out, true);
                count(&self.lost_out, is_lost(world, &ray, f64::INFINITY));
                // Back from 1e-3 to 1e3 times as far beyond the surface.
                let from = line.target + through * 10f64.powf(3.0 * random.signed());
                let Some(back) = (line.target - from).try_normalize() else {
                    continue;
                };
                if line.is_deep {
                    let reach = line.start.distance(from);
                    count(&self.into, true);
                    count(
                        &self.lost_into,
                        is_lost(world, &Ray::new(from, back), reach),
                    );
                }
            }
        });
    }
}

/// Aims rays along `lines` lines at the vertices and edges of closed solids, slivers among them, over twelve
/// decades of size, from within and from without: none may get out, and none in without meeting the surface.
fn assert_that_nothing_leaks(lines: u64) {
    let places = [
        (1.0, DVec3::ZERO),
        (1e-6, DVec3::ZERO),
        (1e6, DVec3::ZERO),
        (1.0, DVec3::new(1048576.0, -524288.0, 3.0)),
    ];
    let solids = [icosphere(2), icosphere(4), sliver_ball(8, 16)];
    let share = lines / (places.len() * solids.len()) as u64;
    let mut sums = [0; 2];
    for solid in &solids {
        for place in places {
            let parts = placed(solid.clone(), place.0, place.1);
            let world = world_of(parts.clone());
            let rays = Rays::default();
            rays.send(&parts, &world, place, share);
            let case = format!("{} faces, {place:?}", parts.triangles.len());
            assert_eq!(rays.lost_out.into_inner(), 0, "out of {case}");
            assert_eq!(rays.lost_into.into_inner(), 0, "into {case}");
            let sent = [rays.out, rays.into].map(AtomicU64::into_inner);
            // Three kinds of four are deep whatever the vertex.
            assert!(
                sent[0] == share && sent[1] > share * 7 / 10,
                "{case}: {sent:?}"
            );
            sums = [0, 1].map(|way| sums[way] + sent[way]);
        }
    }
    println!(
        "none of {} rays from within is lost, none of {} from without",
        sums[0], sums[1]
    );
}

#[test]
fn no_ray_of_a_million_aimed_at_vertices_and_edges_leaves_a_closed_mesh_or_enters_it_unseen() {
    assert_that_nothing_leaks(600_000);
}

/// Takes eighty CPU-minutes: `cargo test --release --test extremes a_billion -- --ignored`.
#[test]
#[ignore = "a billion rays"]
fn no_ray_of_a_billion_aimed_at_vertices_and_edges_leaves_a_closed_mesh_or_enters_it_unseen() {
    assert_that_nothing_leaks(1_000_000_000);
}
