//! Spheres.

use glam::{DVec2, DVec3};

use super::{
    angle::turn_fraction,
    placement::{ShapeError, check_size, columns, equally_long, perpendicular},
};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, rounding::UNIT_ROUNDOFF};
use crate::numeric::math;

/// The unit sphere mapped by `to_world`; normal outward; uv = (φ/2π, θ/π) in the sphere's own space.
#[derive(Clone, Debug, PartialEq)]
pub struct Sphere {
    center: DVec3,
    radius: f64,
    radius_squared: f64,
    /// +1/r if the normal points outward, −1/r if inward.
    signed_curvature: f64,
    position_error: DVec3,
    to_local: Transform,
}

impl Sphere {
    /// The sphere that `to_world` makes of the unit sphere.
    ///
    /// `flip_normals` turns the normal inward; so does a mirroring `to_world`, as in Mitsuba 3.9 (which reads
    /// a mirror as a negative radius). Both together cancel.
    ///
    /// # Errors
    ///
    /// If `to_world` shears or scales unevenly; Mitsuba warns and renders something else.
    pub fn new(to_world: &Transform, flip_normals: bool) -> Result<Self, ShapeError> {
        let [x, y, z] = columns(to_world);
        let round = equally_long(x, y)
            && equally_long(y, z)
            && perpendicular(x, y)
            && perpendicular(y, z)
            && perpendicular(z, x);
        let radius = x.length();
        check_size("sphere", radius)?;
        if !round {
            return Err(ShapeError::NotRound { plugin: "sphere" });
        }
        let center = to_world.point(DVec3::ZERO);
        let inward = flip_normals != to_world.is_mirroring();
        Ok(Self {
            center,
            radius,
            radius_squared: radius * radius,
            signed_curvature: if inward { -1.0 } else { 1.0 } / radius,
            // A point projected onto the sphere is off by u|p| from the last sum and by 6u r from the
            // difference, norm, quotient and product before it. A ray that starts there has its |f|² − r²
            // (below) off by 7u r² (difference 2u, square 3u, r² and the last difference u each). That equals
            // a start off by 3.5u r; twice that also keeps the discriminant's sign. 16 covers 1 + 6 + 7 with
            // a margin.
            position_error: UNIT_ROUNDOFF * (center.abs() + 16.0 * radius),
            to_local: to_world.inverse(),
        })
    }

    /// The center, world space.
    #[inline]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// The radius in scene units.
    #[inline]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The map from the unit sphere.
    pub(super) fn to_world(&self) -> Transform {
        self.to_local.inverse()
    }

    /// True if the normal points to the inside.
    #[inline]
    pub fn is_inward(&self) -> bool {
        self.signed_curvature < 0.0
    }

    /// The surface at parameters (φ/2π, θ/π), both in 0..=1.
    pub fn at_uv(&self, uv: DVec2) -> SurfacePoint {
        let (sin_phi, cos_phi) = math::sin_cos(std::f64::consts::TAU * uv.x);
        let (sin, cos) = math::sin_cos(std::f64::consts::PI * uv.y);
        self.along(
            self.to_local
                .inverse()
                .vector(DVec3::new(sin * cos_phi, sin * sin_phi, cos)),
        )
    }

    /// The surface at the end of the radius along `direction` (of any length).
    pub fn along(&self, direction: DVec3) -> SurfacePoint {
        let to_surface = direction * (self.radius / direction.length());
        let normal = to_surface * self.signed_curvature;
        SurfacePoint {
            position: self.center + to_surface,
            position_error: self.position_error,
            geometric_normal: normal,
            shading_normal: normal,
            uv: DVec2::ZERO,
        }
    }

    /// The change of the unit normal as a point of the surface moves by `along`: ±along / r.
    #[inline]
    pub(in crate::geometry) fn normal_derivative(&self, along: DVec3) -> DVec3 {
        along * self.signed_curvature
    }

    /// A vector of the sphere's own space, in world space.
    #[inline]
    pub(in crate::geometry) fn vector_to_world(&self, vector: DVec3) -> DVec3 {
        self.to_local.inverse().vector(vector)
    }

    /// The area 4πr².
    pub fn area(&self) -> f64 {
        4.0 * std::f64::consts::PI * self.radius_squared
    }

    pub(in crate::geometry) fn bounds(&self) -> Bounds {
        // The error bound exceeds the rounding of the corners.
        let reach = DVec3::splat(self.radius) + self.position_error;
        Bounds {
            min: self.center - reach,
            max: self.center + reach,
        }
    }

    /// The distance of the first hit with distance > 0.
    ///
    /// Solves |f + t d|² = r² with f = origin − center, after Haines et al., *Precision improvements for
    /// ray/sphere intersection*, Ray Tracing Gems (2019), chapter 7. The discriminant is r² minus the squared
    /// distance of center and line, which keeps its digits if the sphere is small and far. The nearer root is
    /// c/q, which keeps its digits if the origin is on the surface, or, farther off, the difference that it
    /// stands for. From a quarter of a radius on, Newton's step from there removes most of the roundings: 3
    /// units in the last place remain of 8.
    #[inline]
    pub(in crate::geometry) fn distance(&self, ray: &Ray) -> Option<f64> {
        let from_center = ray.origin - self.center;
        let approach = -from_center.dot(ray.direction);
        let c = from_center.length_squared() - self.radius_squared;
        if c > 0.0 && approach <= 0.0 {
            return None; // outside and moving away
        }
        let miss = from_center + ray.direction * approach;
        let discriminant = self.radius_squared - miss.length_squared();
        if discriminant < 0.0 {
            return None;
        }
        let half_chord = discriminant.sqrt();
        let distance = if approach >= 0.0 {
            let far = approach + half_chord;
            if c <= 0.0 {
                far
            } else if approach > 2.0 * half_chord {
                // Little cancels here, and c's roundings, some of |f|², do not enter.
                approach - half_chord
            } else {
                c / far
            }
        } else {
            c / (approach - half_chord)
        };
        let distance = if distance >= 0.25 * self.radius {
            let from_center = from_center + ray.direction * distance;
            let length = from_center.length();
            // The step is (|p|² − r²)/2 over its derivative p·d.
            let height = 0.5 * (length - self.radius) * (length + self.radius);
            let step = height / from_center.dot(ray.direction);
            // A ray that grazes has no usable derivative; the test is false for NaN.
            if step.abs() <= half_chord {
                distance - step
            } else {
                distance
            }
        } else {
            distance
        };
        (distance > 0.0).then_some(distance)
    }

    #[inline]
    pub(in crate::geometry) fn surface_point(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        let from_center = (ray.origin - self.center) + ray.direction * distance;
        let to_surface = from_center * (self.radius / from_center.length());
        let normal = to_surface * self.signed_curvature;
        SurfacePoint {
            position: self.center + to_surface,
            position_error: self.position_error,
            geometric_normal: normal,
            shading_normal: normal,
            uv: DVec2::ZERO,
        }
    }

    pub(in crate::geometry) fn uv(&self, point: &SurfacePoint) -> DVec2 {
        // By way of the normal, which keeps its digits if the center is far from the origin.
        self.uv_along(point.geometric_normal * self.signed_curvature.signum())
    }

    /// The surface parameters at the end of the radius along a unit vector.
    pub fn uv_along(&self, direction: DVec3) -> DVec2 {
        let outward = direction * self.radius;
        let local = self.to_local.vector(outward);
        let theta = math::atan2(math::hypot(local.x, local.y), local.z);
        DVec2::new(
            turn_fraction(local.y, local.x),
            theta * std::f64::consts::FRAC_1_PI,
        )
    }
}
