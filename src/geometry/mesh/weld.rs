//! Vertices and faces that are the same in space.

use std::collections::hash_map::Entry;

use glam::DVec3;

use super::hash::{Map, Set};

/// For each vertex, the first one at exactly the same position.
pub(super) fn representatives(positions: &[DVec3]) -> Vec<u32> {
    let mut first_at = Map::with_capacity_and_hasher(positions.len(), <_>::default());
    positions
        .iter()
        .enumerate()
        .map(|(vertex, position)| {
            // Adding +0 makes −0 and +0 the same key.
            let key = position.to_array().map(|x| (x + 0.0).to_bits());
            match first_at.entry(key) {
                Entry::Occupied(first) => *first.get(),
                Entry::Vacant(slot) => *slot.insert(vertex as u32),
            }
        })
        .collect()
}

/// True if a face's corners, given as representatives, are at three different positions.
pub(super) fn has_distinct_corners([a, b, c]: [u32; 3]) -> bool {
    a != b && b != c && c != a
}

/// A key that is the same for all faces over the same three vertices, whatever their order.
pub(super) fn key(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// True if the corners, from the lowest on, go up: the same for all orders that wind the same way.
pub(super) fn winding([a, b, c]: [u32; 3]) -> bool {
    // Two of the three steps around the corners go up one way, and one goes up the other way.
    [a < b, b < c, c < a].into_iter().filter(|&up| up).count() == 2
}

/// The faces with three distinct corners, and of those over the same corners only the first.
pub(super) fn distinct_faces(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    let representatives = representatives(positions);
    let mut seen = Set::with_capacity_and_hasher(triangles.len(), <_>::default());
    (0..triangles.len() as u32)
        .filter(|&face| {
            let corners = triangles[face as usize].map(|vertex| representatives[vertex as usize]);
            has_distinct_corners(corners) && seen.insert(key(corners))
        })
        .collect()
}
