//! Files to be changed at random, and the changes.
#![allow(dead_code)] // each test file uses its own part of this

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use nephroid::geometry::MeshParts;
use proptest::prelude::*;

/// A change to a file: where (as a fraction), what kind, and with what.
pub type Mutation = (f64, u8, Vec<u8>);

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
            5 => {
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

/// A Wavefront file of a mesh.
pub fn obj(mesh: &MeshParts) -> Vec<u8> {
    let mut text = String::new();
    for position in &mesh.positions {
        text += &format!("v {} {} {}\n", position.x, position.y, position.z);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}

/// A Stanford file of a mesh: `ascii` or `binary_little_endian`; binary ones in double precision.
pub fn ply(mesh: &MeshParts, format: &str) -> Vec<u8> {
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    let mut bytes = format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let is_text = format == "ascii";
    for position in &mesh.positions {
        if is_text {
            bytes.extend(format!("{} {} {}\n", position.x, position.y, position.z).bytes());
        } else {
            position
                .to_array()
                .iter()
                .for_each(|x| bytes.extend(x.to_le_bytes()));
        }
    }
    for [a, b, c] in &mesh.triangles {
        if is_text {
            bytes.extend(format!("3 {a} {b} {c}\n").bytes());
        } else {
            bytes.push(3);
            [a, b, c]
                .iter()
                .for_each(|index| bytes.extend(index.to_le_bytes()));
        }
    }
    bytes
}

/// What a serialized file of version 4 holds of a mesh in double precision, not yet compressed.
pub fn serialized_contents(mesh: &MeshParts) -> Vec<u8> {
    let mut bytes = 0x2000_u32.to_le_bytes().to_vec();
    bytes.extend(b"a name\0");
    bytes.extend((mesh.positions.len() as u64).to_le_bytes());
    bytes.extend((mesh.triangles.len() as u64).to_le_bytes());
    for position in &mesh.positions {
        position
            .to_array()
            .iter()
            .for_each(|x| bytes.extend(x.to_le_bytes()));
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
