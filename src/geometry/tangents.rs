//! Derivatives of surfaces by their parameters.

use std::f64::consts::{PI, TAU};

use glam::{DMat2, DVec3};

use super::{Hit, Mesh, Shape, SurfacePoint, World};
use crate::numeric::math;

impl World {
    /// The derivatives of the position with respect to u and v, in scene units, as in Mitsuba.
    ///
    /// `point` must be [`World::surface_point`] of `hit`. For a mesh they are those of the face. If it has no
    /// (u, v) or they are degenerate, they are any two tangents of length 1. At a sphere's pole and a disk's
    /// center one of them vanishes; its direction is then that of the side at which the azimuth is 0.
    pub fn tangents(&self, hit: &Hit, point: &SurfacePoint) -> [DVec3; 2] {
        match &self.shapes()[hit.shape as usize] {
            Shape::Sphere(sphere) => sphere.tangents(point.uv),
            Shape::Rectangle(rectangle) => rectangle.edges(),
            Shape::Disk(disk) => {
                let [x, y] = disk.half_axes();
                let (sin, cos) = math::sin_cos(TAU * point.uv.y);
                [x * cos + y * sin, (y * cos - x * sin) * (TAU * point.uv.x)]
            }
            Shape::Cylinder(cylinder) => cylinder.tangents(point),
            Shape::Mesh(mesh) => mesh.tangents(hit.face, point.geometric_normal),
        }
    }
}

impl Mesh {
    /// The derivatives from the corners' (u, v): the linear map that takes their differences to those of
    /// positions.
    fn tangents(&self, face: u32, normal: DVec3) -> [DVec3; 2] {
        let across = || {
            let (x, y) = normal.any_orthonormal_pair();
            [x, y]
        };
        let Some(uvs) = self.uvs() else {
            return across();
        };
        let [a, b, c] = self.corners(face);
        let [ta, tb, tc] = self.triangles()[face as usize].map(|vertex| uvs[vertex as usize]);
        let by_weights = DMat2::from_cols(tb - ta, tc - ta);
        let inverse = by_weights.inverse();
        if by_weights.determinant() == 0.0 || !inverse.is_finite() {
            return across();
        }
        let along = |weights: glam::DVec2| (b - a) * weights.x + (c - a) * weights.y;
        [along(inverse.x_axis), along(inverse.y_axis)]
    }
}

impl super::Sphere {
    fn tangents(&self, uv: glam::DVec2) -> [DVec3; 2] {
        let (sin_phi, cos_phi) = math::sin_cos(TAU * uv.x);
        let (sin, cos) = math::sin_cos(PI * uv.y);
        let along_u = self.vector_to_world(DVec3::new(-sin_phi, cos_phi, 0.0)) * (TAU * sin);
        let along_v = self.vector_to_world(DVec3::new(cos * cos_phi, cos * sin_phi, -sin)) * PI;
        [along_u, along_v]
    }
}

impl super::Cylinder {
    fn tangents(&self, point: &SurfacePoint) -> [DVec3; 2] {
        let (sin, cos) = math::sin_cos(TAU * point.uv.x);
        [
            self.vector_to_world(DVec3::new(-sin, cos, 0.0)) * TAU,
            self.axis() * self.length(),
        ]
    }
}
