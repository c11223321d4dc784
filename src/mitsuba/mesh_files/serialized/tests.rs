use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::*;

/// Two triangles over four vertices, all attributes.
fn contents(version: u16, is_double: bool, flags: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let precision = if is_double { DOUBLE_PRECISION } else { 0x1000 };
    bytes.extend((flags | precision).to_le_bytes());
    if version == 4 {
        bytes.extend(b"a name\0");
    }
    bytes.extend(4_u64.to_le_bytes());
    bytes.extend(2_u64.to_le_bytes());
    let mut put = |numbers: &[f64]| {
        for number in numbers {
            if is_double {
                bytes.extend(number.to_le_bytes());
            } else {
                bytes.extend((*number as f32).to_le_bytes());
            }
        }
    };
    put(&[0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    if flags & HAS_NORMALS != 0 {
        put(&[0.0, 0.0, 1.0].repeat(4));
    }
    if flags & HAS_UVS != 0 {
        put(&[0.0, 0.25].repeat(4));
    }
    if flags & HAS_COLORS != 0 {
        put(&[0.5, 0.5, 0.5].repeat(4));
    }
    for index in [0_u32, 1, 2, 0, 2, 3] {
        bytes.extend(index.to_le_bytes());
    }
    bytes
}

/// A file of these meshes.
fn file(version: u16, meshes: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut offsets = Vec::new();
    for mesh in meshes {
        offsets.push(bytes.len() as u64);
        bytes.extend(FORMAT.to_le_bytes());
        bytes.extend(version.to_le_bytes());
        let mut encoder = ZlibEncoder::new(&mut bytes, Compression::default());
        encoder.write_all(mesh).unwrap();
        encoder.finish().unwrap();
    }
    for offset in &offsets {
        bytes.extend(&offset.to_le_bytes()[..if version == 4 { 8 } else { 4 }]);
    }
    bytes.extend((offsets.len() as u32).to_le_bytes());
    bytes
}

#[test]
fn every_mesh_of_a_file_is_found_in_both_versions_and_precisions() {
    for version in [3, 4] {
        let meshes = [
            contents(version, false, 0),
            contents(version, true, HAS_NORMALS | HAS_COLORS),
            contents(
                version,
                false,
                HAS_NORMALS | HAS_UVS | HAS_COLORS | FACE_NORMALS,
            ),
        ];
        let bytes = file(version, &meshes);
        let parts: Vec<_> = (0..3).map(|index| parse(&bytes, index).unwrap()).collect();
        for parts in &parts {
            assert_eq!(parts.positions.len(), 4);
            assert_eq!(parts.triangles, [[0, 1, 2], [0, 2, 3]]);
        }
        assert_eq!(parts[0].positions[0].z, f64::from(0.1_f32));
        assert_eq!(parts[1].positions[0].z, 0.1);
        assert_eq!(
            parts
                .iter()
                .map(|parts| parts.normals.is_some())
                .collect::<Vec<_>>(),
            [false, true, true]
        );
        assert_eq!(parts[2].uvs.as_ref().unwrap()[3], DVec2::new(0.0, 0.25));
        assert_eq!(
            parts
                .iter()
                .map(|parts| parts.face_normals)
                .collect::<Vec<_>>(),
            [false, false, true]
        );
    }
}

#[test]
fn a_mesh_that_is_not_there_is_an_error_that_says_how_many_are() {
    let bytes = file(4, &[contents(4, false, 0), contents(4, false, 0)]);
    let error = parse(&bytes, 2).unwrap_err().to_string();
    assert!(
        error.contains("shape_index 2 is too large: the file holds 2 meshes"),
        "{error}"
    );
}

#[test]
fn wrong_headers_and_versions_are_named() {
    assert!(
        parse(b"ply\n", 0)
            .unwrap_err()
            .to_string()
            .contains("not a serialized mesh")
    );
    assert!(
        parse(&[], 0)
            .unwrap_err()
            .to_string()
            .contains("ends before")
    );
    let mut bytes = file(4, &[contents(4, false, 0)]);
    bytes[2] = 5;
    assert!(
        parse(&bytes, 0)
            .unwrap_err()
            .to_string()
            .contains("version 5 is not known")
    );
}

#[test]
fn a_count_that_the_stream_does_not_hold_is_an_error_not_an_allocation() {
    let mut mesh = contents(4, true, 0);
    let count = 4 + "a name\0".len();
    // One vertex more than there are, and more than any compression holds.
    for (vertices, expected) in [
        (5, "cannot be decompressed"),
        (u32::MAX, "announces 4294967295 vertices"),
    ] {
        mesh[count..count + 8].copy_from_slice(&u64::from(vertices).to_le_bytes());
        let error = parse(&file(4, &[mesh.clone()]), 0).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    mesh[count + 4] = 1;
    let error = parse(&file(4, &[mesh]), 0).unwrap_err().to_string();
    assert!(error.contains("more than 32 bits"), "{error}");
}

#[test]
fn every_truncation_and_every_wrong_table_is_an_error_or_another_mesh() {
    let bytes = file(4, &[contents(4, false, 0), contents(4, false, 0)]);
    for length in 0..bytes.len() {
        assert!(parse(&bytes[..length], 1).is_err(), "{length}");
    }
    for place in bytes.len() - 20..bytes.len() {
        for value in [0, 1, 127, 255] {
            let mut changed = bytes.clone();
            changed[place] = value;
            let _ = parse(&changed, 1);
        }
    }
}
