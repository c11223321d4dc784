//! Light within media that absorb.
//!
//! Light knows the medium it is in: it starts in one, and a surface that bounds media sends it on into that
//! of the side it leaves to ([`Scene::medium_beyond`]). So a surface within a medium, a pebble in water, need
//! not say what is around it.

use glam::{DVec2, DVec3};

use super::chain::MAX_PASSES;
use crate::geometry::{Ray, SurfacePoint, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, MediumId, Scene, ShapeId};

/// A direction along no axis, so that a ray along it meets few edges of shapes that people make.
const ASIDE: DVec3 = DVec3::new(0.6, 0.48, 0.64);

/// The medium around the start of a ray: that before the first surface on the ray that bounds any. Light
/// that meets no such surface is in the clear.
pub fn medium_along(scene: &Scene, ray: &Ray, counters: &mut TraversalCounters) -> MediumId {
    if scene.media().is_empty() {
        return MediumId::CLEAR;
    }
    let world = scene.world();
    let mut ray = *ray;
    for _ in 0..MAX_PASSES {
        let Some(hit) = world.closest_hit(&ray, f64::INFINITY, counters) else {
            break;
        };
        let point = world.bounce_point(&ray, &hit);
        if let Some(boundary) = scene.objects()[hit.shape as usize].boundary {
            return boundary.beyond(point.geometric_normal, -ray.direction);
        }
        ray = point.spawn(ray.direction);
    }
    MediumId::CLEAR
}

/// The medium around a point.
pub fn medium_at(scene: &Scene, point: DVec3) -> MediumId {
    let ray = Ray::new(point, ASIDE);
    medium_along(scene, &ray, &mut TraversalCounters::default())
}

/// The first emitter that shines within a medium: its index.
///
/// Of one that is a surface the medium before its middle counts. Light from infinity starts in the clear.
pub fn first_immersed(scene: &Scene) -> Option<usize> {
    let is_immersed = |emitter: &Emitter| {
        let medium = match (emitter.shape(), emitter.position()) {
            (Some(shape), _) => medium_before(scene, shape),
            (None, Some(position)) => medium_at(scene, position),
            (None, None) => MediumId::CLEAR,
        };
        medium != MediumId::CLEAR && !emitter.strength().is_black()
    };
    scene.emitters().iter().position(is_immersed)
}

/// The medium before the front of a shape.
fn medium_before(scene: &Scene, ShapeId(shape): ShapeId) -> MediumId {
    let world = scene.world();
    let middle = world.shapes()[shape as usize].at_uv(DVec2::splat(0.5));
    let point = middle.or_else(|| world.face_point(shape, 0, DVec2::splat(1.0 / 3.0)));
    let Some(point) = point else {
        return MediumId::CLEAR;
    };
    let normal = point.geometric_normal;
    match scene.objects()[shape as usize].boundary {
        Some(boundary) => boundary.exterior,
        None => {
            let mut counters = TraversalCounters::default();
            medium_along(scene, &point.spawn(normal), &mut counters)
        }
    }
}

/// The share of light, per channel, that media leave on the straight way of some `length` from `point` along
/// the unit vector `towards`. It starts in `medium`, and passes every surface on the way.
pub fn transmittance(
    scene: &Scene,
    point: &SurfacePoint,
    towards: DVec3,
    mut length: f64,
    mut medium: MediumId,
    counters: &mut TraversalCounters,
) -> Rgb {
    let world = scene.world();
    let mut share = Rgb::WHITE;
    let mut ray = point.spawn(towards);
    for _ in 0..MAX_PASSES {
        let Some(hit) = world.closest_hit(&ray, length, counters) else {
            break;
        };
        share = share * scene.transmittance(medium, hit.distance);
        let point = world.bounce_point(&ray, &hit);
        medium = scene.medium_beyond(hit.shape, point.geometric_normal, towards, medium);
        length -= hit.distance;
        ray = point.spawn(towards);
    }
    share * scene.transmittance(medium, length)
}
