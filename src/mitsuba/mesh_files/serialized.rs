//! Mitsuba's serialized meshes.
//!
//! A file holds meshes one after the other: each is a header (format 0x041C and version, 16 bits each) and a
//! zlib stream. A table of offsets and their number (32 bits) follow. All numbers are little endian. The
//! format is documented with Mitsuba's plugin `serialized`.

use std::io::Read;

use flate2::read::ZlibDecoder;
use glam::{DVec2, DVec3};

use super::error::{FilePlace, MeshFileError, check_indices};
use crate::geometry::MeshParts;

const FORMAT: u16 = 0x041C;

const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const DOUBLE_PRECISION: u32 = 0x2000;

/// Number of items read at a time: a count in the file reserves no more than this.
const BLOCK: usize = 1 << 14;

/// Largest number of bytes of a mesh for each byte it is compressed to. The dullest of honest meshes, flat
/// grids with constant normals, come to 6. zlib's own limit is 1032, which a file made to exhaust memory
/// reaches.
const MAX_EXPANSION: u64 = 64;

/// Bytes of the longest name. Mitsuba knows no limit, but a file of nothing but a name would be read for
/// minutes.
const LONGEST_NAME: usize = 1 << 16;

/// The mesh with this number, counted from 0.
pub fn parse(bytes: &[u8], shape_index: u32) -> Result<MeshParts, MeshFileError> {
    let version = header(bytes, 0)?;
    let start = if shape_index == 0 {
        0
    } else {
        offset(bytes, version, shape_index)?
    };
    header(bytes, start)?;
    let mut stream = MeshStream {
        start,
        compressed: bytes.len() - start - 4,
        decoder: ZlibDecoder::new(&bytes[start + 4..]),
    };
    let flags = u32::from_le_bytes(stream.take()?);
    if version == 4 {
        stream.skip_name()?;
    }
    let vertex_count = stream.count("vertices")?;
    let triangle_count = stream.count("triangles")?;
    let is_double = flags & DOUBLE_PRECISION != 0;
    stream.check_room(vertex_count, triangle_count, flags)?;
    let positions = stream.vectors(vertex_count, is_double)?;
    let normals = (flags & HAS_NORMALS != 0)
        .then(|| stream.vectors(vertex_count, is_double))
        .transpose()?;
    let uvs = (flags & HAS_UVS != 0)
        .then(|| stream.floats::<2>(vertex_count, is_double))
        .transpose()?;
    if flags & HAS_COLORS != 0 {
        stream.floats::<3>(vertex_count, is_double)?;
    }
    let parts = MeshParts {
        positions,
        normals,
        uvs: uvs.map(|uvs| uvs.into_iter().map(DVec2::from_array).collect()),
        triangles: stream.triangles(triangle_count)?,
        face_normals: flags & FACE_NORMALS != 0,
        ..MeshParts::default()
    };
    check_indices(&parts)?;
    Ok(parts)
}

/// The version at a mesh's beginning.
fn header(bytes: &[u8], start: usize) -> Result<u16, MeshFileError> {
    let fail = |message: String| Err(MeshFileError::new(FilePlace::Byte(start), message));
    let Some([f0, f1, v0, v1]) = bytes
        .get(start..)
        .and_then(|bytes| bytes.first_chunk().copied())
    else {
        return fail("the file ends before a mesh's header".to_owned());
    };
    let (format, version) = (u16::from_le_bytes([f0, f1]), u16::from_le_bytes([v0, v1]));
    match (format, version) {
        (FORMAT, 3 | 4) => Ok(version),
        (FORMAT, _) => fail(format!("version {version} is not known; known are 3 and 4")),
        _ => fail(format!(
            "not a serialized mesh: it begins with {format:#06x}, not {FORMAT:#06x}"
        )),
    }
}

/// The byte at which a mesh begins, from the table at the end: 64 bits each in version 4, 32 in version 3.
fn offset(bytes: &[u8], version: u16, shape_index: u32) -> Result<usize, MeshFileError> {
    let table_end = bytes.len().saturating_sub(4);
    let fail = |message: String| MeshFileError::new(FilePlace::Byte(table_end), message);
    let count = bytes
        .last_chunk()
        .map_or(0, |count| u32::from_le_bytes(*count));
    if shape_index >= count {
        return Err(fail(format!(
            "shape_index {shape_index} is too large: the file holds {count} meshes"
        )));
    }
    let size = if version == 4 { 8 } else { 4 };
    let back = u64::from(count - shape_index) * size;
    let entry = usize::try_from(back)
        .ok()
        .and_then(|back| table_end.checked_sub(back));
    let entry = entry.ok_or_else(|| {
        fail(format!(
            "the file is too short for a table of {count} meshes"
        ))
    })?;
    let mut wide = [0; 8];
    wide[..size as usize].copy_from_slice(&bytes[entry..entry + size as usize]);
    let offset = usize::try_from(u64::from_le_bytes(wide))
        .ok()
        .filter(|offset| *offset < bytes.len());
    offset.ok_or_else(|| {
        MeshFileError::new(
            FilePlace::Byte(entry),
            "the table points behind the end of the file",
        )
    })
}

