//! Open tubes.

use glam::{DVec2, DVec3};

use super::{
    angle::turn_fraction,
    placement::{ShapeError, check_size, columns, equally_long, perpendicular},
};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, rounding::UNIT_ROUNDOFF};
use crate::numeric::math;

/// A cylinder of radius 1 about the z axis from z = 0 to z = 1, mapped by `to_world`; normal outward; uv =
/// (φ/2π, z). No caps, as in Mitsuba.
#[derive(Clone, Debug, PartialEq)]
pub struct Cylinder {
    base: DVec3,
    /// Unit vector from the base to the other end.
    axis: DVec3,
    length: f64,
    radius: f64,
    radius_squared: f64,
    /// +1/r if the normal points outward, −1/r if inward.
    signed_curvature: f64,
    position_error: DVec3,
    to_local: Transform,
}

impl Cylinder {
    /// The tube that `to_world` makes of the unit tube; the scale along the axis is free.
    ///
    /// `flip_normals` turns the normal inward; a mirroring `to_world` does not, as in Mitsuba.
    ///
    /// # Errors
    ///
    /// If `to_world` makes the cross section an ellipse or shears; Mitsuba warns.
    pub fn new(to_world: &Transform, flip_normals: bool) -> Result<Self, ShapeError> {
        let [x, y, z] = columns(to_world);
        let (radius, length) = (x.length(), z.length());
        check_size("cylinder", radius)?;
        check_size("cylinder", length)?;
        let round =
            equally_long(x, y) && perpendicular(x, y) && perpendicular(y, z) && perpendicular(z, x);
        if !round {
            return Err(ShapeError::NotRound { plugin: "cylinder" });
        }
        let base = to_world.point(DVec3::ZERO);
        Ok(Self {
            base,
            axis: z / length,
            length,
            radius,
            radius_squared: radius * radius,
            signed_curvature: if flip_normals { -1.0 } else { 1.0 } / radius,
            // As for a sphere, with two additions. The part of a vector across the axis is found by
            // subtracting the part along it, which costs 6u of the vector's own length. The projected point
            // is a sum over both parts.
            position_error: UNIT_ROUNDOFF * (base.abs() + 32.0 * (radius + length)),
            to_local: to_world.inverse(),
        })
    }

    /// The map from the unit tube.
    pub(super) fn to_world(&self) -> Transform {
        self.to_local.inverse()
    }

    /// True if the normal points to the axis.
    pub fn is_inward(&self) -> bool {
        self.signed_curvature < 0.0
    }

    /// The middle of the circle z = 0, world space.
    #[inline]
    pub fn base(&self) -> DVec3 {
        self.base
    }

    /// The unit vector along the axis.
    #[inline]
    pub fn axis(&self) -> DVec3 {
        self.axis
    }

    /// The length along the axis in scene units.
    #[inline]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The radius in scene units.
    #[inline]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The surface at parameters (φ/2π, z/length), both in 0..=1.
    pub fn at_uv(&self, uv: DVec2) -> SurfacePoint {
        let (sin, cos) = math::sin_cos(std::f64::consts::TAU * uv.x);
        let across = self.to_local.inverse().vector(DVec3::new(cos, sin, 0.0));
        let to_surface = across * (self.radius / across.length());
        let normal = to_surface * self.signed_curvature;
        SurfacePoint {
            position: self.base + (self.axis * (self.length * uv.y) + to_surface),
            position_error: self.position_error,
            geometric_normal: normal,
            shading_normal: normal,
            uv,
        }
    }

    /// The change of the unit normal as a point of the surface moves by `along`: the part across the axis, by
    /// ±1/r.
    #[inline]
    pub(in crate::geometry) fn normal_derivative(&self, along: DVec3) -> DVec3 {
        (along - self.axis * along.dot(self.axis)) * self.signed_curvature
    }

    /// A vector of the cylinder's own space, in world space.
    #[inline]
    pub(in crate::geometry) fn vector_to_world(&self, vector: DVec3) -> DVec3 {
        self.to_local.inverse().vector(vector)
    }

    /// The area 2πrl.
    pub fn area(&self) -> f64 {
        2.0 * std::f64::consts::PI * self.radius * self.length
    }

    pub(in crate::geometry) fn bounds(&self) -> Bounds {
        // A circle with unit normal n reaches r √(1 − nᵢ²) along axis i.
        let across = self
            .axis
            .map(|n| self.radius * (1.0 - n * n).max(0.0).sqrt());
        // √(1 − n²) loses half its digits near n = 1: there it is off by up to √(4u).
        let margin = self.position_error + DVec3::splat(self.radius * 2.2e-8);
        let top = self.base + self.axis * self.length;
        let reach = across + margin;
        Bounds {
            min: self.base.min(top) - reach,
            max: self.base.max(top) + reach,
        }
    }

    /// The distance of the first hit with distance > 0.
    ///
    /// The sphere's method (see [`Sphere`](super::Sphere)) in the plane across the axis.
    #[inline]
    pub(in crate::geometry) fn distance(&self, ray: &Ray) -> Option<f64> {
        let from_base = ray.origin - self.base;
        let height = from_base.dot(self.axis);
        let climb = ray.direction.dot(self.axis);
        let across = from_base - self.axis * height;
        let direction = ray.direction - self.axis * climb;
        let a = direction.length_squared();
        let approach = -across.dot(direction);
        let c = across.length_squared() - self.radius_squared;
        if a == 0.0 || (c > 0.0 && approach <= 0.0) {
            return None; // along the axis, or outside and moving away
        }
        let miss = across + direction * (approach / a);
        let discriminant = self.radius_squared - miss.length_squared();
        if discriminant < 0.0 {
            return None;
        }
        let half_chord = (a * discriminant).sqrt();
        let (near, far) = if approach >= 0.0 {
            let q = approach + half_chord;
            (c / q, q / a)
        } else {
            let q = approach - half_chord;
            (q / a, c / q)
        };
        let on_tube = |t: f64| t > 0.0 && (0.0..=self.length).contains(&(height + t * climb));
        if on_tube(near) {
            Some(near)
        } else if on_tube(far) {
            Some(far)
        } else {
            None
        }
    }

    #[inline]
    pub(in crate::geometry) fn surface_point(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        let from_base = (ray.origin - self.base) + ray.direction * distance;
        let height = from_base.dot(self.axis);
        let across = from_base - self.axis * height;
        let to_surface = across * (self.radius / across.length());
        let normal = to_surface * self.signed_curvature;
        SurfacePoint {
            position: self.base + (self.axis * height + to_surface),
            position_error: self.position_error,
            geometric_normal: normal,
            shading_normal: normal,
            uv: DVec2::new(0.0, (height / self.length).clamp(0.0, 1.0)),
        }
    }

    pub(in crate::geometry) fn uv(&self, point: &SurfacePoint) -> DVec2 {
        let outward = point.geometric_normal * self.signed_curvature.signum() * self.radius;
        let local = self.to_local.vector(outward);
        DVec2::new(turn_fraction(local.y, local.x), point.uv.y)
    }
}
