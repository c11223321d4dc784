//! Files to be changed at random, and the changes.

use std::io::{Cursor, Write};

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression as Packing, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, WritableImage as _, f16,
};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use nephroid::internals::geometry::MeshParts;
use proptest::prelude::*;

/// A change to a file: where (as a fraction), what kind, and with what.
pub type Mutation = (f64, u8, Vec<u8>);

/// The kind of change that makes a number of a text another.
pub const NUMBER: u8 = 5;

/// Numbers that readers stumble over: around what 8, 32 and 64 bits hold, and what is no length.
const NUMBERS: [&str; 12] = [
    "0",
    "-1",
    "1",
    "255",
    "2147483647",
    "4294967295",
    "4294967296",
    "1152921504606846976",
    "18446744073709551615",
    "1e999",
    "nan",
    "1e-320",
];

/// One to four changes; half of them near the beginning, where headers are.
pub fn mutations() -> impl Strategy<Value = Vec<Mutation>> {
    let printable = proptest::collection::vec(
        proptest::sample::select(b" 0159-.e/<>\"=$&;:,#xyz\n".to_vec()),
        1..6,
    );
    let any = proptest::collection::vec(any::<u8>(), 1..6);
    let place = prop_oneof![0.0..1.0_f64, (0.0..1.0_f64).prop_map(|place| place.powi(4))];
    proptest::collection::vec((place, 0_u8..7, prop_oneof![printable, any]), 1..5)
}

/// One change as often as several: more of such files are read to their ends.
pub fn one_or_more_mutations() -> impl Strategy<Value = Vec<Mutation>> {
    let one = mutations().prop_map(|mut changes| {
        changes.truncate(1);
        changes
    });
    prop_oneof![mutations(), one]
}

/// The file with these changes.
pub fn mutate(original: &[u8], mutations: &[Mutation]) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for (place, kind, with) in mutations {
        let at = ((bytes.len() as f64) * place) as usize;
        let end = (at + with.len()).min(bytes.len());
        match kind {
            0 => bytes.truncate(at),
            1 => drop(bytes.splice(at..at, with.iter().copied())),
            2 => drop(bytes.splice(at..end, with.iter().copied())),
            3 => bytes.drain(at..end).for_each(drop),
            // Four bytes become a large number of 32 bits, or the sign of one.
            4 => {
                let end = (at + 4).min(bytes.len());
                let number = [[0xff; 4], [0xff, 0xff, 0xff, 0x7f], [0, 0, 0, 0x80], [0; 4]];
                let number = number[usize::from(with[0]) % 4];
                drop(bytes.splice(at..end, number));
            }
            // The next number in decimal becomes another.
            &NUMBER => {
                let is_digit = |byte: &u8| byte.is_ascii_digit();
                let Some(skipped) = bytes[at..].iter().position(is_digit) else {
                    continue;
                };
                let first = at + skipped;
                let digits = bytes[first..]
                    .iter()
                    .take_while(|byte| is_digit(byte))
                    .count();
                let number = NUMBERS[usize::from(with[0]) % NUMBERS.len()];
                drop(bytes.splice(first..first + digits, number.bytes()));
            }
            // A piece of the file again, somewhere else.
            _ => {
                let piece =
                    original[original.len().min(at / 2)..original.len().min(end * 2)].to_vec();
                drop(bytes.splice(at..at, piece));
            }
        }
    }
    bytes
}

/// A vertex's numbers: its position, then its normal and texture coordinates where the mesh has them.
fn numbers_of(mesh: &MeshParts, vertex: usize) -> Vec<f64> {
    let mut numbers = mesh.positions[vertex].to_array().to_vec();
    if let Some(normals) = &mesh.normals {
        numbers.extend(normals[vertex].to_array());
    }
    if let Some(uvs) = &mesh.uvs {
        numbers.extend(uvs[vertex].to_array());
    }
    numbers
}

/// A Wavefront file of a mesh: its positions first, one a line.
pub fn obj(mesh: &MeshParts) -> Vec<u8> {
    let mut text = String::new();
    for position in &mesh.positions {
        text += &format!("v {} {} {}\n", position.x, position.y, position.z);
    }
    for normal in mesh.normals.iter().flatten() {
        text += &format!("vn {} {} {}\n", normal.x, normal.y, normal.z);
    }
    for uv in mesh.uvs.iter().flatten() {
        text += &format!("vt {} {}\n", uv.x, uv.y);
    }
    let corner = |vertex: u32| {
        let number = vertex + 1;
        match (&mesh.uvs, &mesh.normals) {
            (None, None) => format!("{number}"),
            (Some(_), None) => format!("{number}/{number}"),
            (None, Some(_)) => format!("{number}//{number}"),
            (Some(_), Some(_)) => format!("{number}/{number}/{number}"),
        }
    };
    for face in &mesh.triangles {
        text += &format!("f {}\n", face.map(corner).join(" "));
    }
    text.into_bytes()
}

