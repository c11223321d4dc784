//! Stanford PLY, ascii and binary.
//!
//! The element `vertex` gives positions (`x y z`), normals (`nx ny nz`) and texture coordinates (`u v`, `s t`
//! or `texture_u texture_v`). The list `vertex_indices` or `vertex_index` of `face` gives polygons, which
//! become fans. Either may have attributes (see `ply_attributes`). As in Mitsuba, their numbers are taken as
//! they are, whole ones too. Everything else is skipped.

use glam::{DVec2, DVec3};

use super::error::{FilePlace, MeshFileError, check_indices};
use super::ply_attributes::{self, AttributeColumns};
use super::ply_header::{self, PlyElement, PlyEncoding, PlyLayout, PlyScalar};
use crate::geometry::{AttributeOf, AttributeValues, MeshAttribute, MeshParts};
use crate::mitsuba::files::line_ends;

/// The vertices and triangles of a PLY file.
pub fn parse(bytes: &[u8]) -> Result<MeshParts, MeshFileError> {
    let header = ply_header::parse(bytes)?;
    let body = &bytes[header.body..];
    match header.encoding {
        PlyEncoding::Ascii => read(
            &header.elements,
            Ascii {
                rest: body,
                line: header.lines + 1,
            },
        ),
        PlyEncoding::LittleEndian => read(
            &header.elements,
            Binary::<false> {
                bytes,
                at: header.body,
            },
        ),
        PlyEncoding::BigEndian => read(
            &header.elements,
            Binary::<true> {
                bytes,
                at: header.body,
            },
        ),
    }
}

/// The numbers of a body, one after the other. `f64` holds every type exactly.
trait Numbers {
    fn next(&mut self, scalar: PlyScalar) -> Result<f64, MeshFileError>;
    /// The fewest bytes that a number of a type takes.
    fn least_bytes(scalar: PlyScalar) -> usize;
    /// Number of bytes left.
    fn rest(&self) -> usize;
    fn place(&self) -> FilePlace;
}

struct Ascii<'a> {
    rest: &'a [u8],
    line: usize,
}

impl Numbers for Ascii<'_> {
    fn next(&mut self, _: PlyScalar) -> Result<f64, MeshFileError> {
        let blank = self
            .rest
            .iter()
            .position(|byte| !byte.is_ascii_whitespace())
            .unwrap_or(self.rest.len());
        self.line += line_ends(&self.rest[..blank]);
        self.rest = &self.rest[blank..];
        let end = self
            .rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        let number = std::str::from_utf8(word)
            .ok()
            .and_then(|word| word.parse().ok());
        number.ok_or_else(|| {
            let message = if word.is_empty() {
                "the file ends too early".to_owned()
            } else {
                format!(
                    "\"{}\" is not a number",
                    String::from_utf8_lossy(&word[..word.len().min(40)])
                )
            };
            MeshFileError::new(self.place(), message)
        })
    }

    fn least_bytes(_: PlyScalar) -> usize {
        2 // a digit and a blank
    }

    fn rest(&self) -> usize {
        self.rest.len() + 1 // the last blank may be missing
    }

    fn place(&self) -> FilePlace {
        FilePlace::Line(self.line)
    }
}

struct Binary<'a, const BIG_ENDIAN: bool> {
    bytes: &'a [u8],
    at: usize,
}

