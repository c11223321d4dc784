//! A block of quads.

use glam::DVec3;

use crate::geometry::MeshParts;

/// A block from `min` to `max` of 12 triangles: corner i is at the upper end of an axis if i has the axis'
/// bit.
pub(super) fn block(min: DVec3, max: DVec3) -> MeshParts {
    let corner = |i: u32| {
        DVec3::from_array(std::array::from_fn(|axis| {
            if (i >> axis) & 1 == 0 {
                min[axis]
            } else {
                max[axis]
            }
        }))
    };
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    MeshParts {
        positions: (0..8).map(corner).collect(),
        triangles: quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        face_normals: true,
        ..MeshParts::default()
    }
}