/// The decompressed contents of a mesh.
struct MeshStream<'a> {
    start: usize,
    /// Number of bytes that follow the mesh's header.
    compressed: usize,
    decoder: ZlibDecoder<&'a [u8]>,
}

impl MeshStream<'_> {
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), MeshFileError> {
        self.decoder.read_exact(buffer).map_err(|error| {
            let message = format!("the mesh that begins here cannot be decompressed: {error}");
            MeshFileError::new(FilePlace::Byte(self.start), message)
        })
    }

    /// Skips the shape's name, with the zero at its end.
    fn skip_name(&mut self) -> Result<(), MeshFileError> {
        for _ in 0..=LONGEST_NAME {
            if self.take::<1>()? == [0] {
                return Ok(());
            }
        }
        let message = format!("the mesh's name has more than {LONGEST_NAME} bytes");
        Err(MeshFileError::new(FilePlace::Byte(self.start), message))
    }

    /// Fails if the mesh announces more than the compressed bytes can hold.
    fn check_room(
        &self,
        vertices: usize,
        triangles: usize,
        flags: u32,
    ) -> Result<(), MeshFileError> {
        let numbers = [(HAS_NORMALS, 3), (HAS_UVS, 2), (HAS_COLORS, 3)]
            .iter()
            .filter(|(flag, _)| flags & flag != 0)
            .fold(3, |sum, (_, numbers)| sum + numbers);
        let size = if flags & DOUBLE_PRECISION == 0 { 4 } else { 8 };
        // Both counts are below 2³², so nothing overflows.
        let needed = vertices as u64 * numbers * size + triangles as u64 * 12;
        if needed / MAX_EXPANSION <= self.compressed as u64 {
            return Ok(());
        }
        let message = format!(
            "the mesh announces {vertices} vertices and {triangles} triangles, but only {} bytes follow; {MAX_EXPANSION} bytes for each are allowed",
            self.compressed
        );
        Err(MeshFileError::new(FilePlace::Byte(self.start), message))
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], MeshFileError> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn count(&mut self, what: &str) -> Result<usize, MeshFileError> {
        let count = u64::from_le_bytes(self.take()?);
        u32::try_from(count)
            .map(|count| count as usize)
            .map_err(|_| {
                MeshFileError::new(
                    FilePlace::Byte(self.start),
                    format!("{count} {what} are more than 32 bits can number"),
                )
            })
    }

    /// Items of `N * size` bytes, converted by `item`.
    fn items<const N: usize, const SIZE: usize, T>(
        &mut self,
        count: usize,
        item: impl Fn([[u8; SIZE]; N]) -> T,
    ) -> Result<Vec<T>, MeshFileError> {
        let mut items = Vec::with_capacity(count.min(BLOCK));
        let mut buffer = vec![0; BLOCK.min(count) * N * SIZE];
        while items.len() < count {
            let block = BLOCK.min(count - items.len());
            let bytes = &mut buffer[..block * N * SIZE];
            self.fill(bytes)?;
            let (numbers, _) = bytes.as_chunks::<SIZE>();
            let (vectors, _) = numbers.as_chunks::<N>();
            items.extend(vectors.iter().map(|vector| item(*vector)));
        }
        Ok(items)
    }

    fn floats<const N: usize>(
        &mut self,
        count: usize,
        is_double: bool,
    ) -> Result<Vec<[f64; N]>, MeshFileError> {
        if is_double {
            self.items(count, |numbers: [[u8; 8]; N]| {
                numbers.map(f64::from_le_bytes)
            })
        } else {
            self.items(count, |numbers: [[u8; 4]; N]| {
                numbers.map(|bytes| f32::from_le_bytes(bytes).into())
            })
        }
    }

    fn vectors(&mut self, count: usize, is_double: bool) -> Result<Vec<DVec3>, MeshFileError> {
        Ok(self
            .floats(count, is_double)?
            .into_iter()
            .map(DVec3::from_array)
            .collect())
    }

    fn triangles(&mut self, count: usize) -> Result<Vec<[u32; 3]>, MeshFileError> {
        self.items(count, |indices: [[u8; 4]; 3]| {
            indices.map(u32::from_le_bytes)
        })
    }
}

#[cfg(test)]
mod tests;
