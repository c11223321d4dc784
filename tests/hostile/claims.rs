//! Files that claim more than they hold.

use ::exr::prelude::Compression as Packing;
use flate2::Compression;
use nephroid::internals::film::bitmap::{Bitmap, BitmapEncoding};
use nephroid::internals::film::{Channel, Image};
use nephroid::internals::study::StudyFile;

use super::honest::{Kind, after, written};
use super::watch::{TIMES_HONEST, alone, watched};
use crate::support::geometry::icosphere;
use crate::support::mutation::{PACKINGS, film, serialized, serialized_contents};

#[test]
fn counts_that_a_file_cannot_hold_reserve_nothing() {
    let _alone = alone();
    let header = |format: &str, vertices: u64, faces: u64| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
        )
        .into_bytes()
    };
    let mut cases = Vec::new();
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        cases.push((Kind::AsciiPly, header(format, 1 << 60, 1), "announces"));
        cases.push((Kind::AsciiPly, header(format, 3, 1 << 60), "announces"));
        cases.push((Kind::AsciiPly, header(format, 3, u64::MAX), "announces"));
    }
    // Every face takes a byte at least, says a reader that counts lists as empty.
    let mut padded = header("binary_little_endian", 0, 100_000);
    padded.resize(100_000, 0);
    cases.push((Kind::BinaryPly, padded, "announces 100000"));
    for (vertices, faces) in [
        (u64::from(u32::MAX), 1),
        (3, u64::from(u32::MAX)),
        (1 << 60, 1),
    ] {
        let mut contents = serialized_contents(&icosphere(0));
        contents[11..19].copy_from_slice(&vertices.to_le_bytes());
        contents[19..27].copy_from_slice(&faces.to_le_bytes());
        let expected = if vertices == 1 << 60 {
            "more than 32 bits"
        } else {
            "announces"
        };
        cases.push((
            Kind::Serialized,
            serialized(&contents, Compression::best()),
            expected,
        ));
    }
    for size in [1 << 12, 1 << 14, 1 << 16, 1 << 31] {
        // None, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A: none of them shrinks so much. The crate itself refuses
        // 2³¹.
        let expected = if size == 1 << 31 { "" } else { "claims" };
        for compression in 0..8 {
            for kind in [Kind::Exr, Kind::Film] {
                cases.push((kind, exr_that_claims(size, compression), expected));
            }
        }
    }
    for (kind, bytes, expected) in cases {
        let allowed = TIMES_HONEST * kind.need(&bytes).peak(bytes.len());
        let outcome = kind.load(&bytes);
        let (peak, seconds) = (outcome.peak, outcome.seconds);
        let error = outcome.refusal(expected);
        assert!(error.contains(expected), "{kind:?}: {error}");
        assert!(
            (peak as f64) < allowed,
            "{kind:?}, {error}: {peak} bytes of heap, {allowed} are allowed"
        );
        assert!(seconds < 1.0, "{kind:?}, {error}: {seconds} s");
    }
}

/// A file of one black texel with another number for its compression and a window of `size` x `size`.
fn exr_that_claims(size: i64, compression: u8) -> Vec<u8> {
    let mut image = Image::new(1, 1);
    image.channels.push(Channel {
        name: "Y".to_owned(),
        samples: vec![0.0],
    });
    let mut bytes = written(&image);
    let find = |bytes: &[u8], name: &[u8]| after(bytes, name).unwrap() + 4;
    let at = find(&bytes, b"compression\0compression\0");
    bytes[at] = compression;
    for window in [
        b"dataWindow\0box2i\0".as_slice(),
        b"displayWindow\0box2i\0".as_slice(),
    ] {
        let at = find(&bytes, window);
        let last = i32::try_from(size - 1).unwrap_or(i32::MAX);
        bytes[at..at + 4].copy_from_slice(&0_i32.to_le_bytes());
        bytes[at + 4..at + 8].copy_from_slice(&0_i32.to_le_bytes());
        bytes[at + 8..at + 12].copy_from_slice(&last.to_le_bytes());
        bytes[at + 12..at + 16].copy_from_slice(&last.to_le_bytes());
    }
    bytes
}

/// A file whose windows are so many texels wide, whatever is in it.
fn widened(mut bytes: Vec<u8>, width: i32) -> Vec<u8> {
    for window in [
        b"dataWindow\0box2i\0".as_slice(),
        b"displayWindow\0box2i\0".as_slice(),
    ] {
        let last = after(&bytes, window).unwrap() + 4 + 8;
        bytes[last..last + 4].copy_from_slice(&(width - 1).to_le_bytes());
    }
    bytes
}

/// The table of blocks is that of the narrow image: what is wrong shows only when the blocks are unpacked.
fn assert_that_wide_claims_take_little(packing: Packing) {
    let narrow = film(1, 320, packing, true);
    let (mut most, mut taken_in) = (0.0_f64, 0);
    for width in [2, 20, 200, 2000, 20_000, 200_000] {
        let bytes = widened(narrow.clone(), width);
        let need = Kind::Film.need(&bytes).peak_of_any(bytes.len());
        let outcome = Kind::Film.load(&bytes);
        let times = outcome.peak as f64 / need;
        let error = outcome.refusal("a line of a texel");
        assert!(
            times <= TIMES_HONEST,
            "{packing:?}, {width} texels wide in {} bytes: {times:.1} times the heap of a black image; {error}",
            bytes.len()
        );
        most = most.max(times);
        taken_in += u32::from(!error.contains("claims"));
    }
    println!("{packing:?}: at most {most:.2} times the heap of a black image");
    // Some are not refused by what they claim alone, but unpacked as far as it goes.
    assert!(taken_in > 0, "{packing:?}");
}

