//! Triangles cut into smaller ones, whose neighbours share the vertices on their edges.

use std::collections::HashMap;

/// A vertex of a cut: up to three corners and their weights, whole numbers that add up to the frequency.
///
/// A weight of 0 stands last, with `usize::MAX` as its corner.
pub(super) type Weights = [(usize, u32); 3];

/// Cuts every triangle into `frequency²` (at least 1) of the same orientation.
///
/// Returns the vertices and the triangles. A vertex is known by its weights over corners, so that faces that
/// share an edge share the vertices on it.
pub(super) fn cut(
    faces: impl IntoIterator<Item = [usize; 3]>,
    frequency: u32,
) -> (Vec<Weights>, Vec<[u32; 3]>) {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let mut known: HashMap<Weights, u32> = HashMap::new();
    for face in faces {
        let mut vertex = |i: u32, j: u32| {
            let weights = [(face[0], frequency - i - j), (face[1], i), (face[2], j)];
            let mut key = weights.map(|(corner, weight)| {
                if weight == 0 {
                    (usize::MAX, 0)
                } else {
                    (corner, weight)
                }
            });
            key.sort_unstable();
            *known.entry(key).or_insert_with(|| {
                vertices.push(key);
                vertices.len() as u32 - 1
            })
        };
        for i in 0..frequency {
            for j in 0..frequency - i {
                triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                if i + j + 2 <= frequency {
                    triangles.push([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
                }
            }
        }
    }
    (vertices, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_share_the_vertices_of_their_common_edge() {
        for frequency in [1, 2, 3, 7] {
            let (vertices, triangles) = cut([[0, 1, 2], [2, 1, 3]], frequency);
            assert_eq!(triangles.len(), 2 * (frequency * frequency) as usize);
            // A square grid of corners, cut along its diagonal.
            assert_eq!(vertices.len(), (frequency + 1).pow(2) as usize);
            for weights in vertices {
                assert_eq!(
                    weights.map(|(_, weight)| weight).iter().sum::<u32>(),
                    frequency
                );
            }
        }
    }
}
