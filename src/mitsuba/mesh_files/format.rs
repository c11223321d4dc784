//! The formats of mesh files, and a reader for all of them.

use glam::DVec2;

use super::error::MeshFileError;
use super::{obj, ply, serialized};
use crate::geometry::MeshParts;

/// The format of a mesh file. `flip_v`: v becomes 1 - v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ.
    Obj { flip_v: bool },
    /// Stanford PLY, ascii or binary.
    Ply { flip_v: bool },
    /// Mitsuba's compressed meshes, several in a file.
    Serialized { shape_index: u32 },
}

/// Vertices and triangles of a file, in its own space.
///
/// # Errors
///
/// If the bytes are not what the format allows: the place, and what was expected.
pub fn parse(bytes: &[u8], format: Format) -> Result<MeshParts, MeshFileError> {
    let (mut parts, flip_v) = match format {
        Format::Obj { flip_v } => (obj::parse(bytes)?, flip_v),
        Format::Ply { flip_v } => (ply::parse(bytes)?, flip_v),
        Format::Serialized { shape_index } => (serialized::parse(bytes, shape_index)?, false),
    };
    if flip_v {
        for uv in parts.uvs.iter_mut().flatten() {
            *uv = DVec2::new(uv.x, 1.0 - uv.y);
        }
    }
    Ok(parts)
}