#[test]
fn images_that_claim_wider_lines_than_they_hold_take_at_most_four_times_what_black_ones_take() {
    let _alone = alone();
    for packing in PACKINGS.into_iter().filter(|it| *it != Packing::PIZ) {
        assert_that_wide_claims_take_little(packing);
    }
}

/// The reader believes 2¹⁷ bytes of samples for a byte of PIZ, which reaches 410: 855 bytes take 93 MB.
#[test]
fn images_in_piz_that_claim_wider_lines_take_at_most_four_times_what_black_ones_take() {
    let _alone = alone();
    assert_that_wide_claims_take_little(Packing::PIZ);
}

#[test]
fn compressed_zeros_do_not_fill_the_memory() {
    let _alone = alone();
    // 2²⁸ bytes of zeros in 260 kB: a mesh of 2²² vertices, and a name without an end.
    let zeros = vec![0_u8; 1 << 28];
    let mut mesh = 0x1000_u32.to_le_bytes().to_vec();
    mesh.push(0);
    mesh.extend(20_000_000_u64.to_le_bytes());
    mesh.extend(1_u64.to_le_bytes());
    mesh.extend(&zeros);
    let mut name = 0x1000_u32.to_le_bytes().to_vec();
    name.extend(zeros.iter().map(|_| b'x'));
    drop(zeros);
    for (contents, expected) in [
        (mesh, "announces 20000000 vertices"),
        (name, "name has more than"),
    ] {
        let bytes = serialized(&contents, Compression::fast());
        drop(contents);
        let allowed = TIMES_HONEST * Kind::Serialized.need(&bytes).peak(bytes.len());
        let outcome = Kind::Serialized.load(&bytes);
        let peak = outcome.peak;
        let error = outcome.refusal(expected);
        assert!(error.contains(expected), "{error}");
        assert!(
            (peak as f64) < allowed,
            "{error}: {peak} bytes of heap, {allowed} are allowed"
        );
    }
}

/// Pictures of every format whose header claims more than any memory, with a few bytes behind it.
#[test]
fn pictures_that_claim_more_than_they_hold_reserve_nothing() {
    let _alone = alone();
    let size = |claimed: u32| claimed.to_le_bytes();
    let mut bmp = b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0".to_vec();
    bmp.extend([size(60_000), size(60_000)].concat());
    bmp.extend([&[1, 0, 24, 0][..], &[0; 24], &[7; 64]].concat());
    let tga = [
        &[0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0][..],
        &[0xff; 4],
        &[24, 0],
        &[7; 64],
    ]
    .concat();
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n\x02\x02\xea\x60".to_vec();
    for (name, bytes, says) in [
        (
            "PNM",
            b"P6 60000 60000 255\nabc".to_vec(),
            "allowed are up to 268435456",
        ),
        (
            "PNM",
            b"P4 16000 16000\nabc".to_vec(),
            "allowed are 8 for each",
        ),
        (
            "PNM",
            b"P5 16000 16000 65535\nabc".to_vec(),
            "claims 16000 x 16000 texels, which take 512000000 bytes",
        ),
        ("BMP", bmp, "claims 60000 x 60000"),
        ("TGA", tga, "claims 65535 x 65535"),
        ("HDR", hdr, "claims 60000 x 60000"),
    ] {
        let length = bytes.len();
        let outcome = watched(name, move || {
            Bitmap::read(&bytes, BitmapEncoding::Raw).map(drop)
        });
        let peak = outcome.peak;
        let error = outcome.refusal(name);
        assert!(error.contains(says), "{name}: {error}");
        // Buffers of readers; what it claims is a thousand times as much.
        assert!(peak < 100_000, "{name}: {peak} bytes of heap for {length}");
    }
}

/// A line of a study can ask for a thousand runs.
#[test]
fn studies_of_more_runs_than_anyone_means_are_refused() {
    let _alone = alone();
    let line = "[[method]]\nmethod = \"photons\"\nseed = { from = 1, to = 1000, step = 1 }\n";
    let of = |methods: usize| format!("scene = \"a.xml\"\n{}", line.repeat(methods));
    assert!(StudyFile::parse("a.toml".as_ref(), &of(10)).is_ok());
    let many = of(1000);
    let outcome = watched("a study", move || {
        StudyFile::parse("a.toml".as_ref(), &many)
            .map(drop)
            .map_err(|error| error.to_string())
    });
    let peak = outcome.peak;
    let error = outcome.refusal("a study");
    assert!(error.contains("more than 10000 runs"), "{error}");
    // Of a million runs, which would take hundreds of megabytes, eleven thousand were listed.
    assert!(peak < 32_000_000, "{peak} bytes of heap");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.toml");
    std::fs::write(&path, "#".repeat((1 << 20) + 1)).unwrap();
    let error = StudyFile::read(&path).unwrap_err().to_string();
    assert!(
        error.contains("long.toml") && error.contains("1048576 bytes"),
        "{error}"
    );
}
