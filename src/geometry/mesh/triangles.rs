//! A mesh: its parts, and the surface at any of its points.

use glam::{DVec2, DVec3};

use crate::geometry::{
    Bounds, Hit, Ray, SurfacePoint,
    rounding::{UNIT_ROUNDOFF, gamma},
};
use crate::numeric::morton_code;

use super::{
    attributes::MeshAttribute,
    diagnostics::OnceDiagnosed,
    normals,
    parts::{MeshError, MeshParts, check},
    weld,
};

/// Triangles over shared vertices, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Unit vectors; empty if faces are flat, whether normals were given or not.
    pub(super) normals: Vec<DVec3>,
    /// Empty if the file has none.
    pub(super) uvs: Vec<DVec2>,
    pub(super) attributes: Vec<MeshAttribute>,
    pub(super) flip_normals: bool,
    pub(super) bounds: Bounds,
    pub(super) diagnostics: OnceDiagnosed,
}

impl Mesh {
    /// Checks the parts; computes vertex normals as Mitsuba does if the file has none.
    ///
    /// # Errors
    ///
    /// If a value is not finite or too large, an index is out of range, an attribute is missing for some
    /// vertices, or there are no faces.
    pub fn new(parts: MeshParts) -> Result<Self, MeshError> {
        check(&parts)?;
        let MeshParts {
            positions,
            triangles,
            normals,
            uvs,
            attributes,
            face_normals,
            flip_normals,
        } = parts;
        let normals = match normals {
            _ if face_normals => Vec::new(),
            Some(normals) => {
                let normals: Vec<DVec3> =
                    normals.into_iter().map(DVec3::normalize_or_zero).collect();
                if normals::are_those_of_faces(&positions, &triangles, &normals) {
                    Vec::new()
                } else {
                    normals
                }
            }
            None => normals::angle_weighted(&positions, &triangles),
        };
        // An interpolated point is off by at most 3u of the sum of the magnitudes of its vertices'
        // coordinates. 6u of the largest covers that.
        let exact = Bounds::from_points(
            triangles
                .iter()
                .flatten()
                .map(|&vertex| positions[vertex as usize]),
        );
        let reach = exact.min.abs().max(exact.max.abs()).max_element();
        Ok(Self {
            positions,
            triangles,
            normals,
            uvs: uvs.unwrap_or_default(),
            attributes,
            flip_normals,
            bounds: exact.padded(gamma(6) * reach),
            diagnostics: OnceDiagnosed::default(),
        })
    }

    /// The mesh with its vertices and normals mapped.
    ///
    /// # Errors
    ///
    /// As [`Mesh::new`].
    pub fn mapped(
        &self,
        point: impl Fn(DVec3) -> DVec3,
        normal: impl Fn(DVec3) -> DVec3,
    ) -> Result<Self, MeshError> {
        let has = |some: bool| some.then_some(());
        Self::new(MeshParts {
            positions: self.positions.iter().map(|place| point(*place)).collect(),
            triangles: self.triangles.clone(),
            normals: has(!self.normals.is_empty())
                .map(|()| self.normals.iter().map(|n| normal(*n)).collect()),
            uvs: has(!self.uvs.is_empty()).map(|()| self.uvs.clone()),
            attributes: self.attributes.clone(),
            face_normals: self.normals.is_empty(),
            flip_normals: self.flip_normals,
        })
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The vertices' positions, world space.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The triangles' vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The texture coordinates, one a position; `None` if the mesh has none.
    pub fn uvs(&self) -> Option<&[DVec2]> {
        (!self.uvs.is_empty()).then_some(&*self.uvs)
    }

    /// The unit normals at vertices; empty if faces are flat.
    pub fn vertex_normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// True if all normals are turned round.
    pub fn are_normals_flipped(&self) -> bool {
        self.flip_normals
    }

    /// True if shading normals are interpolated between vertices.
    pub fn has_vertex_normals(&self) -> bool {
        !self.normals.is_empty()
    }

    /// The sum of the faces' areas in square scene units.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len() as u32)
            .map(|face| self.face_area(face))
            .sum()
    }

