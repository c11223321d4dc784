//! EXR files hold what they were given, bit by bit, in bytes that never change.

use std::path::Path;

use nephroid::internals::film::exr;
use nephroid::internals::film::exr::ExrWriteError;
use nephroid::internals::film::{Image, ImageError, LazyImage, Rounding, atomic};

/// An image of awkward numbers, its channels and keys in no order.
fn awkward() -> Image {
    let (width, height) = (37, 41); // more than two ZIP blocks of 16 lines, the last one short
    let mut image = Image::new(width, height);
    let value = |i: usize, seed: usize| {
        let special = [
            0.0,
            -0.0,
            f64::MIN_POSITIVE,
            1e-45,
            f64::from(f32::MAX),
            f64::INFINITY,
            -1.5,
        ];
        special
            .get(i)
            .copied()
            .unwrap_or(((i * 7919 + seed) % 1009) as f64 / 17.0)
    };
    for (seed, name) in ["E.stderr.R", "LTTD.R", "E.R", "E.count", "E.B", "E.G"]
        .iter()
        .enumerate()
    {
        image.add_scalar(*name, (0..width * height).map(|i| value(i, seed)));
    }
    image.add_metadata("unit", "W/m²");
    for i in 0..30 {
        image.add_metadata(format!("key {i}"), "value".repeat(i));
    }
    image.add_metadata("a key that is longer than thirty-one characters", "");
    image
}

fn sorted(mut image: Image) -> Image {
    image.channels.sort_by(|a, b| a.name.cmp(&b.name));
    image.metadata.sort();
    image
}

#[test]
fn what_was_written_is_read_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("awkward.exr");
    exr::write(&path, &awkward()).unwrap();
    let (got, expected) = (exr::read(&path).unwrap(), sorted(awkward()));
    for (got, expected) in got.channels.iter().zip(&expected.channels) {
        let bits = |samples: &[f32]| samples.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(
            bits(&got.samples),
            bits(&expected.samples),
            "{}",
            expected.name
        );
    }
    assert_eq!(got, expected);
    assert_eq!(got.metadata("unit"), Some("W/m²"));
}

#[test]
fn channels_computed_while_they_are_written_are_those_of_the_whole_image() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lazy.exr");
    let value = |texel: usize| ((texel * 7919) % 1009) as f64 / 17.0;
    let rgb = |texel: usize| [value(texel), -value(texel + 1), value(texel + 2)];
    let mut image = LazyImage::new(19, 18);
    // In a file they are A, E, E.hi and count: no channel is where it was added.
    image.add_rgb("E.hi", rgb, Rounding::Up);
    image.add_scalar("count", |texel| texel as f64);
    image.add_rgb("E", rgb, Rounding::Nearest);
    image.add_rgb("A", rgb, Rounding::Down);
    exr::write_lazily(&path, &image).unwrap();
    let read = exr::read(&path).unwrap();
    assert_eq!(read, sorted(image.to_image()));
    for texel in 0..19 * 18 {
        let sample = |name: &str| read.channel(name).unwrap().samples[texel];
        assert_eq!(sample("count"), texel as f32);
        for (channel, exact) in ["R", "G", "B"].into_iter().zip(rgb(texel)) {
            let of = |layer: &str| sample(&format!("{layer}.{channel}"));
            assert_eq!(of("E"), exact as f32);
            assert!(f64::from(of("A")) <= exact && exact <= f64::from(of("E.hi")));
            assert!(of("A").next_up().next_up() > of("E.hi"));
        }
    }
}

/// Readers that divide by sixteen do not notice a wrong line.
#[test]
fn each_block_of_a_file_says_its_first_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("awkward.exr");
    exr::write(&path, &awkward()).unwrap();
    let bytes = std::fs::read(path).unwrap();
    let offset = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    // The header ends with a table of three blocks, the first of which follows it.
    let table = (0..bytes.len() - 8)
        .find(|at| offset(*at) == at + 24)
        .unwrap();
    let lines = [0, 1, 2].map(|block| {
        let at = offset(table + 8 * block);
        i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    });
    assert_eq!(lines, [0, 16, 32]);
}

#[test]
fn the_same_image_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |threads: usize| {
        let path = folder.path().join(format!("{threads}.exr"));
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        // Thirty keys in a hash map: the chance of the same order by accident is nil.
        pool.install(|| exr::write(&path, &awkward())).unwrap();
        std::fs::read(path).unwrap()
    };
    let expected = bytes(1);
    for threads in [1, 2, 7] {
        assert_eq!(bytes(threads), expected);
    }
}

#[test]
fn infinities_and_nan_survive() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nan.exr");
    let mut image = Image::new(2, 1);
    image.add_scalar("Y", [f64::NAN, f64::NEG_INFINITY]);
    exr::write(&path, &image).unwrap();
    let samples = &exr::read(&path).unwrap().channels[0].samples;
    assert!(samples[0].is_nan());
    assert_eq!(samples[1], f32::NEG_INFINITY);
}

