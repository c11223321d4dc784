//! Points at which rays hit surfaces.

use glam::{DVec2, DVec3};

use super::Ray;

/// An intersection of a ray with a surface: enough to compare and to look up the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray.
    pub distance: f64,
    /// Index into [`World::shapes`](super::World::shapes).
    pub shape: u32,
    /// The triangle of a mesh; 0 for analytic shapes.
    pub face: u32,
    /// Barycentric weights of the triangle's second and third vertex; unused by analytic shapes.
    pub barycentric: DVec2,
}

/// The properties of a point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The position in world space, projected onto the surface.
    pub position: DVec3,
    /// A bound on the absolute error of `position`, per axis.
    pub position_error: DVec3,
    /// The surface's unit normal, on the side that Mitsuba calls outside.
    pub geometric_normal: DVec3,
    /// The unit normal interpolated over a mesh; else the same as `geometric_normal`.
    pub shading_normal: DVec3,
    /// Surface parameters as Mitsuba defines them; barycentric for meshes without any.
    pub uv: DVec2,
}

impl SurfacePoint {
    /// A ray that leaves the surface along the unit vector `direction`. Its start is moved off the surface by
    /// just its error bound, to the side that `direction` points to.
    ///
    /// Following Pharr, Jakob and Humphreys, *Physically Based Rendering*, 3rd edition, 3.9.5.
    #[inline]
    pub fn spawn(&self, direction: DVec3) -> Ray {
        let normal = self.geometric_normal;
        let offset = normal.abs().dot(self.position_error);
        let side = if normal.dot(direction) < 0.0 {
            -offset
        } else {
            offset
        };
        // The sum is rounded once more: step one float further out on each axis.
        let moved = self.position + normal * side;
        let outward = |p: f64, n: f64| {
            if n * side > 0.0 {
                p.next_up()
            } else if n * side < 0.0 {
                p.next_down()
            } else {
                p
            }
        };
        Ray::new(
            DVec3::new(
                outward(moved.x, normal.x),
                outward(moved.y, normal.y),
                outward(moved.z, normal.z),
            ),
            direction,
        )
    }
}