    /// The area of a face in square scene units.
    #[inline]
    pub fn face_area(&self, face: u32) -> f64 {
        let [a, b, c] = self.corners(face);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Memory held, bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.positions)
            + size_of_val(&*self.triangles)
            + size_of_val(&*self.normals)
            + size_of_val(&*self.uvs)
            + (self.attributes.iter())
                .map(|one| one.values.bytes())
                .sum::<usize>()
    }

    pub(in crate::geometry) fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// 1 if a face that shines does so on the side of its geometric normal, -1 if on the other.
    ///
    /// As in Mitsuba, vertex normals decide. There the interpolated one does so point by point, here their
    /// sum for the whole face: a face is lit on one side, however it is met.
    #[inline]
    pub fn shining_side(&self, face: u32) -> f64 {
        if self.normals.is_empty() {
            return 1.0;
        }
        let triangle = self.triangles[face as usize];
        let [na, nb, nc] = triangle.map(|vertex| self.normals[vertex as usize]);
        let [a, b, c] = self.corners(face);
        let along = (b - a).cross(c - a).dot(na + nb + nc);
        if along < 0.0 { -1.0 } else { 1.0 }
    }

    /// The shading normal of a face, a unit vector, if it is the same all over the face to rounding.
    pub fn even_shading_normal(&self, face: u32) -> Option<DVec3> {
        /// Sums of a few unit vectors, and a quotient by their length.
        const ROUNDING: f64 = 1e-13;
        if self.normals.is_empty() {
            return Some(self.face_normal(face));
        }
        let [a, b, c] = self.triangles[face as usize].map(|vertex| self.normals[vertex as usize]);
        let is_even = a.distance(b).max(a.distance(c)) <= ROUNDING;
        let sign = if self.flip_normals { -1.0 } else { 1.0 };
        is_even.then_some(a * sign)
    }

    /// The unit geometric normal of a face; zero for a face without area.
    pub fn face_normal(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.corners(face);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if self.flip_normals { -normal } else { normal }
    }

    /// The positions of a face's vertices.
    #[inline]
    pub fn corners(&self, face: u32) -> [DVec3; 3] {
        self.triangles[face as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// All faces along the Morton curve through their middles: near ones mostly near each other.
    pub fn faces_by_place(&self) -> Vec<u32> {
        let size = self.bounds.max - self.bounds.min;
        let place = |face: u32| {
            let [a, b, c] = self.corners(face);
            morton_code(((a + b + c) / 3.0 - self.bounds.min) / size)
        };
        let mut faces: Vec<u32> = (0..self.triangles.len() as u32).collect();
        faces.sort_by_cached_key(|&face| (place(face), face));
        faces
    }

    /// For each vertex the first one at exactly the same position.
    pub fn welded_vertices(&self) -> Vec<u32> {
        weld::representatives(&self.positions)
    }

    /// A bound on the absolute error, per axis, of the position of any hit on a face.
    pub fn position_error(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.corners(face);
        let (ab, ac) = (b - a, c - a);
        let reach = ab.abs().max(ac.abs()).max((ac - ab).abs()).element_sum();
        let farthest = a.abs().max(b.abs()).max(c.abs());
        UNIT_ROUNDOFF * (farthest + plane_error(reach, ab.cross(ac).length()) * reach)
    }

    /// The faces that a search needs: those with three distinct positions, and of several with the same three
    /// positions only the lowest-numbered.
    pub fn distinct_faces(&self) -> Vec<u32> {
        weld::distinct_faces(&self.positions, &self.triangles)
    }

    /// The surface at a hit, whose barycentric weights place it on the face.
    ///
    /// As in Mitsuba, the geometric normal follows the winding alone, even if the vertex normals point to the
    /// other side; `flip_normals` turns both around.
    #[inline]
    pub(in crate::geometry) fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.at_barycentric(hit.face, hit.barycentric, -ray.direction)
    }

    /// The surface at barycentric weights (of the second and third vertex) of a face.
    ///
    /// `fallback` is the unit normal of a face that has neither area nor vertex normals.
    #[inline]
    pub fn at_barycentric(&self, face: u32, barycentric: DVec2, fallback: DVec3) -> SurfacePoint {
        let triangle = self.triangles[face as usize];
        let [a, b, c] = triangle.map(|vertex| self.positions[vertex as usize]);
        let (b1, b2) = (barycentric.x, barycentric.y);
        let b0 = 1.0 - b1 - b2;
        let (ab, ac) = (b - a, c - a);
        let interpolated = if self.normals.is_empty() {
            None
        } else {
            let [na, nb, nc] = triangle.map(|vertex| self.normals[vertex as usize]);
            (na * b0 + nb * b1 + nc * b2).try_normalize()
        };
        let cross = ab.cross(ac);
        let twice_area = cross.length();
        let normal = if twice_area > 0.0 {
            cross / twice_area
        } else {
            // A face of zero area, kept so that the mesh stays closed, has no normal of its own.
            interpolated.unwrap_or(fallback)
        };
        let shading = interpolated.unwrap_or(normal);
        let sign = if self.flip_normals { -1.0 } else { 1.0 };
        // For the point itself, the last sum costs u|p|, and differences, products and their sum 4u of the
        // edges. The uncertainty of the plane's distance is added.
        let position = a + (ab * b1 + ac * b2);
        let reach = ab.abs().max(ac.abs()).max((ac - ab).abs()).element_sum();
        SurfacePoint {
            position,
            position_error: UNIT_ROUNDOFF
                * (position.abs() + plane_error(reach, twice_area) * reach),
            geometric_normal: normal * sign,
            shading_normal: shading * sign,
            uv: if self.uvs.is_empty() {
                barycentric
            } else {
                let [ta, tb, tc] = triangle.map(|vertex| self.uvs[vertex as usize]);
                ta * b0 + tb * b1 + tc * b2
            },
        }
    }
}

/// Joint error, in units of u · `reach`, of a point of a face and of the distance that a ray from there finds
/// to the face's plane. `reach` is the L1 norm of the longest edges, `twice_area` that of the face.
///
/// The point costs 4. The ray finds the distance from differences to the vertices (1), their shear (3),
/// products (2) and their sums (3): 13 in all, and 16 for margin. An error in a vertex' image moves the plane
/// no farther than the vertex.
///
/// But the edge functions' own products are rounded by u rᵢ rⱼ (r: distances of the vertices). Each is
/// multiplied by the third vertex' depth and divided by the image's area: 3 r₁ r₂ r₃ / (2 A), with r₁ r₂ r₃
/// at most 4/27 of the longest edge's cube on a sliver. That makes 4/9, times 3 if the ray runs along a
/// diagonal of space, whose shear stretches the image by √3 each way. The image's area is less than the
/// face's by a cosine; the distance to the plane is less than that along the ray by the same cosine: these
/// cancel.
#[inline]
fn plane_error(reach: f64, twice_area: f64) -> f64 {
    let thin = 13.0 + 1.5 * reach * reach / twice_area;
    // No ray hits a face without area; the distance to one of almost no area is uncertain by its own length.
    if thin.is_finite() {
        thin.clamp(16.0, 1.0 / UNIT_ROUNDOFF)
    } else {
        16.0
    }
}
