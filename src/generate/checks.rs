//! Checks of a closed mesh, for the tests of every generator.

use std::collections::HashMap;

use crate::geometry::MeshParts;

/// The enclosed volume by the divergence theorem: Σ a·(b×c)/6.
pub(super) fn volume(mesh: &MeshParts) -> f64 {
    let sixfold: f64 = mesh
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            a.dot(b.cross(c))
        })
        .sum();
    sixfold / 6.0
}

/// Asserts that every edge is shared by two triangles in opposite senses (corners at one place count as one),
/// that no triangle is degenerate, and that normals and orientation point outward.
pub(super) fn assert_closed_and_outward(mesh: &MeshParts) {
    let mut places = HashMap::new();
    let place: Vec<usize> = mesh
        .positions
        .iter()
        .map(|position| {
            // Adding 0 turns -0 into +0, which is the same place.
            let key = position
                .to_array()
                .map(|coordinate| (coordinate + 0.0).to_bits());
            let next = places.len();
            *places.entry(key).or_insert(next)
        })
        .collect();
    let mut edges: HashMap<(usize, usize), i32> = HashMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| place[i as usize]);
        assert!(a != b && b != c && c != a, "degenerate: {triangle:?}");
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from, to)).or_default() += 1;
        }
    }
    for (&(from, to), &count) in &edges {
        assert_eq!(
            (count, edges.get(&(to, from))),
            (1, Some(&1)),
            "edge {from}-{to}"
        );
    }
    assert!(volume(mesh) > 0.0);
    if let Some(normals) = &mesh.normals {
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let facet = (b - a).cross(c - a);
            for &i in triangle {
                assert!(
                    facet.dot(normals[i as usize]) > 0.0,
                    "normal {i} points inward"
                );
            }
        }
    }
}
