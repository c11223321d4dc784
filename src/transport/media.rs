//! Light within media that absorb.
//!
//! Light knows the medium it is in: it starts in one, and a surface that bounds media sends it on into that
//! of the side it leaves to ([`Scene::medium_beyond`]). So an opaque surface within a medium, a pebble in
//! water, need not say what is around it. Glass there must, or light goes on within it as if in water.

use glam::{DVec2, DVec3};

use super::chain::MAX_PASSES;
use crate::geometry::{Ray, Shape, SurfacePoint, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, MAX_SHINING_TRIANGLES, MediumId, Scene, ShapeId};

/// A direction along no axis, so that a ray along it meets few edges of shapes that people make.
const ASIDE: DVec3 = DVec3::new(0.6, 0.48, 0.64);

/// The medium around the start of a ray: that before the first surface on the ray that bounds any. Light
/// that meets no such surface is in the clear.
pub fn medium_along(scene: &Scene, ray: &Ray, counters: &mut TraversalCounters) -> MediumId {
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

/// The first emitter that shines within a medium: its index. The file may say so, or the surfaces around.
///
/// A surface is asked at some places, and each face of a mesh in its middle. Light from infinity starts in
/// the clear.
pub fn first_immersed(scene: &Scene) -> Option<usize> {
    if scene.is_clear() {
        return None;
    }
    let is_in_medium = |ray: Ray| {
        let mut counters = TraversalCounters::default();
        medium_along(scene, &ray, &mut counters) != MediumId::CLEAR
    };
    let is_immersed = |(index, emitter): (usize, &Emitter)| {
        let is_around = match (emitter.shape(), emitter.position()) {
            (Some(shape), _) => fronts(scene, shape).any(is_in_medium),
            (None, Some(position)) => is_in_medium(Ray::new(position, ASIDE)),
            (None, None) => false,
        };
        (is_around || scene.immersed().contains(&index)) && !emitter.strength().is_black()
    };
    let mut emitters = scene.emitters().iter().enumerate();
    emitters.position(is_immersed)
}

/// Rays that leave the front of a shape straight, from some of its places.
fn fronts(scene: &Scene, ShapeId(shape): ShapeId) -> impl Iterator<Item = Ray> {
    let world = scene.world();
    let faces = match &world.shapes()[shape as usize] {
        Shape::Mesh(mesh) => mesh.triangle_count().min(MAX_SHINING_TRIANGLES),
        _ => 0,
    };
    let middle = DVec2::splat(1.0 / 3.0);
    let of_faces = (0..faces as u32).filter_map(move |face| world.face_point(shape, face, middle));
    let uv = (0..9).map(|cell| DVec2::new(f64::from(cell % 3), f64::from(cell / 3)) * 0.5);
    let of_rounds = uv.filter_map(move |uv| world.shapes()[shape as usize].at_uv(uv));
    of_faces
        .chain(of_rounds)
        .map(|point| point.spawn(point.geometric_normal))
}

/// The share of light, per channel, that media leave on the straight way of some `length` from `point` along
/// the unit vector `towards`. It starts in `medium`, and passes every surface on the way.
pub fn left_on_way(
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