impl<const BIG_ENDIAN: bool> Binary<'_, BIG_ENDIAN> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], MeshFileError> {
        let Some(bytes) = self.bytes[self.at..].first_chunk::<N>() else {
            return Err(MeshFileError::new(self.place(), "the file ends too early"));
        };
        self.at += N;
        let mut bytes = *bytes;
        if BIG_ENDIAN {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG_ENDIAN: bool> Numbers for Binary<'_, BIG_ENDIAN> {
    #[inline]
    fn next(&mut self, scalar: PlyScalar) -> Result<f64, MeshFileError> {
        Ok(match scalar {
            PlyScalar::I8 => i8::from_le_bytes(self.take()?).into(),
            PlyScalar::U8 => u8::from_le_bytes(self.take()?).into(),
            PlyScalar::I16 => i16::from_le_bytes(self.take()?).into(),
            PlyScalar::U16 => u16::from_le_bytes(self.take()?).into(),
            PlyScalar::I32 => i32::from_le_bytes(self.take()?).into(),
            PlyScalar::U32 => u32::from_le_bytes(self.take()?).into(),
            PlyScalar::F32 => f32::from_le_bytes(self.take()?).into(),
            PlyScalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn least_bytes(scalar: PlyScalar) -> usize {
        scalar.bytes()
    }

    fn rest(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn place(&self) -> FilePlace {
        FilePlace::Byte(self.at)
    }
}

fn read(elements: &[PlyElement], mut numbers: impl Numbers) -> Result<MeshParts, MeshFileError> {
    let mut parts = MeshParts::default();
    for name in ["vertex", "face"] {
        if !elements.iter().any(|element| element.name == name) {
            return Err(MeshFileError::new(
                FilePlace::File,
                format!("the header declares no element \"{name}\""),
            ));
        }
    }
    for element in elements {
        check_room(element, &numbers)?;
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut numbers, &mut parts)?,
            "face" => read_faces(element, &mut numbers, &mut parts)?,
            _ => skip(element, &mut numbers)?,
        }
    }
    check_indices(&parts)?;
    Ok(parts)
}

/// Fails if the header announces more items than the rest of the file can hold. So the memory reserved is
/// never more than a file of this length may need.
fn check_room<N: Numbers>(element: &PlyElement, numbers: &N) -> Result<(), MeshFileError> {
    let least = |property: &ply_header::PlyProperty| match property.layout {
        PlyLayout::Number(scalar) => N::least_bytes(scalar),
        PlyLayout::List { length, item } => {
            let corners = if is_polygon(property) { 3 } else { 0 };
            N::least_bytes(length) + corners * N::least_bytes(item)
        }
    };
    let each: usize = element.properties.iter().map(least).sum();
    if each > 0 && element.count > numbers.rest() / each {
        let message = format!(
            "the header announces {} of \"{}\", but the file ends before",
            element.count, element.name
        );
        return Err(MeshFileError::new(numbers.place(), message));
    }
    Ok(())
}

/// True if a property is the list of a face's corners.
fn is_polygon(property: &ply_header::PlyProperty) -> bool {
    matches!(property.name.as_str(), "vertex_indices" | "vertex_index")
        && matches!(property.layout, PlyLayout::List { .. })
}

/// The columns of a row with the names of one of some `choices`; `None` if none is there whole.
fn columns<const N: usize>(element: &PlyElement, choices: &[[&str; N]]) -> Option<[usize; N]> {
    choices.iter().find_map(|names| {
        let found = names.map(|name| element.number(name));
        found
            .iter()
            .all(Option::is_some)
            .then(|| found.map(Option::unwrap_or_default))
    })
}

/// Most values of attributes that triangles may have for each byte of their faces. Polygons of ten corners
/// with attributes of a byte have eight.
const MOST_VALUES_A_BYTE: usize = 16;

/// The attributes of an element as they are read.
struct AttributeReader {
    columns: Vec<(AttributeColumns, MeshAttribute)>,
}

impl AttributeReader {
    fn new(element: &PlyElement, of: AttributeOf) -> Self {
        let begin = |(name, columns): (String, AttributeColumns)| {
            let values = match columns {
                AttributeColumns::Number(_) => AttributeValues::Numbers(Vec::new()),
                AttributeColumns::Color(_) => AttributeValues::Colors(Vec::new()),
            };
            (columns, MeshAttribute { name, of, values })
        };
        let found = ply_attributes::find(element).into_iter();
        Self {
            columns: found.map(begin).collect(),
        }
    }

    /// Takes a row's values, until there are `count`.
    fn take(&mut self, row: &[f64], count: usize) {
        for (columns, attribute) in &mut self.columns {
            match (columns, &mut attribute.values) {
                (AttributeColumns::Number(at), AttributeValues::Numbers(values)) => {
                    values.resize(count, row[*at]);
                }
                (AttributeColumns::Color(at), AttributeValues::Colors(values)) => {
                    values.resize(count, at.map(|at| row[at]));
                }
                _ => {}
            }
        }
    }

    fn attributes(self) -> impl Iterator<Item = MeshAttribute> {
        self.columns.into_iter().map(|(_, attribute)| attribute)
    }
}

/// Reads a row's numbers; `polygon` reads the list of a face's corners, which all other lists are skipped
/// beside.
fn read_row<N: Numbers>(
    element: &PlyElement,
    numbers: &mut N,
    row: &mut [f64],
    mut polygon: impl FnMut(&mut N, PlyScalar, PlyScalar) -> Result<(), MeshFileError>,
) -> Result<(), MeshFileError> {
    for (property, value) in element.properties.iter().zip(row) {
        match property.layout {
            PlyLayout::Number(scalar) => *value = numbers.next(scalar)?,
            PlyLayout::List { length, item } if is_polygon(property) => {
                polygon(numbers, length, item)?;
            }
            PlyLayout::List { length, item } => skip_list(numbers, length, item)?,
        }
    }
    Ok(())
}

fn skip_list(
    numbers: &mut impl Numbers,
    length: PlyScalar,
    item: PlyScalar,
) -> Result<(), MeshFileError> {
    for _ in 0..list_length(numbers, length)? {
        numbers.next(item)?;
    }
    Ok(())
}

fn read_vertices(
    element: &PlyElement,
    numbers: &mut impl Numbers,
    parts: &mut MeshParts,
) -> Result<(), MeshFileError> {
    let Some(position) = columns(element, &[["x", "y", "z"]]) else {
        return Err(MeshFileError::new(
            FilePlace::File,
            "element \"vertex\" needs the properties x, y and z",
        ));
    };
    let normal = columns(element, &[["nx", "ny", "nz"]]);
    let uv = columns(
        element,
        &[["u", "v"], ["s", "t"], ["texture_u", "texture_v"]],
    );
    let mut normals = normal.map(|_| Vec::with_capacity(element.count));
    let mut uvs = uv.map(|_| Vec::with_capacity(element.count));
    let mut attributes = AttributeReader::new(element, AttributeOf::Vertices);
    parts.positions.reserve(element.count);
    let mut row = vec![0.0; element.properties.len()];
    for vertex in 0..element.count {
        let place = numbers.place();
        read_row(element, numbers, &mut row, skip_list)?;
        let vector = |at: [usize; 3]| DVec3::from_array(at.map(|at| row[at]));
        let mut is_finite = vector(position).is_finite();
        parts.positions.push(vector(position));
        if let (Some(normals), Some(at)) = (&mut normals, normal) {
            is_finite &= vector(at).is_finite();
            normals.push(vector(at));
        }
        if let (Some(uvs), Some(at)) = (&mut uvs, uv) {
            let uv = DVec2::from_array(at.map(|at| row[at]));
            is_finite &= uv.is_finite();
            uvs.push(uv);
        }
        if !is_finite {
            let message = format!("vertex {vertex} has a number that is not finite");
            return Err(MeshFileError::new(place, message));
        }
        attributes.take(&row, vertex + 1);
    }
    parts.normals = normals;
    parts.uvs = uvs;
    parts.attributes.extend(attributes.attributes());
    Ok(())
}

fn read_faces(
    element: &PlyElement,
    numbers: &mut impl Numbers,
    parts: &mut MeshParts,
) -> Result<(), MeshFileError> {
    if !element.properties.iter().any(is_polygon) {
        return Err(MeshFileError::new(
            FilePlace::File,
            "element \"face\" needs the list vertex_indices",
        ));
    }
    let mut attributes = AttributeReader::new(element, AttributeOf::Faces);
    parts.triangles.reserve(element.count);
    let mut row = vec![0.0; element.properties.len()];
    let all = numbers.rest();
    for face in 0..element.count {
        read_row(element, numbers, &mut row, |numbers, length, item| {
            read_polygon(numbers, length, item, &mut parts.triangles)
        })?;
        // All triangles of a polygon have its values: those of one with many corners are many times those of
        // the file.
        let values = attributes
            .columns
            .len()
            .saturating_mul(parts.triangles.len());
        if values > MOST_VALUES_A_BYTE * (all - numbers.rest()) {
            let message = format!(
                "face {face}: so many corners, by {} attributes, take more than {MOST_VALUES_A_BYTE} values for \
                 each byte of the file; triangles take less",
                attributes.columns.len()
            );
            return Err(MeshFileError::new(numbers.place(), message));
        }
        attributes.take(&row, parts.triangles.len());
    }
    parts.attributes.extend(attributes.attributes());
    Ok(())
}

fn read_polygon(
    numbers: &mut impl Numbers,
    length: PlyScalar,
    item: PlyScalar,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), MeshFileError> {
    let place = numbers.place();
    let count = list_length(numbers, length)?;
    if count < 3 {
        return Err(MeshFileError::new(
            place,
            format!("a face needs 3 corners or more, not {count}"),
        ));
    }
    let first = vertex_index(numbers, item)?;
    let mut last = vertex_index(numbers, item)?;
    for _ in 2..count {
        let next = vertex_index(numbers, item)?;
        triangles.push([first, last, next]);
        last = next;
    }
    Ok(())
}

fn list_length(numbers: &mut impl Numbers, scalar: PlyScalar) -> Result<u32, MeshFileError> {
    whole(numbers, scalar, "the length of a list")
}

fn vertex_index(numbers: &mut impl Numbers, scalar: PlyScalar) -> Result<u32, MeshFileError> {
    whole(numbers, scalar, "the number of a vertex")
}

#[inline]
fn whole(numbers: &mut impl Numbers, scalar: PlyScalar, what: &str) -> Result<u32, MeshFileError> {
    let place = numbers.place();
    let number = numbers.next(scalar)?;
    // For NaN and out of range, the cast saturates or gives 0, so the number does not come back as it was.
    let whole = number as u32;
    if f64::from(whole) == number {
        Ok(whole)
    } else {
        Err(MeshFileError::new(
            place,
            format!("{number} cannot be {what}"),
        ))
    }
}

fn skip(element: &PlyElement, numbers: &mut impl Numbers) -> Result<(), MeshFileError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            match property.layout {
                PlyLayout::Number(scalar) => {
                    numbers.next(scalar)?;
                }
                PlyLayout::List { length, item } => skip_list(numbers, length, item)?,
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
