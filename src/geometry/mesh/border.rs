//! The edges at which a surface ends.

use super::{hash::Map, triangles::Mesh, weld};

/// The edges of a mesh without exactly two faces: those at which it ends, and seams at which more than two
/// meet.
#[derive(Clone, Debug)]
pub struct MeshBorder {
    /// Three bits a face; empty if there is no such edge.
    edges: Vec<u8>,
}

impl MeshBorder {
    fn new(mesh: &Mesh) -> Self {
        let representatives = weld::representatives(&mesh.positions);
        let edges = |face: u32| {
            let [a, b, c] = mesh.triangles[face as usize].map(|v| representatives[v as usize]);
            [[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)])
        };
        let faces = mesh.distinct_faces();
        let mut sharers = Map::<[u32; 2], u32>::default();
        for edge in faces.iter().flat_map(|&face| edges(face)) {
            *sharers.entry(edge).or_insert(0) += 1;
        }
        if sharers.values().all(|&count| count == 2) {
            return Self { edges: Vec::new() };
        }
        let mut bits = vec![0; mesh.triangles.len()];
        for face in faces {
            for (index, edge) in edges(face).into_iter().enumerate() {
                bits[face as usize] |= u8::from(sharers[&edge] != 2) << index;
            }
        }
        Self { edges: bits }
    }

    /// True if the edge from a face's vertex `edge` (0, 1, 2) to the next is one of them.
    #[inline]
    pub fn is_at(&self, face: u32, edge: usize) -> bool {
        self.edges
            .get(face as usize)
            .is_some_and(|bits| bits >> edge & 1 != 0)
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }
}

impl Mesh {
    /// The edges at which the surface ends.
    pub fn border(&self) -> MeshBorder {
        MeshBorder::new(self)
    }
}