/// A Stanford file of a mesh: `ascii`, `binary_little_endian` or `binary_big_endian`; binary ones in double
/// precision.
pub fn ply(mesh: &MeshParts, format: &str) -> Vec<u8> {
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    let mut header = format!("ply\nformat {format} 1.0\nelement vertex {vertices}\n");
    let given = [
        (true, ["x", "y", "z"].as_slice()),
        (mesh.normals.is_some(), &["nx", "ny", "nz"]),
        (mesh.uvs.is_some(), &["u", "v"]),
    ];
    for name in given
        .iter()
        .filter(|(is_given, _)| *is_given)
        .flat_map(|(_, names)| *names)
    {
        header += &format!("property double {name}\n");
    }
    header +=
        &format!("element face {faces}\nproperty list uchar int vertex_indices\nend_header\n");
    let mut bytes = header.into_bytes();
    let is_text = format == "ascii";
    let is_big = format == "binary_big_endian";
    for vertex in 0..vertices {
        let numbers = numbers_of(mesh, vertex);
        if is_text {
            let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
            bytes.extend(format!("{}\n", words.join(" ")).bytes());
        } else {
            bytes.extend(numbers.iter().flat_map(|number| {
                if is_big {
                    number.to_be_bytes()
                } else {
                    number.to_le_bytes()
                }
            }));
        }
    }
    for [a, b, c] in &mesh.triangles {
        if is_text {
            bytes.extend(format!("3 {a} {b} {c}\n").bytes());
        } else {
            bytes.push(3);
            bytes.extend([a, b, c].into_iter().flat_map(|index| {
                if is_big {
                    index.to_be_bytes()
                } else {
                    index.to_le_bytes()
                }
            }));
        }
    }
    bytes
}

/// Contents of a serialized file of version 4, a mesh in double precision, not yet compressed.
pub fn serialized_contents(mesh: &MeshParts) -> Vec<u8> {
    let flags = 0x2000 + u32::from(mesh.normals.is_some()) + 2 * u32::from(mesh.uvs.is_some());
    let mut bytes = flags.to_le_bytes().to_vec();
    bytes.extend(b"a name\0");
    bytes.extend((mesh.positions.len() as u64).to_le_bytes());
    bytes.extend((mesh.triangles.len() as u64).to_le_bytes());
    let positions = mesh.positions.iter().flat_map(|p| p.to_array());
    let normals = mesh.normals.iter().flatten().flat_map(|n| n.to_array());
    let uvs = mesh.uvs.iter().flatten().flat_map(|uv| uv.to_array());
    for number in positions.chain(normals).chain(uvs) {
        bytes.extend(number.to_le_bytes());
    }
    for index in mesh.triangles.iter().flatten() {
        bytes.extend(index.to_le_bytes());
    }
    bytes
}

/// A serialized file of one mesh. Stored without compression, a changed byte reaches the reader.
pub fn serialized(contents: &[u8], compression: Compression) -> Vec<u8> {
    let mut bytes = vec![0x1c, 0x04, 0x04, 0x00];
    let mut encoder = ZlibEncoder::new(&mut bytes, compression);
    encoder.write_all(contents).unwrap();
    encoder.finish().unwrap();
    bytes.extend(0_u64.to_le_bytes());
    bytes.extend(1_u32.to_le_bytes());
    bytes
}

/// The ways in which an EXR file may be compressed, but for those that its readers know by name only.
pub const PACKINGS: [Packing; 8] = [
    Packing::Uncompressed,
    Packing::RLE,
    Packing::ZIP1,
    Packing::ZIP16,
    Packing::PIZ,
    Packing::PXR24,
    Packing::B44,
    Packing::B44A,
];

/// An EXR file, black or half of it noise (all noise would not be packed but stored as it is), in the
/// channels R, G and B: of single precision, of half (which alone B44 packs) and of whole numbers.
pub fn film(width: usize, height: usize, compression: Packing, is_black: bool) -> Vec<u8> {
    let noise = |seed: u32| {
        // Knuth's multiplicative hashing: no byte of it repeats soon.
        let bits = move |index: u32| {
            let is_noise = !is_black && (index / 8).is_multiple_of(2);
            u32::from(is_noise) * ((index + seed).wrapping_mul(2_654_435_761) >> 8)
        };
        (0..(width * height) as u32).map(bits)
    };
    let unit = |bits: u32| bits as f32 / 2f32.powi(24);
    let channels = [
        ("B", FlatSamples::F32(noise(1).map(unit).collect())),
        (
            "G",
            FlatSamples::F16(noise(2).map(|bits| f16::from_f32(unit(bits))).collect()),
        ),
        ("R", FlatSamples::U32(noise(3).collect())),
    ];
    let layer = Layer::new(
        (width, height),
        LayerAttributes::default(),
        Encoding {
            compression,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        },
        AnyChannels::sort(
            channels
                .into_iter()
                .map(|(name, samples)| AnyChannel::new(name, samples))
                .collect(),
        ),
    );
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut file)
        .unwrap();
    file.into_inner()
}
