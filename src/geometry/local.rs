//! One surface by itself: its intersection with rays whatever is in the way, and the change of its normal.

use glam::{DVec2, DVec3};

use super::rounding::gamma;
use super::shape::meet_plane;
use super::{Hit, Ray, Shape, SurfacePoint, TraversalCounters, World};

/// A part of the scene's surface on which everything is smooth: a whole shape, or one face of a
/// mesh with flat faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SurfaceElement {
    /// Index into [`World::shapes`].
    pub shape: u32,
    /// The face, for a mesh without interpolated normals.
    pub face: Option<u32>,
}

impl World {
    /// The element that a hit lies on.
    #[inline]
    pub fn element(&self, hit: &Hit) -> SurfaceElement {
        let flat = match &self.shapes()[hit.shape as usize] {
            Shape::Mesh(mesh) => !mesh.has_vertex_normals(),
            _ => false,
        };
        SurfaceElement {
            shape: hit.shape,
            face: flat.then_some(hit.face),
        }
    }

    /// The intersection of a ray with an element, whatever is in the way.
    ///
    /// Flat elements (rectangle, disk, face) are extended to their whole plane, so that a map along a chain
    /// of elements stays smooth beyond their borders. For a round shape or a mesh with interpolated normals
    /// it is the first hit at a distance > 0. The `uv` of the result is unspecified.
    pub fn meet_element(
        &self,
        ray: &Ray,
        element: SurfaceElement,
        counters: &mut TraversalCounters,
    ) -> Option<(Hit, SurfacePoint)> {
        let shape = &self.shapes()[element.shape as usize];
        let (center, normal) = match (shape, element.face) {
            (Shape::Rectangle(rectangle), _) => (rectangle.center(), rectangle.normal()),
            (Shape::Disk(disk), _) => (disk.center(), disk.normal()),
            (Shape::Mesh(mesh), Some(face)) => (mesh.corners(face)[0], mesh.face_normal(face)),
            _ => {
                counters.rays += 1;
                let hit = self.hit_on(element.shape, ray, counters)?;
                return Some((hit, self.bounce_point(ray, &hit)));
            }
        };
        counters.primitive_tests += 1;
        let (distance, from_center) = meet_plane(ray, center, normal)?;
        let position = center + from_center;
        let face = element.face.unwrap_or(0);
        let barycentric = match shape {
            Shape::Mesh(mesh) => mesh.barycentric(face, position),
            _ => DVec2::ZERO,
        };
        let hit = Hit {
            distance,
            shape: element.shape,
            face,
            barycentric,
        };
        // Differences, products and sums of a handful of terms, none larger than these.
        let reach = center.abs() + from_center.abs() + ray.origin.abs();
        let point = SurfacePoint {
            position,
            position_error: DVec3::splat(gamma(16) * reach.element_sum()),
            geometric_normal: normal,
            shading_normal: normal,
            uv: DVec2::ZERO,
        };
        Some((hit, point))
    }

    /// The change ∂n of the shading normal as a hit point moves by `along` in the surface, per unit of
    /// whatever `along` is per unit of. (It is minus the shape operator of differential geometry, applied to
    /// `along`.)
    ///
    /// `along` must lie in the tangent plane of the true surface.
    pub fn normal_derivative(&self, hit: &Hit, along: DVec3) -> DVec3 {
        match &self.shapes()[hit.shape as usize] {
            Shape::Sphere(sphere) => sphere.normal_derivative(along),
            Shape::Cylinder(cylinder) => cylinder.normal_derivative(along),
            Shape::Rectangle(_) | Shape::Disk(_) => DVec3::ZERO,
            Shape::Mesh(mesh) => mesh.normal_derivative(hit.face, hit.barycentric, along),
        }
    }
}
