//! Visibility between two points.

use glam::DVec3;

use crate::geometry::{Ray, SurfacePoint, TraversalCounters};
use crate::scene::{Material, Scalar, Scene, TexturePoint};

/// The share (0..=1) of light that passes between `point` and the place at `distance` along the unit vector
/// `towards`.
///
/// Null surfaces let all of it through, masks one minus their opacity, and everything else nothing.
///
/// Both ends are exclusive: the surface of `point` itself does not count, nor does one at `distance`.
/// Refraction does not count as a straight passage, so glass blocks.
pub fn transmittance(
    scene: &Scene,
    point: &SurfacePoint,
    towards: DVec3,
    distance: f64,
    counters: &mut TraversalCounters,
) -> f64 {
    let ray = point.spawn(towards);
    let mut meets_mask = false;
    let blocked = scene.world().any_hit(
        &ray,
        distance,
        |hit| {
            // A texture may be open at any place.
            let least = |opacity| match opacity {
                Scalar::Constant(opacity) => opacity,
                Scalar::Texture(_) => 0.0,
            };
            let material = scene.material_of(hit.shape);
            meets_mask |= matches!(material, Material::Mask { .. });
            material.below_masks(scene.materials(), least).0 >= 1.0
        },
        counters,
    );
    match (blocked, meets_mask) {
        (true, _) => 0.0,
        (false, false) => 1.0,
        (false, true) => masked_transmittance(scene, ray, distance, counters),
    }
}

/// The share of light that passes masks, met one after the other. It is needed since `any_hit` reports a
/// round shape once even if a ray crosses it twice.
fn masked_transmittance(
    scene: &Scene,
    mut ray: Ray,
    mut distance: f64,
    counters: &mut TraversalCounters,
) -> f64 {
    let mut passed = 1.0;
    while passed > 0.0 {
        let Some(hit) = scene.world().closest_hit(&ray, distance, counters) else {
            break;
        };
        let value_of = |opacity| match opacity {
            Scalar::Constant(opacity) => opacity,
            Scalar::Texture(_) => {
                let point = scene.world().surface_point(&ray, &hit);
                scene.scalar(opacity, &TexturePoint::new(scene, &hit, &point))
            }
        };
        let material = scene.material_of(hit.shape);
        passed *= 1.0 - material.below_masks(scene.materials(), value_of).0;
        distance -= hit.distance;
        ray = scene.world().bounce_point(&ray, &hit).spawn(ray.direction);
    }
    passed
}
