//! Triangle meshes. (Contract; bodies being built.)

use glam::{DVec2, DVec3};

/// What a mesh file or generator gives; world space.
#[derive(Clone, Debug, Default)]
pub struct MeshParts {
    /// World space.
    pub positions: Vec<DVec3>,
    /// Indices into `positions`; counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One a position where the file has them (already in world space, any length).
    pub normals: Option<Vec<DVec3>>,
    /// One a position where the file has them.
    pub uvs: Option<Vec<DVec2>>,
    /// Ignore `normals` and make none.
    pub face_normals: bool,
    /// Turn all normals round.
    pub flip_normals: bool,
}

/// Triangles over shared vertices, checked.
#[derive(Clone, Debug)]
pub struct Mesh;

/// Why parts do not make a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not finite")]
    VertexNotFinite {
        /// Counted from 0.
        vertex: usize,
    },
}

/// What is odd about a mesh; counts with an example each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshDiagnostics;

impl Mesh {
    /// Checks the parts; computes vertex normals as Mitsuba does where the file has none.
    pub fn new(_parts: MeshParts) -> Result<Self, MeshError> {
        todo!()
    }
    /// Open and non-manifold edges, orientation, degenerate faces.
    pub fn diagnose(&self) -> MeshDiagnostics {
        todo!()
    }
    /// How many triangles.
    pub fn triangle_count(&self) -> usize {
        todo!()
    }
}
