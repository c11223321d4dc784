//! Half-lines, and their beginnings.

use glam::DVec3;

/// A half-line: `origin + t * direction`, t > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The start, world space.
    pub origin: DVec3,
    /// The direction of travel, a unit vector.
    pub direction: DVec3,
}

impl Ray {
    /// A ray from `origin` along the unit vector `direction`.
    #[inline]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        debug_assert!((direction.length_squared() - 1.0).abs() < 1e-9);
        Self { origin, direction }
    }

    /// The point at distance `t` along the ray.
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// The beginning of a ray, up to a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The ray.
    pub ray: Ray,
    /// The distance up to which it is of interest, exclusive; may be infinite.
    pub length: f64,
}
