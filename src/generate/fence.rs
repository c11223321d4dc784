//! Fences.

use glam::DVec3;

use crate::geometry::MeshParts;

/// A pointed board, standing upright; lengths in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picket {
    /// Width.
    pub width: f64,
    /// Height of the point.
    pub height: f64,
    /// The part of the height over which the board narrows to its point.
    pub tip: f64,
    /// Thickness.
    pub thickness: f64,
}

/// A row of `count` boards along y, their middles `spacing` (scene units) apart and the row's at the origin.
///
/// The boards stand on the plane z = 0 and face ±x, without rails. Each is closed, of 16 triangles with flat
/// facets.
pub fn picket_fence(board: Picket, spacing: f64, count: u32) -> MeshParts {
    let half = 0.5 * board.width;
    let shoulder = board.height - board.tip;
    // Counter-clockwise seen from +x.
    let outline = [
        (-half, 0.0),
        (half, 0.0),
        (half, shoulder),
        (0.0, board.height),
        (-half, shoulder),
    ];
    let corners = outline.len() as u32;
    let mut mesh = MeshParts {
        face_normals: true,
        ..MeshParts::default()
    };
    for number in 0..count {
        let middle = spacing * (f64::from(number) - 0.5 * f64::from(count - 1));
        let back = mesh.positions.len() as u32;
        let front = back + corners;
        for x in [-0.5 * board.thickness, 0.5 * board.thickness] {
            mesh.positions
                .extend(outline.map(|(y, z)| DVec3::new(x, middle + y, z)));
        }
        for i in 1..corners - 1 {
            mesh.triangles.push([front, front + i, front + i + 1]);
            mesh.triangles.push([back, back + i + 1, back + i]);
        }
        for i in 0..corners {
            let next = (i + 1) % corners;
            mesh.triangles.push([back + i, back + next, front + next]);
            mesh.triangles.push([back + i, front + next, front + i]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::checks::{assert_closed_and_outward, volume};

    #[test]
    fn a_picket_fence_is_closed_and_has_the_volume_of_its_boards() {
        let board = Picket {
            width: 0.2,
            height: 1.5,
            tip: 0.3,
            thickness: 0.05,
        };
        let fence = picket_fence(board, 0.25, 7);
        assert_eq!(fence.triangles.len(), 7 * 16);
        assert_closed_and_outward(&fence);
        // A rectangle and the triangle of its tip, 0.2 (1.2 + 0.3 / 2), times thickness and count. 112 terms
        // below 0.1 are added, each a few roundings off.
        let exact = 7.0 * 0.05 * 0.2 * 1.35;
        assert!((volume(&fence) - exact).abs() < 1e-13);
    }
}
