//! Triangle meshes as PLY files.

use std::io::{self, Write};

use crate::geometry::MeshParts;

/// Writes a mesh as a binary little-endian PLY file (format version 1.0).
///
/// A vertex holds `x y z`, then `nx ny nz` if the mesh has normals and `u v` if it has UVs, all as `float`. A
/// face holds `vertex_indices` as a `list` of `uchar` 3 and three indices: `ushort` if 65,536 suffice, else
/// `int` (Mitsuba reads both, and the narrow form saves half of the faces' bytes). `comment` becomes the
/// header's comment lines, one for each line of text.
///
/// Coordinates are rounded to the nearest `f32`. Normals and UVs that are not one a position are not written.
///
/// # Errors
///
/// The errors of `out`.
pub fn write_ply(mesh: &MeshParts, comment: &str, out: &mut impl Write) -> io::Result<()> {
    out.write_all(&ply_bytes(mesh, comment))
}

/// The bytes of the file that [`write_ply`] writes.
pub(super) fn ply_bytes(mesh: &MeshParts, comment: &str) -> Vec<u8> {
    let narrow = mesh.positions.len() <= 1 << 16;
    let normals = mesh
        .normals
        .as_ref()
        .filter(|normals| normals.len() == mesh.positions.len());
    let uvs = mesh
        .uvs
        .as_ref()
        .filter(|uvs| uvs.len() == mesh.positions.len());
    let mut names = vec!["x", "y", "z"];
    names.extend(normals.iter().flat_map(|_| ["nx", "ny", "nz"]));
    names.extend(uvs.iter().flat_map(|_| ["u", "v"]));
    let mut bytes = header(mesh, comment, &names, narrow).into_bytes();
    for (i, position) in mesh.positions.iter().enumerate() {
        let normal = normals.map(|normals| normals[i]);
        for coordinate in position.to_array() {
            bytes.extend((coordinate as f32).to_le_bytes());
        }
        for coordinate in normal.iter().flat_map(glam::DVec3::to_array) {
            bytes.extend((coordinate as f32).to_le_bytes());
        }
        for coordinate in uvs.iter().flat_map(|uvs| uvs[i].to_array()) {
            bytes.extend((coordinate as f32).to_le_bytes());
        }
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        for &index in triangle {
            if narrow {
                bytes.extend((index as u16).to_le_bytes());
            } else {
                bytes.extend(index.to_le_bytes());
            }
        }
    }
    bytes
}

fn header(mesh: &MeshParts, comment: &str, coordinates: &[&str], narrow: bool) -> String {
    let mut lines = vec![
        "ply".to_owned(),
        "format binary_little_endian 1.0".to_owned(),
    ];
    lines.extend(comment.lines().map(|line| format!("comment {line}")));
    lines.push(format!("element vertex {}", mesh.positions.len()));
    lines.extend(
        coordinates
            .iter()
            .map(|name| format!("property float {name}")),
    );
    lines.push(format!("element face {}", mesh.triangles.len()));
    let index = if narrow { "ushort" } else { "int" };
    lines.push(format!("property list uchar {index} vertex_indices"));
    lines.push("end_header\n".to_owned());
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;

    fn written(mesh: &MeshParts) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_ply(mesh, "one\ntwo", &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn a_triangle_without_normals_takes_its_header_and_43_bytes() {
        let mesh = MeshParts {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(0.0, 0.1, -2.0)],
            triangles: vec![[0, 1, 2]],
            ..MeshParts::default()
        };
        let bytes = written(&mesh);
        let header = "ply\nformat binary_little_endian 1.0\ncomment one\ncomment two\n\
            element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            element face 1\nproperty list uchar ushort vertex_indices\nend_header\n";
        assert_eq!(&bytes[..header.len()], header.as_bytes());
        let body = &bytes[header.len()..];
        assert_eq!(body.len(), 3 * 12 + 1 + 3 * 2);
        assert_eq!(body[28..32], 0.1_f32.to_le_bytes());
        assert_eq!(body[36..], [3, 0, 0, 1, 0, 2, 0]);
    }

    #[test]
    fn uvs_follow_a_vertexs_position_and_normal() {
        let mesh = MeshParts {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            normals: Some(vec![DVec3::Z; 3]),
            uvs: Some(vec![DVec2::ZERO, DVec2::X, DVec2::new(0.25, 1.0)]),
            triangles: vec![[0, 1, 2]],
            ..MeshParts::default()
        };
        let bytes = written(&mesh);
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("property float nz\nproperty float u\nproperty float v\nelement"));
        let body = &bytes[bytes.len() - (3 * 32 + 7)..];
        assert_eq!(body[88..92], 0.25_f32.to_le_bytes());
        assert_eq!(body[92..96], 1.0_f32.to_le_bytes());
    }

    #[test]
    fn more_vertices_than_a_ushort_counts_take_wide_indices() {
        let mesh = MeshParts {
            positions: vec![DVec3::Z; 65_537],
            normals: Some(vec![DVec3::X; 65_537]),
            triangles: vec![[0, 1, 65_536]],
            ..MeshParts::default()
        };
        let bytes = written(&mesh);
        assert_eq!(
            bytes[bytes.len() - 13..],
            [3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0]
        );
    }
}
