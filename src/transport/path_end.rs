//! The end of a straight part of a path: the next surface in its way, and how the last part ends.

use glam::DVec2;

use super::chain::MAX_PASSES;
use crate::geometry::{Hit, Ray, TraversalCounters};
use crate::scene::Scene;

/// How a path of fixed signature ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// On the sensor's surface or its extension, at these film coordinates, in texels.
    Landed(DVec2),
    /// Nothing is there any more: it left the scene.
    Escaped,
    /// On the way to the first surface, something else was met.
    Hidden,
    /// An interface that has no light to give to the next event: total reflection. Where it sets in,
    /// no geometry shows.
    TurnedBack,
    /// A surface that ends it.
    Stopped,
}

/// The next surface that is not passed as if nothing were there, and the ray from the last that was.
#[inline]
pub fn next_hit(
    scene: &Scene,
    mut ray: Ray,
    counters: &mut TraversalCounters,
) -> Option<(Ray, Hit)> {
    let world = scene.world();
    for _ in 0..MAX_PASSES {
        let hit = world.closest_hit(&ray, f64::INFINITY, counters)?;
        if !scene.material_of(hit.shape).is_passed(scene.materials()) {
            return Some((ray, hit));
        }
        ray = world.bounce_point(&ray, &hit).spawn(ray.direction);
    }
    None
}
