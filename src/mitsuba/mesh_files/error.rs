//! The error of a file that is not a mesh, and the place in it.

use std::fmt;

use crate::geometry::MeshParts;

/// Reason why a file is not a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshFileError {
    place: FilePlace,
    message: String,
}

/// A place in a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FilePlace {
    /// Counted from 1.
    Line(usize),
    /// Counted from 0.
    Byte(usize),
    /// The file as a whole.
    File,
}

impl MeshFileError {
    pub(super) fn new(place: FilePlace, message: impl Into<String>) -> Self {
        Self {
            place,
            message: message.into(),
        }
    }
}

impl fmt::Display for MeshFileError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            FilePlace::Line(line) => write!(formatter, "line {line}: ")?,
            FilePlace::Byte(byte) => write!(formatter, "byte {byte}: ")?,
            FilePlace::File => {}
        }
        formatter.write_str(&self.message)
    }
}

/// Fails if a triangle refers to a vertex that does not exist.
pub(super) fn check_indices(parts: &MeshParts) -> Result<(), MeshFileError> {
    let count = parts.positions.len();
    for (number, triangle) in parts.triangles.iter().enumerate() {
        if let Some(index) = triangle.iter().find(|index| **index as usize >= count) {
            let message =
                format!("triangle {number} refers to vertex {index}, but there are only {count}");
            return Err(MeshFileError::new(FilePlace::File, message));
        }
    }
    Ok(())
}
