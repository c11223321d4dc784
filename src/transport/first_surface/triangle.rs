//! Triangles of coordinates, divided into quarters.

use glam::DVec2;

/// The middles of a triangle's edges, each opposite to the corner of the same index.
#[inline]
pub fn middles([a, b, c]: [DVec2; 3]) -> [DVec2; 3] {
    // Sums commute: the neighbour across the edge gets the same bits.
    [0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b)]
}

/// A triangle's quarters, given its edges' [`middles`]; the one in the middle comes last.
#[inline]
pub fn quarters<T: Copy>([a, b, c]: [T; 3], [bc, ca, ab]: [T; 3]) -> [[T; 3]; 4] {
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
}
