//! Ends of paths, and of their straight parts: the next surface on the way.

use glam::DVec2;

use super::chain::MAX_PASSES;
use crate::geometry::{Hit, Ray, TraversalCounters};
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
