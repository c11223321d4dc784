//! Parallelograms.

use glam::{DVec2, DVec3};

use super::{
    placement::{ShapeError, check_size, columns},
    plane::meet_plane,
};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, rounding::UNIT_ROUNDOFF};

/// The square [-1, 1]² in the xy plane with normal +z, mapped by `to_world`; uv = (xy + 1)/2.
#[derive(Clone, Debug, PartialEq)]
pub struct Rectangle {
    center: DVec3,
    /// From the center to the middle of the edge u = 1.
    half_u: DVec3,
    /// From the center to the middle of the edge v = 1.
    half_v: DVec3,
    /// The vector whose dot product with (point − center) is x of the unit square.
    dual_u: DVec3,
    /// The vector that gives y likewise.
    dual_v: DVec3,
    normal: DVec3,
    position_error: DVec3,
}

impl Rectangle {
    /// The parallelogram that `to_world` makes of the square [-1, 1]²; any affine map.
    ///
    /// The normal is the image of +z under the inverse transpose, turned around by `flip_normals`. This is
    /// Mitsuba's shading normal. Under a mirroring map Mitsuba's *geometric* normal is the opposite one,
    /// which it uses only to offset rays.
    ///
    /// # Errors
    ///
    /// If an edge is too long or short for `f64`.
    pub fn new(to_world: &Transform, flip_normals: bool) -> Result<Self, ShapeError> {
        let [half_u, half_v, _] = columns(to_world);
        check_size("rectangle", half_u.length())?;
        check_size("rectangle", half_v.length())?;
        let cross = half_u.cross(half_v);
        let area_squared = cross.length_squared();
        check_size("rectangle", area_squared.sqrt())?;
        let outward = to_world.normal(DVec3::Z);
        let unit = cross / area_squared.sqrt();
        let upward = if unit.dot(outward) < 0.0 { -unit } else { unit };
        let center = to_world.point(DVec3::ZERO);
        let reach = (half_u.abs() + half_v.abs()).element_sum();
        Ok(Self {
            center,
            half_u,
            half_v,
            dual_u: half_v.cross(cross) / area_squared,
            dual_v: cross.cross(half_u) / area_squared,
            normal: if flip_normals { -upward } else { upward },
            // The projected point is off by u|p| from the last sum and 3u of each half edge. The plane that
            // the ray test sees is tilted by up to 8u (the rounding of the normal), and its height over the
            // plane is a sum of three products, 4u of the reach.
            position_error: UNIT_ROUNDOFF * (center.abs() + 16.0 * reach),
        })
    }

    /// The middle, world space.
    #[inline]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// The edges along u and v: full length, world space.
    #[inline]
    pub fn edges(&self) -> [DVec3; 2] {
        [2.0 * self.half_u, 2.0 * self.half_v]
    }

    /// The unit normal.
    #[inline]
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// The point at surface parameters `uv`, both in 0..=1.
    #[inline]
    pub fn point(&self, uv: DVec2) -> DVec3 {
        self.center + self.half_u * (2.0 * uv.x - 1.0) + self.half_v * (2.0 * uv.y - 1.0)
    }

    /// Its corners, one after the other round its edge.
    pub fn corners(&self) -> [DVec3; 4] {
        [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|uv| self.point(uv))
    }

    /// The surface at parameters `uv`, both in 0..=1.
    #[inline]
    pub fn at_uv(&self, uv: DVec2) -> SurfacePoint {
        SurfacePoint {
            position: self.point(uv),
            position_error: self.position_error,
            geometric_normal: self.normal,
            shading_normal: self.normal,
            uv,
        }
    }

    /// The area in square scene units.
    pub fn area(&self) -> f64 {
        4.0 * self.half_u.cross(self.half_v).length()
    }

    pub(in crate::geometry) fn bounds(&self) -> Bounds {
        let reach = self.half_u.abs() + self.half_v.abs() + self.position_error;
        Bounds {
            min: self.center - reach,
            max: self.center + reach,
        }
    }

    /// The distance of the hit, if any, with distance > 0; the border counts.
    #[inline]
    pub(in crate::geometry) fn distance(&self, ray: &Ray) -> Option<f64> {
        let (distance, from_center) = meet_plane(ray, self.center, self.normal)?;
        let inside =
            self.dual_u.dot(from_center).abs() <= 1.0 && self.dual_v.dot(from_center).abs() <= 1.0;
        inside.then_some(distance)
    }

    /// The intersection of a ray with the plane of the parallelogram, also beyond its border: the distance, >
    /// 0, and the surface parameters, of any size.
    pub(super) fn meet_beyond(&self, ray: &Ray) -> Option<(f64, DVec2)> {
        let (distance, from_center) = meet_plane(ray, self.center, self.normal)?;
        let xy = DVec2::new(self.dual_u.dot(from_center), self.dual_v.dot(from_center));
        Some((distance, 0.5 * (xy + 1.0)))
    }

    #[inline]
    pub(in crate::geometry) fn surface_point(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        let from_center = (ray.origin - self.center) + ray.direction * distance;
        let x = self.dual_u.dot(from_center).clamp(-1.0, 1.0);
        let y = self.dual_v.dot(from_center).clamp(-1.0, 1.0);
        SurfacePoint {
            position: self.center + (self.half_u * x + self.half_v * y),
            position_error: self.position_error,
            geometric_normal: self.normal,
            shading_normal: self.normal,
            uv: DVec2::new(0.5 * (x + 1.0), 0.5 * (y + 1.0)),
        }
    }
}
