//! Mitsuba's cube.

use glam::{DVec2, DVec3};

use crate::geometry::MeshParts;

/// The normal of each side, and its corners. Their order is that of Mitsuba's `cube`, so that indices and (u,
/// v) agree.
#[rustfmt::skip]
const SIDES: [([i8; 3], [[i8; 3]; 4]); 6] = [
    ([0, -1, 0], [[1, -1, -1], [1, -1, 1], [-1, -1, 1], [-1, -1, -1]]),
    ([0, 1, 0], [[1, 1, -1], [-1, 1, -1], [-1, 1, 1], [1, 1, 1]]),
    ([1, 0, 0], [[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]]),
    ([0, 0, 1], [[1, -1, 1], [1, 1, 1], [-1, 1, 1], [-1, -1, 1]]),
    ([-1, 0, 0], [[-1, -1, 1], [-1, 1, 1], [-1, 1, -1], [-1, -1, -1]]),
    ([0, 0, -1], [[1, 1, -1], [1, -1, -1], [-1, -1, -1], [-1, 1, -1]]),
];

/// The (u, v) of each side's corners.
const UVS: [[f64; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];

/// The cube [-1, 1]³ in 12 triangles with outward normals; each side has its own four vertices.
pub fn cube() -> MeshParts {
    let vector = |[x, y, z]: [i8; 3]| DVec3::new(x.into(), y.into(), z.into());
    let mut parts = MeshParts::default();
    let (mut normals, mut uvs) = (Vec::new(), Vec::new());
    for (normal, corners) in SIDES {
        let first = parts.positions.len() as u32;
        parts
            .triangles
            .extend([[0, 1, 2], [3, 0, 2]].map(|corners| corners.map(|corner| first + corner)));
        parts.positions.extend(corners.map(vector));
        normals.extend([vector(normal); 4]);
        uvs.extend(UVS.map(DVec2::from_array));
    }
    parts.normals = Some(normals);
    parts.uvs = Some(uvs);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_triangle_faces_outward_and_the_sides_close_the_cube() {
        let cube = cube();
        let normals = cube.normals.as_ref().unwrap();
        let mut area = DVec3::ZERO;
        let mut volume = 0.0;
        for triangle in &cube.triangles {
            let [a, b, c] = triangle.map(|index| cube.positions[index as usize]);
            let doubled = (b - a).cross(c - a);
            assert_eq!(doubled, 4.0 * normals[triangle[0] as usize]);
            area += doubled;
            volume += a.dot(doubled) / 6.0;
        }
        assert_eq!((area, volume), (DVec3::ZERO, 8.0));
    }
}
