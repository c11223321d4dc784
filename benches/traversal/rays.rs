//! Rays of three kinds around a torus of radius 1, searches for them, and a bench's clock.

use std::{hint::black_box, time::Instant};

use glam::DVec3;
use nephroid::internals::geometry::{Ray, Segment, TraversalCounters, World};

use crate::support::geometry::Random;

/// Number of rays of a kind.
pub const RAYS: usize = 1 << 18;

/// Rays from one point through the texels of an image, in order.
pub fn coherent() -> Vec<Ray> {
    let (eye, side) = (DVec3::new(2.0, -3.0, 2.0), 1 << 9);
    let forward = -eye.normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    (0..RAYS)
        .map(|i| {
            let at = |k: usize| 0.8 * ((k as f64 + 0.5) / f64::from(side) - 0.5);
            let (x, y) = (at(i % side as usize), at(i / side as usize));
            Ray::new(eye, (forward + right * x + up * y).normalize())
        })
        .collect()
}

/// Rays that join random points of a ball around the mesh.
pub fn incoherent() -> Vec<Ray> {
    let mut random = Random(1);
    (0..RAYS)
        .map(|_| {
            let [from, to] = [(); 2].map(|()| random.direction() * 1.5 * random.unit().cbrt());
            Ray::new(from, (to - from).normalize())
        })
        .collect()
}

/// Rays that leave random points within the torus.
pub fn inside() -> Vec<Ray> {
    let mut random = Random(2);
    (0..RAYS)
        .map(|_| {
            let angle = std::f64::consts::TAU * random.unit();
            let core = DVec3::new(angle.cos(), angle.sin(), 0.0);
            Ray::new(core + 0.2 * random.direction(), random.direction())
        })
        .collect()
}

/// The whole rays as segments.
pub fn segments(rays: &[Ray]) -> Vec<Segment> {
    let whole = |&ray| Segment {
        ray,
        length: f64::INFINITY,
    };
    rays.iter().map(whole).collect()
}

/// Searches for all rays, one after the other; returns (hits, work).
pub fn search(world: &World, rays: &[Ray]) -> (usize, TraversalCounters) {
    let mut counters = TraversalCounters::default();
    let hits = rays
        .iter()
        .filter(|ray| black_box(world.closest_hit(ray, f64::INFINITY, &mut counters)).is_some())
        .count();
    (hits, counters)
}

/// Searches for all rays, many at a time; returns the number of hits.
pub fn search_many(world: &World, segments: &[Segment]) -> usize {
    let mut counters = TraversalCounters::default();
    let mut found = Vec::new();
    let batches = segments.chunks(512).map(|batch| {
        world.closest_hits(batch, &mut found, &mut counters);
        black_box(&found).iter().flatten().count()
    });
    batches.sum()
}

/// The time of some work, seconds.
pub fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}
