//! Intersection of a ray with a plane.

use glam::DVec3;

use crate::geometry::Ray;

/// The intersection of a ray with a plane: (distance, hit − `center`), unless the ray runs along the plane or
/// the plane lies behind it.
#[inline]
pub(in crate::geometry) fn meet_plane(
    ray: &Ray,
    center: DVec3,
    normal: DVec3,
) -> Option<(f64, DVec3)> {
    let from_center = ray.origin - center;
    let height = normal.dot(from_center);
    let approach = normal.dot(ray.direction);
    // The plane is ahead only if height and approach have opposite signs; both branches reject NaN.
    if height * approach < 0.0 {
        let distance = -height / approach;
        Some((distance, from_center + ray.direction * distance))
    } else {
        None
    }
}
