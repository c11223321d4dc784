//! A mesh near one of its faces: the change of its normals, and coordinates in a face's plane.

use glam::{DVec2, DVec3};

use super::triangles::Mesh;

impl Mesh {
    /// The change ∂n of the shading normal as a point of a face moves by `along` in the face's plane.
    ///
    /// Zero on flat faces. With N the interpolated sum of the vertices' normals, n = N/|N| and ∂n = (∂N −
    /// (n·∂N) n) / |N|.
    pub(in crate::geometry) fn normal_derivative(
        &self,
        face: u32,
        barycentric: DVec2,
        along: DVec3,
    ) -> DVec3 {
        if self.normals.is_empty() {
            return DVec3::ZERO;
        }
        let [a, b, c] = self.corners(face);
        let triangle = self.triangles[face as usize];
        let [na, nb, nc] = triangle.map(|vertex| self.normals[vertex as usize]);
        let DVec2 { x: b1, y: b2 } = barycentric;
        let sum = na * (1.0 - b1 - b2) + nb * b1 + nc * b2;
        let length = sum.length();
        let moved = weights(b - a, c - a, along);
        if length == 0.0 || !moved.is_finite() {
            // Without an interpolated normal the face's own is used, which is constant.
            return DVec3::ZERO;
        }
        let normal = sum / length;
        let change = (nb - na) * moved.x + (nc - na) * moved.y;
        let turned = (change - normal * normal.dot(change)) / length;
        if self.flip_normals { -turned } else { turned }
    }

    /// The weights of a face's second and third vertex for a point of its plane, which may lie beyond its
    /// border; not finite for a face without area.
    pub(in crate::geometry) fn barycentric(&self, face: u32, point: DVec3) -> DVec2 {
        let [a, b, c] = self.corners(face);
        weights(b - a, c - a, point - a)
    }
}

/// The x and y with `across` = x `ab` + y `ac`, up to a part along their normal.
fn weights(ab: DVec3, ac: DVec3, across: DVec3) -> DVec2 {
    let normal = ab.cross(ac);
    let scale = 1.0 / normal.length_squared();
    DVec2::new(
        across.cross(ac).dot(normal) * scale,
        ab.cross(across).dot(normal) * scale,
    )
}
