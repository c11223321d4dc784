//! Vertex normals for meshes whose files have none.

use glam::DVec3;

use crate::numeric::rotation;

/// One unit normal a vertex: the sum of the adjacent faces' normals, each weighted by the face's angle at the
/// vertex.
///
/// Thürmer and Wüthrich, *Computing vertex normals from polygonal facets*, JGT 3(1), 1998, as in Mitsuba's
/// `recompute_vertex_normals`. Vertices that the file repeats are not joined, so a crease that the file
/// splits stays a crease. Faces of zero area add nothing. A vertex without any other face gets the zero
/// vector, and its faces fall back to their own normals.
pub(super) fn angle_weighted(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let corners = triangle.map(|vertex| positions[vertex as usize]);
        let edge = corners[1] - corners[0];
        let Some(normal) = edge.cross(corners[2] - corners[0]).try_normalize() else {
            continue;
        };
        for i in 0..3 {
            let from = corners[i];
            let angle =
                rotation::angle_between(corners[(i + 1) % 3] - from, corners[(i + 2) % 3] - from);
            normals[triangle[i] as usize] += normal * angle;
        }
    }
    for normal in &mut normals {
        *normal = normal.normalize_or_zero();
    }
    normals
}

/// True if all vertices' normals are those of the faces that they belong to, to rounding: a mesh with flat
/// faces and separate vertices for each, as Mitsuba's `cube`.
pub(super) fn are_those_of_faces(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    normals: &[DVec3],
) -> bool {
    /// A normal through an affine map and a cross product of edges are off by some ten units in the last
    /// place each; normals from a file in single precision are farther apart and stay.
    const ROUNDING: f64 = 1e-13;
    triangles.iter().all(|triangle| {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
        let face = (b - a).cross(c - a).normalize_or_zero();
        triangle
            .iter()
            .all(|&vertex| normals[vertex as usize].distance(face) <= ROUNDING)
    })
}
