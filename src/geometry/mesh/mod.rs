//! Triangle meshes.

mod attributes;
mod border;
mod diagnose;
mod diagnostics;
mod fans;
mod hash;
mod local;
mod lookup;
mod normals;
mod parts;
mod silhouette;
mod triangles;
mod weld;

pub use attributes::{AttributeOf, AttributeValues, MeshAttribute};
pub use border::MeshBorder;
pub use diagnostics::{Finding, MeshDiagnostics};
pub use fans::VertexFans;
pub use parts::{MeshError, MeshParts};
pub use triangles::Mesh;
