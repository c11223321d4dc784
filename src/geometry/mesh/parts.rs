//! The parts of a mesh, and their checks.

use std::collections::HashSet;

use glam::{DVec2, DVec3};

use super::attributes::{AttributeOf, MeshAttribute};

/// The contents of a mesh file, or of a generated mesh; world space.
#[derive(Clone, Debug, Default)]
pub struct MeshParts {
    /// The vertices' positions, world space.
    pub positions: Vec<DVec3>,
    /// Indices into `positions`; counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One a position if the file has them (already in world space, any length).
    pub normals: Option<Vec<DVec3>>,
    /// One a position if the file has them.
    pub uvs: Option<Vec<DVec2>>,
    /// Numbers by name, each name once.
    pub attributes: Vec<MeshAttribute>,
    /// True to ignore `normals` and make none.
    pub face_normals: bool,
    /// True to turn all normals around.
    pub flip_normals: bool,
}

/// Reason why parts do not make a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not finite")]
    VertexNotFinite {
        /// Counted from 0.
        vertex: usize,
    },
    /// Squares and products of such coordinates overflow.
    #[error(
        "vertex {vertex} has the coordinate {coordinate:e}; allowed are magnitudes up to {LARGEST_COORDINATE:e}"
    )]
    VertexTooFar {
        /// Counted from 0.
        vertex: usize,
        /// The offending value.
        coordinate: f64,
    },
    /// NaN or infinite.
    #[error("the normal of vertex {vertex} is not finite")]
    NormalNotFinite {
        /// Counted from 0.
        vertex: usize,
    },
    /// NaN or infinite.
    #[error("the texture coordinates of vertex {vertex} are not finite")]
    UvNotFinite {
        /// Counted from 0.
        vertex: usize,
    },
    /// An index past the end.
    #[error("face {face} refers to vertex {index}, but there are {vertices} (counted from 0)")]
    IndexOutOfRange {
        /// Counted from 0.
        face: usize,
        /// The offending index.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// Not one value for each vertex, or for each face.
    #[error("{found} {attribute} for {needed} {of}; one each is needed")]
    AttributeCount {
        /// "normals", "texture coordinates" or "values of NAME".
        attribute: String,
        /// Number found.
        found: usize,
        /// "vertices" or "faces".
        of: &'static str,
        /// Number needed.
        needed: usize,
    },
    /// Two attributes of one name.
    #[error("there are two attributes \"{name}\"; each name is allowed once")]
    AttributeTwice {
        /// The name.
        name: String,
    },
    /// No triangle at all.
    #[error("the mesh has no faces")]
    Empty,
    /// More than an index can count.
    #[error("the mesh has {found} {what}; at most {limit} are allowed", limit = u32::MAX)]
    TooLarge {
        /// "vertices" or "faces".
        what: &'static str,
        /// Number found.
        found: usize,
    },
}

/// Beyond this the product of four coordinates (a squared area) overflows.
const LARGEST_COORDINATE: f64 = 1e70;

pub(super) fn check(parts: &MeshParts) -> Result<(), MeshError> {
    let vertices = parts.positions.len();
    for (what, found) in [("vertices", vertices), ("faces", parts.triangles.len())] {
        if found >= u32::MAX as usize {
            return Err(MeshError::TooLarge { what, found });
        }
    }
    if parts.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    for (vertex, position) in parts.positions.iter().enumerate() {
        if !position.is_finite() {
            return Err(MeshError::VertexNotFinite { vertex });
        }
        let coordinate = position.abs().max_element();
        if coordinate > LARGEST_COORDINATE {
            return Err(MeshError::VertexTooFar { vertex, coordinate });
        }
    }
    if let Some(normals) = parts.normals.as_ref().filter(|_| !parts.face_normals) {
        check_count("normals", normals.len(), "vertices", vertices)?;
        if let Some(vertex) = normals.iter().position(|normal| !normal.is_finite()) {
            return Err(MeshError::NormalNotFinite { vertex });
        }
    }
    if let Some(uvs) = &parts.uvs {
        check_count("texture coordinates", uvs.len(), "vertices", vertices)?;
        if let Some(vertex) = uvs.iter().position(|uv| !uv.is_finite()) {
            return Err(MeshError::UvNotFinite { vertex });
        }
    }
    let mut names = HashSet::new();
    for MeshAttribute { name, of, values } in &parts.attributes {
        let (of, needed) = match of {
            AttributeOf::Vertices => ("vertices", vertices),
            AttributeOf::Faces => ("faces", parts.triangles.len()),
        };
        check_count(&format!("values of {name}"), values.len(), of, needed)?;
        if !names.insert(name) {
            let name = name.clone();
            return Err(MeshError::AttributeTwice { name });
        }
    }
    for (face, triangle) in parts.triangles.iter().enumerate() {
        if let Some(&index) = triangle.iter().find(|&&index| index as usize >= vertices) {
            return Err(MeshError::IndexOutOfRange {
                face,
                index,
                vertices,
            });
        }
    }
    Ok(())
}

fn check_count(
    attribute: &str,
    found: usize,
    of: &'static str,
    needed: usize,
) -> Result<(), MeshError> {
    if found == needed {
        Ok(())
    } else {
        Err(MeshError::AttributeCount {
            attribute: attribute.to_owned(),
            found,
            of,
            needed,
        })
    }
}
