//! Mesh files become vertices and triangles.
//!
//! All numbers of a file are kept as `f64`: decimal text loses nothing, where Mitsuba rounds to
//! single precision. What a header announces is never trusted beyond what the file can hold.

mod cube;
mod obj;
mod ply;
mod ply_header;
mod serialized;

use std::fmt;

use glam::DVec2;

use crate::geometry::MeshParts;

pub use cube::cube;

/// How to read a mesh file. `flip_v`: v becomes 1 - v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ.
    Obj { flip_v: bool },
    /// Stanford PLY, ascii or binary.
    Ply { flip_v: bool },
    /// Mitsuba's compressed meshes, several in a file.
    Serialized { shape_index: u32 },
}

/// Why a file is not a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshFileError {
    place: Place,
    message: String,
}

/// Where in a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Counted from 1.
    Line(usize),
    /// Counted from 0.
    Byte(usize),
    /// The file as a whole.
    File,
}

impl MeshFileError {
    fn new(place: Place, message: impl Into<String>) -> Self {
        Self {
            place,
            message: message.into(),
        }
    }
}

impl fmt::Display for MeshFileError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Place::Line(line) => write!(formatter, "line {line}: ")?,
            Place::Byte(byte) => write!(formatter, "byte {byte}: ")?,
            Place::File => {}
        }
        formatter.write_str(&self.message)
    }
}

/// Vertices and triangles of a file, in its own space.
///
/// # Errors
///
/// Where the bytes are not what the format allows; the place and what was expected.
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

/// Fails where a triangle refers to a vertex that is not there.
fn check_indices(parts: &MeshParts) -> Result<(), MeshFileError> {
    let count = parts.positions.len();
    for (number, triangle) in parts.triangles.iter().enumerate() {
        if let Some(index) = triangle.iter().find(|index| **index as usize >= count) {
            let message =
                format!("triangle {number} refers to vertex {index}, but there are only {count}");
            return Err(MeshFileError::new(Place::File, message));
        }
    }
    Ok(())
}
