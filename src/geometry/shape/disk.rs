//! Flat discs.

use glam::{DVec2, DVec3};

use super::{
    angle::turn_fraction,
    placement::{ShapeError, check_size, columns},
    plane::meet_plane,
};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, rounding::UNIT_ROUNDOFF};
use crate::numeric::math;

/// The unit disc in the xy plane with normal +z, mapped by `to_world`; uv = (r, φ/2π).
///
/// An uneven scale makes an ellipse, as in Mitsuba; r and φ are then those of the unit disc.
#[derive(Clone, Debug, PartialEq)]
pub struct Disk {
    center: DVec3,
    /// From the center to the image of (1, 0).
    half_u: DVec3,
    /// From the center to the image of (0, 1).
    half_v: DVec3,
    dual_u: DVec3,
    dual_v: DVec3,
    normal: DVec3,
    position_error: DVec3,
}

impl Disk {
    /// The ellipse that `to_world` makes of the unit disc; any affine map.
    ///
    /// The normal is the image of +z under the inverse transpose, turned around by `flip_normals`.
    ///
    /// # Errors
    ///
    /// If a radius is too long or short for `f64`.
    pub fn new(to_world: &Transform, flip_normals: bool) -> Result<Self, ShapeError> {
        let [half_u, half_v, _] = columns(to_world);
        check_size("disk", half_u.length())?;
        check_size("disk", half_v.length())?;
        let cross = half_u.cross(half_v);
        let area_squared = cross.length_squared();
        check_size("disk", area_squared.sqrt())?;
        let unit = cross / area_squared.sqrt();
        let upward = if unit.dot(to_world.normal(DVec3::Z)) < 0.0 {
            -unit
        } else {
            unit
        };
        let center = to_world.point(DVec3::ZERO);
        let reach = (half_u.abs() + half_v.abs()).element_sum();
        Ok(Self {
            center,
            half_u,
            half_v,
            dual_u: half_v.cross(cross) / area_squared,
            dual_v: cross.cross(half_u) / area_squared,
            normal: if flip_normals { -upward } else { upward },
            // As for a rectangle with the same half edges.
            position_error: UNIT_ROUNDOFF * (center.abs() + 16.0 * reach),
        })
    }

    /// The center, world space.
    #[inline]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// The unit normal.
    #[inline]
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// The images of (1, 0) and (0, 1), less the center.
    #[inline]
    pub fn half_axes(&self) -> [DVec3; 2] {
        [self.half_u, self.half_v]
    }

    /// The point at surface parameters (r, φ/2π), both in 0..=1.
    pub fn at_uv(&self, uv: DVec2) -> SurfacePoint {
        let (sin, cos) = math::sin_cos(std::f64::consts::TAU * uv.y);
        SurfacePoint {
            position: self.center + (self.half_u * cos + self.half_v * sin) * uv.x,
            position_error: self.position_error,
            geometric_normal: self.normal,
            shading_normal: self.normal,
            uv,
        }
    }

    /// The area in square scene units.
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.half_u.cross(self.half_v).length()
    }

    pub(in crate::geometry) fn bounds(&self) -> Bounds {
        // An ellipse c + a cos φ + b sin φ reaches √(a² + b²) along each axis.
        let reach = (self.half_u * self.half_u + self.half_v * self.half_v).map(f64::sqrt)
            + self.position_error;
        Bounds {
            min: self.center - reach,
            max: self.center + reach,
        }
    }

    /// The distance of the hit, if any, with distance > 0; the border counts.
    #[inline]
    pub(in crate::geometry) fn distance(&self, ray: &Ray) -> Option<f64> {
        let (distance, from_center) = meet_plane(ray, self.center, self.normal)?;
        let x = self.dual_u.dot(from_center);
        let y = self.dual_v.dot(from_center);
        (x * x + y * y <= 1.0).then_some(distance)
    }

    /// The intersection of a ray with the plane of the disc, also beyond its rim: the distance, > 0, and the
    /// surface parameters, r of any size.
    pub(super) fn meet_beyond(&self, ray: &Ray) -> Option<(f64, DVec2)> {
        let (distance, from_center) = meet_plane(ray, self.center, self.normal)?;
        let [x, y] = [self.dual_u, self.dual_v].map(|dual| dual.dot(from_center));
        Some((distance, DVec2::new(math::hypot(x, y), turn_fraction(y, x))))
    }

    #[inline]
    pub(in crate::geometry) fn surface_point(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        let from_center = (ray.origin - self.center) + ray.direction * distance;
        let x = self.dual_u.dot(from_center);
        let y = self.dual_v.dot(from_center);
        SurfacePoint {
            position: self.center + (self.half_u * x + self.half_v * y),
            position_error: self.position_error,
            geometric_normal: self.normal,
            shading_normal: self.normal,
            uv: DVec2::new(x, y),
        }
    }

    /// Turns the Cartesian parameters that [`Self::surface_point`] leaves into Mitsuba's polar ones.
    pub(in crate::geometry) fn uv(point: &SurfacePoint) -> DVec2 {
        Self::polar(point.uv)
    }

    /// The surface parameters of a place, which is given by coordinates along the half axes.
    pub fn polar(DVec2 { x, y }: DVec2) -> DVec2 {
        DVec2::new(math::hypot(x, y).min(1.0), turn_fraction(y, x))
    }
}
