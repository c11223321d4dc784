//! The faces around each vertex.

use super::triangles::Mesh;

/// The faces that have each vertex of a mesh, by vertex index: two vertices at one position are two, as they
/// may have different normals.
#[derive(Clone, Debug)]
pub struct VertexFans {
    /// Index in `faces` at which a vertex's faces begin; one more entry than vertices.
    first: Vec<u32>,
    /// The faces of each vertex, in ascending order.
    faces: Vec<u32>,
}

impl VertexFans {
    fn new(mesh: &Mesh) -> Self {
        let mut first = vec![0_u32; mesh.positions.len() + 1];
        for vertex in mesh.triangles.iter().flatten() {
            first[*vertex as usize + 1] += 1;
        }
        for vertex in 1..first.len() {
            first[vertex] += first[vertex - 1];
        }
        let mut next = first.clone();
        let mut faces = vec![0; 3 * mesh.triangles.len()];
        for (face, vertices) in mesh.triangles.iter().enumerate() {
            for vertex in vertices {
                let place = &mut next[*vertex as usize];
                faces[*place as usize] = face as u32;
                *place += 1;
            }
        }
        Self { first, faces }
    }

    /// The faces that have a vertex, in ascending order; one that has it twice comes twice.
    #[inline]
    pub fn of(&self, vertex: u32) -> &[u32] {
        let [first, end] = [0, 1].map(|next| self.first[vertex as usize + next] as usize);
        &self.faces[first..end]
    }
}

impl Mesh {
    /// The faces around each vertex.
    pub fn vertex_fans(&self) -> VertexFans {
        VertexFans::new(self)
    }
}
