//! Ends of paths, and of their straight parts: the next surface on the way.

use glam::DVec2;

use super::chain::MAX_PASSES;
use crate::geometry::{Hit, Ray, Segment, TraversalCounters};
use crate::scene::Scene;

/// The end of a path of fixed signature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// On the sensor's surface or its extension, at these film coordinates, in texels.
    Landed(DVec2),
    /// Nowhere: it left the scene.
    Escaped,
    /// At something before the first surface, which hides that.
    Hidden,
    /// At an interface that has no light to give to the next event: total reflection. No geometry shows where
    /// it sets in.
    TurnedBack,
    /// At a surface that ends it.
    Stopped,
}

/// The next surface that is not passed as if nothing were there, and the ray to it from the last surface that
/// was.
#[inline]
pub fn next_hit(scene: &Scene, ray: Ray, counters: &mut TraversalCounters) -> Option<(Ray, Hit)> {
    first_not_passed(MAX_PASSES, scene, ray, counters)
}

/// [`next_hit`] of many rays, an entry each. Sooner than one by one if they go about the same way
/// ([`World::closest_hits`](crate::geometry::World::closest_hits)).
pub fn next_hits(
    scene: &Scene,
    rays: impl Iterator<Item = Ray>,
    counters: &mut TraversalCounters,
) -> Vec<Option<(Ray, Hit)>> {
    let world = scene.world();
    let length = f64::INFINITY;
    let segments: Vec<Segment> = rays.map(|ray| Segment { ray, length }).collect();
    let mut hits = Vec::with_capacity(segments.len());
    world.closest_hits(&segments, &mut hits, counters);
    let found = segments
        .iter()
        .zip(hits)
        .map(|(&Segment { ray, .. }, hit)| {
            let hit = hit?;
            match passed(scene, &ray, &hit) {
                None => Some((ray, hit)),
                Some(ray) => first_not_passed(MAX_PASSES - 1, scene, ray, counters),
            }
        });
    found.collect()
}

/// The first of at most so many surfaces that is not passed, and the ray to it.
#[inline]
fn first_not_passed(
    surfaces: u32,
    scene: &Scene,
    mut ray: Ray,
    counters: &mut TraversalCounters,
) -> Option<(Ray, Hit)> {
    for _ in 0..surfaces {
        let hit = scene.world().closest_hit(&ray, f64::INFINITY, counters)?;
        match passed(scene, &ray, &hit) {
            None => return Some((ray, hit)),
            Some(further) => ray = further,
        }
    }
    None
}

/// The ray beyond a surface that is passed; `None` where it is not.
#[inline]
fn passed(scene: &Scene, ray: &Ray, hit: &Hit) -> Option<Ray> {
    let is_passed = scene.material_of(hit.shape).is_passed(scene.materials());
    is_passed.then(|| scene.world().bounce_point(ray, hit).spawn(ray.direction))
}
