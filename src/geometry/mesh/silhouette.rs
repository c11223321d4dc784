//! The edges along which a mesh's shadow can end.

use glam::DVec3;

use super::{hash::Map, triangles::Mesh};

/// The faces at an edge.
#[derive(Clone, Copy, Default)]
struct Edge {
    faces: u32,
    /// Sum of +1 for each face to the left of the edge as the viewer sees it, −1 for each to the right.
    sides: i32,
    /// True if a face at it is seen edge-on.
    is_grazed: bool,
}

impl Mesh {
    /// The edges that the mesh's outline can run along, for a viewer: those of which both faces are seen on
    /// the same side, those without exactly two faces, and those of faces that are seen edge-on.
    ///
    /// Between them, a line of sight that moves meets as many faces as before.
    ///
    /// `facing` is positive if the viewer sees a face's corners counter-clockwise, negative if clockwise, and
    /// zero if edge-on.
    pub fn silhouette(&self, facing: impl Fn([DVec3; 3]) -> f64) -> Vec<[DVec3; 2]> {
        let representatives = self.welded_vertices();
        let mut edges = Map::<[u32; 2], Edge>::default();
        for face in self.distinct_faces() {
            let seen = facing(self.corners(face));
            let [a, b, c] = self.triangles()[face as usize].map(|v| representatives[v as usize]);
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let edge = edges.entry([from.min(to), from.max(to)]).or_default();
                edge.faces += 1;
                // NaN is neither: such a face counts as grazed.
                let side = i32::from(seen > 0.0) - i32::from(seen < 0.0);
                edge.sides += if from < to { side } else { -side };
                edge.is_grazed |= side == 0;
            }
        }
        let is_outline = |edge: &Edge| edge.faces != 2 || edge.sides != 0 || edge.is_grazed;
        let mut found: Vec<[u32; 2]> = edges
            .into_iter()
            .filter_map(|(ends, edge)| is_outline(&edge).then_some(ends))
            .collect();
        // The map's order changes from run to run.
        found.sort_unstable();
        let place = |vertex: u32| self.positions()[vertex as usize];
        found.into_iter().map(|ends| ends.map(place)).collect()
    }
}
