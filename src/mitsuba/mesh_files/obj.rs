//! Wavefront OBJ.
//!
//! As in Mitsuba, a whole file is one mesh, whatever its groups and materials. Corners with the same
//! position, texture coordinate and normal become one vertex; polygons become fans.
//!
//! The reader is our own. The crate tobj splits a file into a mesh a group, which opens edges between groups,
//! and reports no line numbers. It is the oracle of a test.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::error::{FilePlace, MeshFileError};
use crate::geometry::MeshParts;

/// Mark for no texture coordinate, no normal, or the end of a chain.
const NONE: u32 = u32::MAX;
/// Number of vertices that may share a position before a hash table takes over from the chain. The chain is
/// faster for the handful that meshes have; the table keeps hostile files from quadratic time.
const LONGEST_CHAIN: usize = 16;

/// The vertices and triangles of an OBJ file.
pub fn parse(bytes: &[u8]) -> Result<MeshParts, MeshFileError> {
    let mut reader = ObjReader::default();
    for (number, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        reader
            .line(line)
            .map_err(|message| MeshFileError::new(FilePlace::Line(number + 1), message))?;
    }
    if reader.triangles.is_empty() {
        return Err(MeshFileError::new(FilePlace::File, "holds no faces"));
    }
    Ok(reader.finish())
}

#[derive(Default)]
struct ObjReader {
    positions: Vec<DVec3>,
    uvs: Vec<DVec2>,
    normals: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    corners: Corners,
}

/// A corner of a face: position, texture coordinate, normal.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct ObjCorner {
    position: u32,
    uv: u32,
    normal: u32,
}

/// The distinct corners: each is a vertex, numbered in the order of first use.
#[derive(Default)]
struct Corners {
    list: Vec<ObjCorner>,
    /// The next vertex with the same position.
    next: Vec<u32>,
    /// The first vertex with a position.
    first: Vec<u32>,
    beyond_chains: HashMap<ObjCorner, u32>,
}

impl Corners {
    fn vertex(&mut self, corner: ObjCorner) -> Result<u32, String> {
        let position = corner.position as usize;
        if self.first.len() <= position {
            self.first.resize(position + 1, NONE);
        }
        let mut vertex = self.first[position];
        let mut last = NONE;
        for _ in 0..LONGEST_CHAIN {
            if vertex == NONE {
                let new = self.push(corner)?;
                match last {
                    NONE => self.first[position] = new,
                    last => self.next[last as usize] = new,
                }
                return Ok(new);
            }
            if self.list[vertex as usize] == corner {
                return Ok(vertex);
            }
            last = vertex;
            vertex = self.next[vertex as usize];
        }
        if let Some(vertex) = self.beyond_chains.get(&corner) {
            return Ok(*vertex);
        }
        let new = self.push(corner)?;
        self.beyond_chains.insert(corner, new);
        Ok(new)
    }

    fn push(&mut self, corner: ObjCorner) -> Result<u32, String> {
        let new = u32::try_from(self.list.len())
            .ok()
            .filter(|new| *new != NONE);
        let new = new.ok_or("more vertices than 32 bits can number")?;
        self.list.push(corner);
        self.next.push(NONE);
        Ok(new)
    }
}

/// Puts the item that an error is about before its message: its kind, and its number from 0.
fn of(kind: &'static str, index: usize) -> impl Fn(String) -> String {
    move |message| format!("{kind} {index}: {message}")
}