#[test]
fn images_that_a_file_cannot_hold_are_refused_and_the_old_file_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    std::fs::write(&path, "old").unwrap();
    let scalar = |width, height, names: &[&str], count: usize| {
        let mut image = Image::new(width, height);
        for name in names {
            image.add_scalar(*name, vec![0.0; count]);
        }
        image
    };
    let cases = [
        (scalar(0, 2, &["Y"], 0), "0 x 2"),
        (scalar(2, 2, &[], 4), "at least one channel"),
        (scalar(2, 2, &["Y"], 3), "`Y` has 3 samples"),
        (scalar(2, 2, &["Y", "Z", "Y"], 4), "`Y` is given twice"),
        (scalar(2, 2, &[""], 4), "name ``"),
        (scalar(2, 2, &["a\0b"], 4), "name `a"),
    ];
    for (image, message) in cases {
        let error = exr::write(&path, &image).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
        assert!(error.to_string().contains("image.exr"), "{error}");
        assert!(matches!(error, ExrWriteError::Image { .. }));
    }
    let mut twice = scalar(1, 1, &["Y"], 1);
    twice.add_metadata("seed", "1");
    twice.add_metadata("seed", "2");
    assert_eq!(twice.check(), Err(ImageError::Duplicate("seed".to_owned())));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn missing_and_damaged_files_are_errors_that_name_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let missing = exr::read(&folder.path().join("missing.exr")).unwrap_err();
    assert!(missing.to_string().contains("missing.exr"), "{missing}");
    let path = folder.path().join("good.exr");
    exr::write(&path, &awkward()).unwrap();
    let good = std::fs::read(&path).unwrap();
    let bad = folder.path().join("bad.exr");
    for length in [0, 3, 8, 50, good.len() / 2] {
        std::fs::write(&bad, &good[..length]).unwrap();
        let error = exr::read(&bad).unwrap_err();
        assert!(error.to_string().contains("bad.exr"), "{error}");
    }
}

#[test]
fn any_one_byte_may_be_wrong_without_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("good.exr");
    let mut image = Image::new(3, 2);
    image.add_rgb("E", &[[1.0, 2.0, 3.0]; 6]);
    image.add_metadata("seed", "7");
    exr::write(&path, &image).unwrap();
    let good = std::fs::read(&path).unwrap();
    for place in 0..good.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bad = good.clone();
            bad[place] ^= flip;
            std::fs::write(&path, bad).unwrap();
            // Many of these are still good files, some with other numbers.
            if let Ok(image) = exr::read(&path) {
                assert!(
                    image
                        .channels
                        .iter()
                        .all(|c| c.samples.len() == image.width * image.height)
                );
            }
        }
    }
}

#[test]
fn a_header_that_claims_more_than_the_file_can_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("claim.exr");
    exr::write(&path, &awkward()).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let at = bytes
            .windows(name.len())
            .position(|window| window == name)
            .unwrap();
        let x_max = at + name.len() + 4 + 8; // size, x_min, y_min
        bytes[x_max..x_max + 8].copy_from_slice(&[0xff, 0xff, 0xff, 0x00, 0xff, 0xff, 0xff, 0x00]);
    }
    std::fs::write(&path, bytes).unwrap();
    let error = exr::read(&path).unwrap_err();
    assert!(
        error.to_string().contains("claims 16777216 x 16777216"),
        "{error}"
    );
}

#[test]
fn a_failed_write_leaves_the_old_file_and_no_temporary() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("result");
    atomic::write(&path, |file| std::io::Write::write_all(file, b"old")).unwrap();
    let error = atomic::write(&path, |file| {
        std::io::Write::write_all(file, &[0; 100_000])?;
        Err(std::io::Error::other("the disk is full"))
    })
    .unwrap_err();
    assert!(error.to_string().contains("the disk is full"), "{error}");
    assert!(error.to_string().contains("result"), "{error}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    atomic::write(&path, |file| std::io::Write::write_all(file, b"new")).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
}

#[test]
fn missing_folders_and_folders_as_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("no").join("such.exr");
    let error = exr::write(&inside, &awkward()).unwrap_err();
    assert!(error.to_string().contains("does not exist"), "{error}");
    assert!(!folder.path().join("no").exists());
    for path in [folder.path(), Path::new("/"), Path::new("")] {
        let error = atomic::write(path, |_| Ok(())).unwrap_err();
        assert!(
            matches!(error, atomic::WriteError::NotAFile { .. }),
            "{error}"
        );
    }
}

#[cfg(unix)]
#[test]
fn files_may_be_read_by_others_as_any_ordinary_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let [ours, ordinary] = ["ours", "ordinary"].map(|name| folder.path().join(name));
    atomic::write(&ours, |_| Ok(())).unwrap();
    std::fs::write(&ordinary, "").unwrap();
    let mode = |path| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&ours), mode(&ordinary));
}
