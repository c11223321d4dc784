//! Triangle meshes.

mod border;
mod colors;
mod diagnostics;
mod fans;
mod hash;
mod local;
mod normals;
mod parts;
mod silhouette;
mod triangles;
mod weld;

pub use border::MeshBorder;
pub use diagnostics::{Finding, MeshDiagnostics};
pub use fans::VertexFans;
pub use parts::{MeshError, MeshParts};
pub use triangles::Mesh;