impl ObjReader {
    fn line(&mut self, line: &[u8]) -> Result<(), String> {
        let mut words = line
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => {
                let place = numbers(words).map_err(of("vertex", self.positions.len()))?;
                self.positions.push(DVec3::from_array(place));
            }
            Some(b"vn") => {
                let normal = numbers(words).map_err(of("normal", self.normals.len()))?;
                self.normals.push(DVec3::from_array(normal));
            }
            Some(b"vt") => {
                let uv = numbers(words).map_err(of("texture coordinate", self.uvs.len()))?;
                self.uvs.push(DVec2::from_array(uv));
            }
            Some(b"f") => self.face(words)?,
            // Groups, materials, smoothing, lines, points and comments mean nothing here.
            _ => {}
        }
        Ok(())
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<(), String> {
        let (mut first, mut last, mut count) = (0, 0, 0);
        for word in words {
            let corner = self.corner(word)?;
            let vertex = self.corners.vertex(corner)?;
            match count {
                0 => first = vertex,
                1 => {}
                _ => self.triangles.push([first, last, vertex]),
            }
            last = vertex;
            count += 1;
        }
        if count < 3 {
            return Err(format!("a face needs 3 corners or more, not {count}"));
        }
        Ok(())
    }

    /// A corner: `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: &[u8]) -> Result<ObjCorner, String> {
        let mut parts = word.split(|byte| *byte == b'/');
        let mut index = |count: usize, what: &str| match parts.next() {
            None | Some(b"") => Ok(NONE),
            Some(text) => resolve(text, count, what),
        };
        let corner = ObjCorner {
            position: index(self.positions.len(), "vertex")?,
            uv: index(self.uvs.len(), "texture coordinate")?,
            normal: index(self.normals.len(), "normal")?,
        };
        if corner.position == NONE || parts.next().is_some() {
            return Err(format!(
                "\"{}\" must be v, v/vt, v//vn or v/vt/vn",
                lossy(word)
            ));
        }
        Ok(corner)
    }

    fn finish(self) -> MeshParts {
        let corners = &self.corners.list;
        let position = |corner: &ObjCorner| self.positions[corner.position as usize];
        let normal = |corner: &ObjCorner| {
            self.normals
                .get(corner.normal as usize)
                .copied()
                .unwrap_or_default()
        };
        let uv = |corner: &ObjCorner| {
            self.uvs
                .get(corner.uv as usize)
                .copied()
                .unwrap_or_default()
        };
        MeshParts {
            positions: corners.iter().map(position).collect(),
            normals: (corners.iter().any(|corner| corner.normal != NONE))
                .then(|| corners.iter().map(normal).collect()),
            uvs: (corners.iter().any(|corner| corner.uv != NONE))
                .then(|| corners.iter().map(uv).collect()),
            triangles: self.triangles,
            ..MeshParts::default()
        }
    }
}

/// The index that a number in a file means: from 1 upwards, or from -1 (the latest) downwards.
fn resolve(text: &[u8], count: usize, what: &str) -> Result<u32, String> {
    let number: i64 = parse_word(text)
        .ok_or_else(|| format!("\"{}\" is not a number of a {what}", lossy(text)))?;
    let index = if number < 0 {
        // A file holds far fewer than 2^63 lines.
        number.checked_add_unsigned(count as u64)
    } else {
        number.checked_sub(1)
    };
    match u32::try_from(index.unwrap_or(-1)) {
        Ok(index) if (index as usize) < count => Ok(index),
        _ => Err(format!(
            "refers to {what} {number}, but {count} are known here"
        )),
    }
}

/// The first N numbers; the rest (weights, colours) is ignored.
fn numbers<'a, const N: usize>(
    mut words: impl Iterator<Item = &'a [u8]>,
) -> Result<[f64; N], String> {
    let mut result = [0.0; N];
    for (found, number) in result.iter_mut().enumerate() {
        let word = words
            .next()
            .ok_or_else(|| format!("expected {N} numbers, found {found}"))?;
        let parsed = parse_word(word).filter(|number: &f64| number.is_finite());
        *number = parsed.ok_or_else(|| format!("\"{}\" is not a finite number", lossy(word)))?;
    }
    Ok(result)
}

fn parse_word<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

fn lossy(word: &[u8]) -> String {
    const LIMIT: usize = 40;
    String::from_utf8_lossy(&word[..word.len().min(LIMIT)]).into_owned()
}

#[cfg(test)]
mod tests;
