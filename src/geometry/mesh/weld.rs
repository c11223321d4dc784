//! Vertices and faces that are the same in space.

use std::{collections::hash_map::Entry, hash::BuildHasher};

use glam::DVec3;
use rayon::prelude::*;

use super::hash::{HashSeed, Map, Set};

/// The bits of a position. Adding +0 makes those of −0 and +0 the same.
fn bits(position: DVec3) -> [u64; 3] {
    position.to_array().map(|x| (x + 0.0).to_bits())
}

/// For each vertex, the first one at exactly the same position.
pub(super) fn representatives(positions: &[DVec3]) -> Vec<u32> {
    let mut first_at = Map::with_capacity_and_hasher(positions.len(), <_>::default());
    positions
        .iter()
        .enumerate()
        .map(|(vertex, position)| match first_at.entry(bits(*position)) {
            Entry::Occupied(first) => *first.get(),
            Entry::Vacant(slot) => *slot.insert(vertex as u32),
        })
        .collect()
}

/// True if a face's corners, given as representatives or places, are at three different positions.
pub(super) fn has_distinct_corners<T: PartialEq>([a, b, c]: [T; 3]) -> bool {
    a != b && b != c && c != a
}

/// A key that is the same for all faces over the same three vertices, whatever their order.
pub(super) fn key<T: Ord>(mut corners: [T; 3]) -> [T; 3] {
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
    // Faces over the same corners have the same sum of hashes. In most meshes none have.
    let seed = HashSeed::default();
    let hashes: Vec<u64> = (positions.par_iter())
        .map(|&position| seed.hash_one(bits(position)))
        .collect();
    let sum = |corners: &[u32; 3]| {
        (corners.iter()).fold(0_u64, |sum, &it| sum.wrapping_add(hashes[it as usize]))
    };
    let mut sums: Vec<u64> = triangles.par_iter().map(sum).collect();
    sums.par_sort_unstable();
    let repeated: Set<u64> = (sums.windows(2))
        .filter(|pair| pair[0] == pair[1])
        .map(|pair| pair[0])
        .collect();
    let mut seen = Set::default();
    (0..)
        .zip(triangles)
        .filter(|(_, corners)| {
            let places = corners.map(|vertex| bits(positions[vertex as usize]));
            let is_alone = || repeated.is_empty() || !repeated.contains(&sum(corners));
            has_distinct_corners(places) && (is_alone() || seen.insert(key(places)))
        })
        .map(|(face, _)| face)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn of_faces_over_the_same_places_only_the_first_is_distinct(
            places in prop::collection::vec(prop::sample::select(vec![-0.0, 0.0, 1.0, 2.0]), 3 * 8),
            triangles in prop::collection::vec([0_u32..8, 0_u32..8, 0_u32..8], 0..40),
        ) {
            let positions: Vec<DVec3> = places.chunks(3).map(DVec3::from_slice).collect();
            let at = |corners: &[u32; 3]| corners.map(|it| positions[it as usize]);
            // The same three places, each once, by trying all orders. As numbers −0 and 0 are the same.
            let is_same = |a: &[u32; 3], b: &[u32; 3]| {
                let ([a, b, c], other) = (at(a), at(b));
                [[a, b, c], [b, c, a], [c, a, b], [c, b, a], [b, a, c], [a, c, b]].contains(&other)
            };
            let expected: Vec<u32> = (0..triangles.len())
                .filter(|&face| {
                    let [a, b, c] = at(&triangles[face]);
                    let has_area = a != b && b != c && c != a;
                    has_area && !triangles[..face].iter().any(|it| is_same(it, &triangles[face]))
                })
                .map(|face| face as u32)
                .collect();
            prop_assert_eq!(distinct_faces(&positions, &triangles), expected);
        }
    }
}
