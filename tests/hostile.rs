//! Files made to break the program: each is refused or read, in little time and memory, and without a panic.
//!
//! What an honest file needs is measured, not guessed: the heap that a well-formed file of the same format takes at
//! most, for each of its bytes. A hostile file may take four times that. Of packed images some honest ones hold little in much
//! room: a black one takes as much for a byte as its packing allows.

mod support;

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use ::exr::prelude::Compression as Packing;
use flate2::Compression;
use glam::DVec3;
use nephroid::film::{Channel, Image, exr};
use nephroid::geometry::MeshParts;
use nephroid::mitsuba;
use nephroid::reference::Progress;
use nephroid::reference::photons::run::Setup;
use nephroid::reference::photons::{Budget, PhotonSettings};
use nephroid::scene::Scene;
use peak_alloc::PeakAlloc;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestCaseResult, TestRunner};
use support::geometry::icosphere;
use support::mutation::{
    Mutation, NUMBER, PACKINGS, film, mutate, mutations, obj, one_or_more_mutations, ply,
    serialized, serialized_contents,
};
use tempfile::TempDir;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// The issue's bars.
const LONGEST: Duration = Duration::from_secs(10);
const TIMES_HONEST: f64 = 4.0;

/// The heap is one for all tests of this file: one at a time.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What came of reading a file.
struct Outcome<T> {
    result: Result<T, String>,
    seconds: f64,
    /// The most that the heap grew by, bytes.
    peak: usize,
}

impl<T> Outcome<T> {
    /// The error of what must not be read.
    fn refusal(self, case: &str) -> String {
        match self.result {
            Err(error) => error,
            Ok(_) => panic!("{case} is read"),
        }
    }
}

/// Runs `read` under a watch.
///
/// # Panics
///
/// Where it panics, or takes longer than [`LONGEST`].
fn watched<T: Send + 'static>(
    case: &str,
    read: impl FnOnce() -> Result<T, String> + Send + 'static,
) -> Outcome<T> {
    let (sender, receiver) = mpsc::channel();
    HEAP.reset_peak_usage();
    let before = HEAP.current_usage();
    let start = Instant::now();
    // Tests have stacks of 2 MB, and so has this.
    let reader = std::thread::spawn(move || drop(sender.send(read())));
    let result = match receiver.recv_timeout(LONGEST) {
        Ok(result) => result,
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("{case} takes more than {LONGEST:?}"),
        Err(mpsc::RecvTimeoutError::Disconnected) => panic!("{case} makes the reader panic"),
    };
    // What a thread gives back as it ends would else be taken off what the next one takes.
    reader.join().expect("it has sent its result");
    Outcome {
        result,
        seconds: start.elapsed().as_secs_f64(),
        peak: HEAP.peak_usage().saturating_sub(before),
    }
}

fn load(path: &Path) -> Outcome<Scene> {
    let case = path.display().to_string();
    let path = path.to_owned();
    watched(&case, move || {
        mitsuba::load(&path, &[]).map_err(|error| error.to_string())
    })
}

fn scene_of(elements: &str) -> String {
    format!("<scene version=\"3.0.0\">\n{elements}\n</scene>\n")
}

/// A folder with a scene file of these elements.
fn folder_with(elements: &str) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, scene_of(elements)).unwrap();
    (folder, file)
}

fn load_elements(elements: &str) -> Outcome<Scene> {
    let (_folder, file) = folder_with(elements);
    load(&file)
}

/// A kind of file that holds a mesh or an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Obj,
    AsciiPly,
    BinaryPly,
    Serialized,
    /// As a scene's texture.
    Exr,
    /// As a film, with its channels and metadata: what `compare` and studies read.
    Film,
}

const KINDS: [Kind; 6] = [
    Kind::Obj,
    Kind::AsciiPly,
    Kind::BinaryPly,
    Kind::Serialized,
    Kind::Exr,
    Kind::Film,
];

impl Kind {
    /// A well-formed file: a ball of `20 · 4^size` faces, or an image of as many texels.
    fn honest(self, size: u32) -> Vec<u8> {
        let ball = || icosphere(size);
        match self {
            Self::Obj => obj(&ball()),
            Self::AsciiPly => ply(&ball(), "ascii"),
            Self::BinaryPly => ply(&ball(), "binary_little_endian"),
            Self::Serialized => serialized(&serialized_contents(&ball()), Compression::none()),
            Self::Exr | Self::Film => noise(20 << size, 1 << size),
        }
    }

    /// Of a scene that names the file `it`.
    ///
    /// # Panics
    ///
    /// For films, which scenes do not name.
    fn elements(self) -> &'static str {
        match self {
            Self::Film => unreachable!("no scene names a film"),
            Self::Obj => r#"<shape type="obj"><string name="filename" value="it"/></shape>"#,
            Self::AsciiPly | Self::BinaryPly => {
                r#"<shape type="ply"><string name="filename" value="it"/></shape>"#
            }
            Self::Serialized => {
                r#"<shape type="serialized"><string name="filename" value="it"/></shape>"#
            }
            Self::Exr => {
                r#"<shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="it"/></texture></bsdf></shape>"#
            }
        }
    }

    fn load(self, bytes: &[u8]) -> Outcome<()> {
        if self == Self::Film {
            let folder = TempDir::new().unwrap();
            let file = folder.path().join("it");
            std::fs::write(&file, bytes).unwrap();
            return watched("a film", move || {
                exr::read(&file)
                    .map(drop)
                    .map_err(|error| error.to_string())
            });
        }
        let (folder, file) = folder_with(self.elements());
        std::fs::write(folder.path().join("it"), bytes).unwrap();
        let outcome = load(&file);
        Outcome {
            result: outcome.result.map(drop),
            seconds: outcome.seconds,
            peak: outcome.peak,
        }
    }

    /// What an honest file of the length of this one, and packed as it is, may take.
    fn need(self, file: &[u8]) -> Need {
        /// By kind and packing.
        static MEASURED: Mutex<BTreeMap<(usize, usize), Need>> = Mutex::new(BTreeMap::new());
        let is_image = matches!(self, Self::Exr | Self::Film);
        let packing = if is_image { packing_of(file) } else { 0 };
        let mut measured = MEASURED.lock().unwrap_or_else(PoisonError::into_inner);
        let need = measured.entry((self as usize, packing)).or_insert_with(|| {
            let mut pairs = vec![[self.honest(0), self.honest(3)]];
            let mut black_pairs = Vec::new();
            if is_image {
                let packing = PACKINGS[packing];
                let sizes = [(20, 1), (160, 8)];
                pairs.push(sizes.map(|(width, height)| film(width, height, packing, false)));
                // The longer the lines, the less of a file is headers of blocks.
                let sizes = [(20, 1), (20_000, 32)];
                black_pairs.push(sizes.map(|(width, height)| film(width, height, packing, true)));
            }
            let mut least = 0.0_f64;
            let mut a_byte = |pairs: &[[Vec<u8>; 2]]| {
                let slopes = pairs.iter().map(|files| {
                    let peaks = files.each_ref().map(|file| {
                        honest_peak(|| {
                            let outcome = self.load(file);
                            let why = outcome.result.err();
                            assert!(why.is_none(), "{self:?}: {why:?}");
                            outcome.peak
                        })
                    });
                    least = least.max(peaks[0]);
                    (peaks[1] - peaks[0]) / (files[1].len() - files[0].len()) as f64
                });
                slopes.fold(0.0, f64::max)
            };
            let (a_byte, a_black_byte) = (a_byte(&pairs), a_byte(&black_pairs));
            let name = if is_image {
                format!("{self:?} by {:?}", PACKINGS[packing])
            } else {
                format!("{self:?}")
            };
            println!(
                "{name}: {least} bytes of heap, and {a_byte:.1} for a byte; {a_black_byte:.0} where all is black"
            );
            Need {
                least,
                a_byte,
                a_black_byte,
            }
        });
        *need
    }
}

/// The heap \[bytes\] that reading something honest takes at most, of three times: what other threads (the pool's) give back late
/// is taken off what one of them seems to take. A first one, which pays for what is made once, does not count.
fn honest_peak(read: impl Fn() -> usize) -> f64 {
    read();
    (0..3).map(|_| read()).max().unwrap_or(0) as f64
}

/// The heap \[bytes\] that an honest file takes.
#[derive(Clone, Copy, Debug)]
struct Need {
    /// The smallest file.
    least: f64,
    /// What each byte more does.
    a_byte: f64,
    /// The same of an image that is all black, which packs best; 0 for what is no image.
    a_black_byte: f64,
}

impl Need {
    /// Of a file of this length.
    fn peak(self, length: usize) -> f64 {
        self.least + self.a_byte * length as f64
    }

    /// The same whatever is in it: as little in so much room as can be packed so.
    fn peak_of_any(self, length: usize) -> f64 {
        self.least + self.a_byte.max(self.a_black_byte) * length as f64
    }
}

/// How an image is packed, by its place in [`PACKINGS`], which is its number in the file. 0 where it cannot be read.
fn packing_of(bytes: &[u8]) -> usize {
    let at = after(bytes, b"compression\0compression\0").map(|at| at + 4);
    let number = at.and_then(|at| bytes.get(at)).copied();
    number
        .map(usize::from)
        .filter(|&number| number < PACKINGS.len())
        .unwrap_or(0)
}

/// Where some text of a file ends.
fn after(bytes: &[u8], text: &[u8]) -> Option<usize> {
    let start = bytes
        .windows(text.len())
        .position(|window| window == text)?;
    Some(start + text.len())
}

/// An image that does not compress.
fn noise(width: usize, height: usize) -> Vec<u8> {
    let mut random = support::geometry::Random(3);
    let mut image = Image::new(width, height);
    for name in ["R", "G", "B"] {
        let samples = (0..width * height).map(|_| random.unit() as f32).collect();
        image.channels.push(Channel {
            name: name.to_owned(),
            samples,
        });
    }
    written(&image)
}

fn written(image: &Image) -> Vec<u8> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("it.exr");
    exr::write(&file, image).unwrap();
    std::fs::read(&file).unwrap()
}

/// A scene with a little of all that a scene file may say.
const SCENE: &str = r##"<?xml version="1.0"?>
<scene version="3.0.0"><default name="size" value="8"/>
<integrator type="path"><integer name="max_depth" value="$size"/></integrator>
<emitter type="point"><point name="position" x="0" y="0" z="4"/><rgb name="intensity" value="100, 90, 80"/></emitter>
<emitter type="directional"><vector name="direction" x="0" y="0.1" z="-1"/><rgb name="irradiance" value="1"/></emitter>
<bsdf type="dielectric" id="glass"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1.0"/></bsdf><alias id="glass" as="ice"/>
<shape type="sphere"><point name="center" x="0" y="0" z="1.4"/><float name="radius" value="0.5"/><ref id="ice"/></shape>
<shape type="cube"><transform name="to_world"><scale value="0.3"/><rotate x="1" angle="30"/><translate x="1" z="1"/></transform><ref id="glass"/></shape>
<shape type="cylinder"><point name="p0" x="-1" y="0" z="0.5"/><point name="p1" x="-1" y="1" z="1"/><float name="radius" value="0.2"/><bsdf type="conductor"><string name="material" value="Al"/></bsdf></shape>
<shape type="disk"><transform name="to_world"><translate x="-1" y="-1" z="1"/></transform><bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="twosided"><bsdf type="conductor"/></bsdf></bsdf></shape>
<shape type="shapegroup" id="group"><shape type="sphere"><ref id="glass"/></shape></shape>
<shape type="instance"><ref id="group"/><transform name="to_world"><matrix value="0.1 0 0 0 0 0.1 0 1 0 0 0.1 1 0 0 0 1"/></transform></shape>
<shape type="rectangle"><bsdf type="diffuse"><rgb name="reflectance" value="#ff8000"/></bsdf>
<sensor type="irradiancemeter"><film type="hdrfilm"><integer name="width" value="$size"/><integer name="height" value="$size"/><rfilter type="box"/></film></sensor></shape>
</scene>
"##;

/// Runs a test on 128 of the inputs.
fn for_changes<T: Strategy>(inputs: &T, test: impl Fn(T::Value) -> TestCaseResult) {
    let mut runner = TestRunner::new(ProptestConfig {
        cases: CASES,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    });
    if let Err(error) = runner.run(inputs, test) {
        panic!("{error}");
    }
}

const CASES: u32 = 128;

#[test]
fn a_changed_mesh_or_image_takes_at_most_four_times_what_an_honest_one_takes() {
    let _alone = alone();
    // Every kind; what a serialized file holds, changed before it is packed: else its checksum tells; films packed in every way.
    type Changed = Box<dyn Fn(&[Mutation]) -> Vec<u8>>;
    let mut files: Vec<(String, Kind, Changed)> = KINDS
        .map(|kind| -> (String, Kind, Changed) {
            let original = kind.honest(2);
            let changed = move |changes: &[Mutation]| mutate(&original, changes);
            (format!("{kind:?}"), kind, Box::new(changed))
        })
        .into();
    let contents = serialized_contents(&icosphere(2));
    files.push((
        "contents of Serialized".to_owned(),
        Kind::Serialized,
        Box::new(move |changes| serialized(&mutate(&contents, changes), Compression::none())),
    ));
    for packing in PACKINGS {
        let original = film(80, 4, packing, false);
        files.push((
            format!("Film by {packing:?}"),
            Kind::Film,
            Box::new(move |changes| mutate(&original, changes)),
        ));
    }
    let read = RefCell::new(vec![0; files.len()]);
    let most = RefCell::new(vec![0.0_f64; files.len()]);
    for_changes(&one_or_more_mutations(), |changes| {
        for (index, (name, kind, changed)) in files.iter().enumerate() {
            let changed = changed(&changes);
            let outcome = kind.load(&changed);
            let times = outcome.peak as f64 / kind.need(&changed).peak_of_any(changed.len());
            read.borrow_mut()[index] += u32::from(outcome.result.is_ok());
            let most = &mut most.borrow_mut()[index];
            *most = most.max(times);
            prop_assert!(
                times <= TIMES_HONEST,
                "{name}: {} bytes of heap for a file of {} bytes, {times} times what is honest",
                outcome.peak,
                changed.len()
            );
        }
        Ok(())
    });
    for (index, (name, ..)) in files.iter().enumerate() {
        let (read, most) = (read.borrow()[index], most.borrow()[index]);
        println!(
            "{name}: {read} of {CASES} are read; at most {most:.2} times the heap of an honest one"
        );
        // Neither are all refused at sight nor all too little changed to matter. But zlib's checksum tells nearly every change.
        let has_checksum = ["Serialized", "Film by ZIP", "Film by PXR24"]
            .iter()
            .any(|start| name.starts_with(start));
        let least = if has_checksum { 0 } else { 3 };
        assert!((least..CASES).contains(&read), "{name}: {read} are read");
    }
}

#[test]
fn a_changed_scene_is_refused_or_runs() {
    let _alone = alone();
    // Few scenes survive any change; where numbers become others, many do.
    let numbers = mutations().prop_map(|mut changes| {
        changes.iter_mut().for_each(|(_, kind, _)| *kind = NUMBER);
        changes
    });
    let (read, most) = (Cell::new(0), Cell::new(0.0_f64));
    let honest = honest_peak(|| load_text(SCENE.as_bytes()).peak);
    for_changes(&prop_oneof![mutations(), numbers], |changes| {
        let changed = mutate(SCENE.as_bytes(), &changes);
        let outcome = load_text(&changed);
        let honest = honest * (changed.len() as f64 / SCENE.len() as f64).max(1.0);
        most.set(most.get().max(outcome.peak as f64 / honest));
        prop_assert!(
            outcome.peak as f64 <= TIMES_HONEST * honest,
            "{} bytes of heap, where an honest one takes {honest}",
            outcome.peak
        );
        if let Ok(scene) = outcome.result {
            read.set(read.get() + 1);
            let changed = String::from_utf8_lossy(&changed).into_owned();
            drop(watched(&changed, move || a_few_photons(&scene)));
        }
        Ok(())
    });
    println!(
        "{} of {CASES} changed scenes are read and run; at most {:.2} times the heap of an honest one",
        read.get(),
        most.get()
    );
    assert!(read.get() >= CASES / 10, "{} scenes are read", read.get());
}

fn load_text(text: &[u8]) -> Outcome<Scene> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, text).unwrap();
    load(&file)
}

/// Runs photons on all small films; what is refused is refused.
fn a_few_photons(scene: &Scene) -> Result<(), String> {
    for sensor in scene.sensors() {
        // Larger ones are honest, and the command line says what they take.
        if sensor.film.width.max(sensor.film.height) > 64 {
            continue;
        }
        let progress = Progress::default();
        let budget = Budget {
            photons: Some(256),
            ..Budget::default()
        };
        let estimate = Setup::new(scene, sensor, PhotonSettings::default(), &progress)
            .and_then(|setup| setup.run(&budget))
            .map_err(|error| error.to_string())?;
        // A film's quantum is that of the brightest channel: what is dim beside it closes to as much less.
        let emitted = estimate.ledger.emitted;
        let dimmest = emitted
            .0
            .into_iter()
            .filter(|&flux| flux > 0.0)
            .fold(f64::INFINITY, f64::min);
        let allowed = 1e-12 * (emitted.max_channel() / dimmest).max(1.0);
        let closure = estimate.ledger.closure_error();
        assert!(
            closure.is_none_or(|error| error < allowed),
            "{closure:?}, {allowed:e} allowed"
        );
    }
    Ok(())
}

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
        // None, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A: none of them shrinks so much. The crate itself refuses 2³¹.
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

/// The heap \[bytes\] that an honest scene file of this length may take: the smallest scene's, and for each byte what a thousand
/// balls take for each of theirs.
fn honest_scene_peak(length: usize) -> f64 {
    static MEASURED: OnceLock<(f64, f64)> = OnceLock::new();
    let (least, a_byte) = *MEASURED.get_or_init(|| {
        let measured = |balls: usize| {
            let elements = "<shape type=\"sphere\"/>\n".repeat(balls);
            // Once before: what the first thread of all takes is no scene's.
            load_elements(&elements);
            let outcome = load_elements(&elements);
            assert!(outcome.result.is_ok());
            (outcome.peak as f64, scene_of(&elements).len() as f64)
        };
        let [small, large] = [1, 1000].map(measured);
        let a_byte = (large.0 - small.0) / (large.1 - small.1);
        println!(
            "an honest scene takes {} bytes of heap, and {a_byte:.1} for a byte",
            small.0
        );
        (small.0, a_byte)
    });
    least + a_byte * length as f64
}

#[test]
fn scene_files_that_grow_while_they_are_read_are_refused() {
    let _alone = alone();
    let entities: String = (1..64)
        .map(|n| format!("<!ENTITY e{n} \"&e{};&e{};\">", n - 1, n - 1))
        .collect();
    let bomb = format!(
        "<!DOCTYPE s [<!ENTITY e0 \"xxxxxxxx\">{entities}]><scene version=\"3.0.0\">&e63;</scene>"
    );
    let deep = "<shape type=\"shapegroup\">".repeat(1_000_000);
    let long = "x".repeat(1 << 19);
    let parameters: String = (0..100_000)
        .map(|n| format!("<default name=\"p{n}\" value=\"$a$a\"/>\n"))
        .collect();
    // Every `$a` is compared with names of every length.
    let names: String = (1..1500)
        .map(|n| format!("<default name=\"{}\" value=\"1\"/>\n", "a".repeat(n)))
        .collect();
    let names = format!(
        "{names}<string name=\"{}\" value=\"x\"/>",
        "$a".repeat(500_000)
    );
    let group = format!(
        "<shape type=\"shapegroup\" id=\"g\">{}</shape>",
        "<shape type=\"sphere\"/>".repeat(20_000)
    );
    let instances = "<shape type=\"instance\"><ref id=\"g\"/></shape>\n".repeat(20_000);
    let cases = [
        ("an entity bomb", bomb, "not well-formed XML"),
        ("elements a million deep", scene_of(&deep), ""),
        (
            "elements a million deep and back",
            scene_of(&format!("{deep}{}", "</shape>".repeat(1_000_000))),
            "more than 64 levels deep",
        ),
        (
            "plain tags a million deep and back",
            scene_of(&format!(
                "{}{}",
                "<a>".repeat(1_000_000),
                "</a>".repeat(1_000_000)
            )),
            "",
        ),
        (
            "a hundred thousand long parameters",
            scene_of(&format!(
                "<default name=\"a\" value=\"{long}\"/>{parameters}"
            )),
            "come to more than",
        ),
        (
            "names of fifteen hundred lengths",
            scene_of(&names),
            "is longer than",
        ),
        (
            "four hundred million instances",
            scene_of(&format!("{group}{instances}")),
            "instances",
        ),
    ];
    for (case, text, expected) in cases {
        let allowed = TIMES_HONEST * honest_scene_peak(text.len());
        let outcome = load_text(text.as_bytes());
        let (peak, seconds) = (outcome.peak, outcome.seconds);
        println!(
            "{case}: {} bytes, {peak} bytes of heap ({:.2} of what is allowed), {seconds:.2} s",
            text.len(),
            peak as f64 / allowed
        );
        let error = outcome.refusal(case);
        assert!(error.contains(expected), "{case}: {error}");
        assert!(
            error.len() < 10_000,
            "{case}: a message of {} bytes",
            error.len()
        );
        assert!(
            (peak as f64) < allowed,
            "{case}: {peak} bytes of heap, {allowed} are allowed"
        );
    }
}

#[test]
fn includes_end_however_they_are_nested() {
    let _alone = alone();
    let folder = TempDir::new().unwrap();
    let write = |name: String, elements: &str| {
        std::fs::write(folder.path().join(name), scene_of(elements)).unwrap()
    };
    let include = |name: &str| format!("<include filename=\"{name}\"/>\n");
    // A hundred thousand files, each of which includes the next.
    for n in 0..100_000 {
        write(
            format!("chain{n}.xml"),
            &include(&format!("chain{}.xml", n + 1)),
        );
    }
    // Fifteen, each of which includes the next ten times: 10¹⁴ in all.
    for n in 0..15 {
        write(
            format!("tree{n}.xml"),
            &include(&format!("tree{}.xml", n + 1)).repeat(10),
        );
    }
    write("tree15.xml".to_owned(), "");
    // A hundred thousand times the same, and itself by other names.
    write(
        "flat.xml".to_owned(),
        &include("tree15.xml").repeat(100_000),
    );
    write("self.xml".to_owned(), &include("./././self.xml").repeat(10));
    for (name, expected) in [
        ("chain0.xml", "more than 15 levels deep"),
        ("tree0.xml", "which is all that is allowed"),
        ("flat.xml", "which is all that is allowed"),
        ("self.xml", "includes"),
    ] {
        let outcome = load(&folder.path().join(name));
        let (peak, seconds) = (outcome.peak, outcome.seconds);
        let error = outcome.refusal(name);
        assert!(error.contains(expected), "{name}: {error}");
        // Of 2¹⁴ files their names and versions are kept, no contents: 40 bytes each in a list that is three times as long while it
        // grows, from one half of its room to twice that; and the name, which may have twice its room.
        let path = folder.path().join(name);
        let kept = 3 * 40 + 2 * path.as_os_str().len();
        let length = std::fs::metadata(&path).unwrap().len() as usize;
        let allowed = TIMES_HONEST * honest_scene_peak(length) + ((1 << 14) * kept) as f64;
        println!(
            "{name}: {peak} bytes of heap ({:.2} of what is allowed), {seconds:.2} s",
            peak as f64 / allowed
        );
        assert!(
            (peak as f64) < allowed,
            "{name}: {peak} bytes of heap, {allowed} are allowed"
        );
    }
}

/// A mesh of triangles, one round each of these points.
fn specks(corners: impl Iterator<Item = [DVec3; 3]>) -> MeshParts {
    let positions: Vec<DVec3> = corners.flatten().collect();
    MeshParts {
        triangles: (0..positions.len() as u32 / 3)
            .map(|face| [3 * face, 3 * face + 1, 3 * face + 2])
            .collect(),
        positions,
        ..MeshParts::default()
    }
}

#[test]
fn meshes_made_to_be_slow_are_read_in_time() {
    let _alone = alone();
    const COUNT: u32 = 100_000;
    let at = |place: DVec3| [place, place + DVec3::X, place + DVec3::Y];
    let cases = [
        (
            "triangles in one place, apart by rounding",
            specks((0..COUNT).map(|n| at(DVec3::Z * (f64::from(n) * 1e-15)))),
        ),
        (
            "triangles in a row",
            specks((0..COUNT).map(|n| at(DVec3::X * f64::from(n)))),
        ),
        (
            "triangles in a tower",
            specks((0..COUNT).map(|n| at(DVec3::Z * f64::from(n)))),
        ),
        (
            "triangles round one another",
            specks((0..COUNT).map(|n| {
                at(DVec3::ZERO).map(|p| (p - DVec3::new(1.0, 1.0, 0.0) / 3.0) * f64::from(n + 1))
            })),
        ),
        (
            "triangles each half as large as the last",
            specks((0..COUNT).map(|n| at(DVec3::ZERO).map(|p| p * 0.999_f64.powi(n as i32)))),
        ),
        ("positions whose hashes collide", colliding(COUNT)),
    ];
    for (case, mesh) in cases {
        let outcome = Kind::BinaryPly.load(&ply(&mesh, "binary_little_endian"));
        println!(
            "{case}: {} bytes of heap, {:.2} s",
            outcome.peak, outcome.seconds
        );
        if let Err(error) = outcome.result {
            panic!("{case}: {error}");
        }
    }
    let polygon: String = (1..=100_000).map(|n| format!(" {n}")).collect();
    let vertices: String = (0..100_000)
        .map(|n| format!("v {} {} 0\n", n % 1000, n / 1000))
        .collect();
    let star: String = (2..100_000)
        .map(|n| format!("f 1 {n} {}\n", n + 1))
        .collect();
    let normals: String = (0..100_000)
        .map(|n| format!("vn 0 {n} 1\nf 1//{} 2 3\n", n + 1))
        .collect();
    for (case, text) in [
        (
            "a face of 100 000 corners",
            format!("{vertices}f{polygon}\n"),
        ),
        ("100 000 faces round a vertex", format!("{vertices}{star}")),
        (
            "a vertex with 100 000 normals",
            format!("{vertices}{normals}"),
        ),
    ] {
        let outcome = Kind::Obj.load(text.as_bytes());
        println!(
            "{case}: {} bytes of heap, {:.2} s",
            outcome.peak, outcome.seconds
        );
        if let Err(error) = outcome.result {
            panic!("{case}: {error}");
        }
    }
    // Glass, so that they are looked at for surfaces at the same place; and each round the last, so that none are.
    let ball = |radius: f64| {
        format!(
            "<shape type=\"sphere\"><float name=\"radius\" value=\"{radius}\"/><bsdf type=\"dielectric\"/></shape>\n"
        )
    };
    let nested: String = (1..=50_000).map(|i| ball(1e-3 * f64::from(i))).collect();
    for (case, balls) in [
        ("in one place", ball(1.0).repeat(50_000)),
        ("round one another", nested),
    ] {
        let outcome = load_elements(&balls);
        println!("50 000 balls of glass {case}: {:.2} s", outcome.seconds);
        let scene = outcome.result.expect("balls are a scene");
        assert!(
            scene.warnings().len() < 100,
            "{case}: {} warnings",
            scene.warnings().len()
        );
    }
}

/// Triangles of positions that all had the same hash while the hash had no secret: the multiplication of two
/// coordinates' bits is undone by the third's.
fn colliding(faces: u32) -> MeshParts {
    const START: u64 = 0x9e37_79b9_7f4a_7c15;
    let mix = |state: u64, word: u64| {
        let product = u128::from(state ^ word ^ START) * 0xbf58_476d_1ce4_e5b9;
        (product as u64) ^ ((product >> 64) as u64)
    };
    let mut positions = Vec::new();
    let mut n = 0_u32;
    while positions.len() < 3 * faces as usize {
        n += 1;
        let (x, y) = (1.0 + f64::from(n) * 1e-6, 1.0_f64);
        let state = mix(mix(0, x.to_bits()), y.to_bits());
        let z = f64::from_bits(state ^ 0x1234_5678);
        if z.is_finite() && z.abs() < 1e60 && z.abs() > 1e-60 {
            positions.push(DVec3::new(x, y, z));
        }
    }
    specks(
        positions
            .chunks_exact(3)
            .map(|corners| [corners[0], corners[1], corners[2]])
            .collect::<Vec<_>>()
            .into_iter(),
    )
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_no_files() {
    let _alone = alone();
    let pipe = TempDir::new().unwrap();
    let pipe = pipe.path().join("pipe");
    let folder = pipe.parent().unwrap();
    std::fs::create_dir_all(folder).unwrap();
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    let mut names = vec![PathBuf::from("/dev/zero"), folder.to_owned()];
    if made.is_ok_and(|status| status.success()) {
        names.push(pipe.clone());
    }
    for name in names {
        let name = name.display();
        for elements in [
            format!("<shape type=\"obj\"><string name=\"filename\" value=\"{name}\"/></shape>"),
            format!("<shape type=\"ply\"><string name=\"filename\" value=\"{name}\"/></shape>"),
            format!(
                "<shape type=\"serialized\"><string name=\"filename\" value=\"{name}\"/></shape>"
            ),
            format!(
                "<emitter type=\"envmap\"><string name=\"filename\" value=\"{name}\"/></emitter>"
            ),
            format!("<include filename=\"{name}\"/>"),
            Kind::Exr
                .elements()
                .replace("\"it\"", &format!("\"{name}\"")),
        ] {
            let outcome = load_elements(&elements);
            assert!(
                outcome.peak < 1 << 20,
                "{elements}: {} bytes of heap",
                outcome.peak
            );
            let said = match outcome.result {
                Err(error) => error,
                // An image that no irradiance depends on may be missing.
                Ok(scene) => scene.warnings().iter().map(ToString::to_string).collect(),
            };
            let is_meant = ["cannot be read", "there is no file", "there is no image"];
            assert!(
                is_meant.iter().any(|text| said.contains(text)),
                "{elements}: {said}"
            );
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn only_what_the_file_names_is_read_and_nothing_is_written() {
    let _alone = alone();
    let root = TempDir::new().unwrap();
    let write = |name: &str, contents: &str| {
        let path = root.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, contents).unwrap();
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let shape = |name: &str| {
        format!("<shape type=\"obj\"><string name=\"filename\" value=\"{name}\"/></shape>")
    };
    write("above.obj", triangle);
    write("scene/parts/below.obj", triangle);
    write(
        "scene/parts/part.xml",
        &scene_of("<path value=\"deeper\"/>"),
    );
    write("scene/parts/deeper/deep.obj", triangle);
    // What mesh files name is not read: neither materials nor textures.
    write("scene/plain.obj", triangle);
    write(
        "scene/names.obj",
        &format!(
            "mtllib /dev/zero\nmtllib ../above.obj\nusemtl x\nmap_Kd ../above.png\n{triangle}"
        ),
    );
    write("above.png", "no image");
    let named = String::from_utf8(ply(&icosphere(0), "ascii")).unwrap();
    let comment = "format ascii 1.0\ncomment TextureFile ../above.png\nobj_info /dev/zero";
    write(
        "scene/names.ply",
        &named.replacen("format ascii 1.0", comment, 1),
    );
    let load = |elements: &str| {
        write("scene/scene.xml", &scene_of(elements));
        load(&root.path().join("scene/scene.xml")).result
    };
    assert!(load(&shape("plain.obj")).is_ok());
    // Were they read, the hash over all that is read would change with them.
    let names_others = format!(
        "{}<shape type=\"ply\"><string name=\"filename\" value=\"names.ply\"/></shape>",
        shape("names.obj")
    );
    let hash = || load(&names_others).unwrap().content_hash().to_owned();
    let with_them = hash();
    write("above.png", "no image any more");
    write("above.obj", "no mesh any more");
    assert_eq!(hash(), with_them);
    write("above.obj", triangle);
    // What is named with its way is found, ...
    assert!(load(&shape("../above.obj")).is_ok());
    assert!(load(&shape("parts/below.obj")).is_ok());
    // ... what is not is not looked for: neither above nor below, nor where an include looked.
    for missing in ["above.obj", "below.obj", "deep.obj"] {
        let error = load(&format!(
            "<include filename=\"parts/part.xml\"/>{}",
            shape(missing)
        ))
        .unwrap_err();
        assert!(error.contains("cannot be read"), "{error}");
    }
    // Where an old file says that its image belongs, none is put.
    let film = r#"<sensor type="perspective"><film type="hdrfilm"><string name="filename" value="../image.exr"/></film></sensor>"#;
    let old = scene_of(film).replace("3.0.0", "0.6.0");
    write("scene/scene.xml", &old);
    let before = snapshot(root.path());
    let file = root.path().join("scene/scene.xml");
    self::load(&file).result.unwrap();
    assert!(snapshot(root.path()) == before, "something is written");
}

/// A way for a scene to name a file.
struct Naming {
    what: &'static str,
    /// The elements, but for the name, which is `NAME` there.
    elements: &'static str,
    /// A file that is read.
    sound: Vec<u8>,
    /// What is said of a file that is not there.
    missing: &'static str,
}

impl Naming {
    fn of(&self, name: &str) -> String {
        scene_of(&self.elements.replace("NAME", name))
    }
}

/// Every way.
fn namings() -> Vec<Naming> {
    let ball = icosphere(0);
    let naming = |what, elements, sound, missing| Naming {
        what,
        elements,
        sound,
        missing,
    };
    vec![
        naming(
            "obj",
            r#"<shape type="obj"><string name="filename" value="NAME"/></shape>"#,
            obj(&ball),
            "cannot be read",
        ),
        naming(
            "ply",
            r#"<shape type="ply"><string name="filename" value="NAME"/></shape>"#,
            ply(&ball, "ascii"),
            "cannot be read",
        ),
        naming(
            "serialized",
            r#"<shape type="serialized"><string name="filename" value="NAME"/></shape>"#,
            serialized(&serialized_contents(&ball), Compression::fast()),
            "cannot be read",
        ),
        naming(
            "a texture that irradiance does not depend on",
            r#"<shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="NAME"/></texture></bsdf></shape>"#,
            noise(8, 4),
            "there is no image",
        ),
        naming(
            "a texture that shines",
            r#"<shape type="rectangle"><emitter type="area"><texture type="bitmap" name="radiance"><string name="filename" value="NAME"/></texture></emitter></shape>"#,
            noise(8, 4),
            "there is no image",
        ),
        naming(
            "envmap",
            r#"<shape type="sphere"/><emitter type="envmap"><string name="filename" value="NAME"/></emitter>"#,
            noise(8, 4),
            "cannot be read",
        ),
        naming(
            "include",
            r#"<include filename="NAME"/>"#,
            scene_of(r#"<shape type="sphere"/>"#).into_bytes(),
            "there is no file",
        ),
    ]
}

/// All that is in a folder, without following links: names, what they are and hold, and when they were written.
fn snapshot(folder: &Path) -> BTreeMap<PathBuf, (SystemTime, String, Vec<u8>)> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let about = std::fs::metadata(&folder).unwrap();
        found.insert(
            folder.clone(),
            (about.modified().unwrap(), "folder".to_owned(), Vec::new()),
        );
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let about = std::fs::symlink_metadata(&path).unwrap();
            if about.is_dir() {
                folders.push(path);
                continue;
            }
            let (kind, contents) = if about.is_symlink() {
                let target = std::fs::read_link(&path).unwrap();
                (format!("link to {}", target.display()), Vec::new())
            } else {
                ("file".to_owned(), std::fs::read(&path).unwrap())
            };
            found.insert(path, (about.modified().unwrap(), kind, contents));
        }
    }
    found
}

#[cfg(unix)]
#[test]
fn every_way_to_name_a_file_reads_that_file_or_none_and_nothing_is_written() {
    let _alone = alone();
    let (mut read, mut refused) = (0, 0);
    for naming in namings() {
        let root = TempDir::new().unwrap();
        let at = |name: &str| root.path().join(name);
        let write = |name: &str, contents: &[u8]| {
            std::fs::create_dir_all(at(name).parent().unwrap()).unwrap();
            std::fs::write(at(name), contents).unwrap();
        };
        // The file that is meant has another of its name in every folder that could be taken for its own.
        let garbage = b"garbage\n".as_slice();
        for name in ["scene/it", "scene/parts/it", "scene/parts/deeper/it"] {
            write(name, garbage);
        }
        write("it", &naming.sound);
        write("beside/it", &naming.sound);
        // These are nowhere but where no name below leads.
        write("above", &naming.sound);
        write("scene/parts/below", &naming.sound);
        write("beside/other", &naming.sound);
        for (link, target) in [
            ("scene/link", PathBuf::from("../it")),
            ("scene/absolute", at("beside/it")),
            ("scene/chain", PathBuf::from("link")),
            ("scene/up", PathBuf::from("../beside")),
            ("scene/broken", PathBuf::from("../nothing")),
            ("scene/round", PathBuf::from("round")),
            ("scene/device", PathBuf::from("/dev/zero")),
            ("scene/folder", PathBuf::from("parts")),
        ] {
            std::os::unix::fs::symlink(target, at(link)).unwrap();
        }
        let absolute = at("it").display().to_string();
        let nowhere = at("nothing").display().to_string();
        let sound = [
            "../it",
            "../beside/it",
            "parts/../../it",
            "./.././it",
            &absolute,
            "link",
            "absolute",
            "chain",
            "up/it",
            // A link is followed before `..` is: this is not `scene/it`.
            "up/../it",
        ];
        let damaged = ["it", "./it", "parts/it", "../scene/it", "folder/it"];
        let missing = [
            "above",
            "below",
            "other",
            "../parts/below",
            &nowhere,
            "broken",
            "round",
            "it/",
            "it/../../it",
            "",
        ];
        let devices = ["device", "/dev/zero", "up", "parts", "..", "."];
        let cases = [sound.as_slice(), &damaged, &missing, &devices];
        for (group, names) in cases.iter().enumerate() {
            for name in *names {
                write("scene/scene.xml", naming.of(name).as_bytes());
                let before = snapshot(root.path());
                let outcome = load(&at("scene/scene.xml"));
                let case = format!("{} by the name {name:?}", naming.what);
                let said = match outcome.result {
                    Ok(scene) => {
                        let warnings = scene.warnings().iter();
                        warnings.map(ToString::to_string).collect()
                    }
                    Err(error) => format!("error: {error}"),
                };
                let is_there = !["cannot be read", "there is no file", "there is no image"]
                    .iter()
                    .any(|text| said.contains(text));
                match group {
                    0 => assert!(is_there && !said.contains("error"), "{case}: {said}"),
                    1 => assert!(is_there && said.contains("error"), "{case}: {said}"),
                    2 => assert!(said.contains(naming.missing), "{case}: {said}"),
                    _ => assert!(!is_there, "{case}: {said}"),
                }
                *(if group == 0 { &mut read } else { &mut refused }) += 1;
                assert!(outcome.peak < 1 << 20, "{case}: {} bytes", outcome.peak);
                assert!(snapshot(root.path()) == before, "{case} writes something");
            }
        }
        // A `<path>` is one more folder to look in, and no way into those beside it.
        for (folder, name, is_found) in [
            ("../beside", "other", true),
            ("parts", "below", true),
            ("parts/..", "below", false),
            ("parts/deeper", "below", false),
            ("parts/deeper", "../below", true),
        ] {
            let elements = naming.elements.replace("NAME", name);
            let text = scene_of(&format!("<path value=\"{folder}\"/>{elements}"));
            write("scene/scene.xml", text.as_bytes());
            let before = snapshot(root.path());
            let outcome = load(&at("scene/scene.xml")).result;
            let said = match outcome {
                Ok(scene) => {
                    let warnings = scene.warnings().iter();
                    warnings.map(ToString::to_string).collect()
                }
                Err(error) => format!("error: {error}"),
            };
            let case = format!("{} by {name:?} in {folder:?}", naming.what);
            if is_found {
                assert!(said.is_empty(), "{case}: {said}");
            } else {
                assert!(said.contains(naming.missing), "{case}: {said}");
            }
            assert!(snapshot(root.path()) == before, "{case} writes something");
        }
    }
    println!(
        "{read} names lead to their files, {refused} to none or to what is refused; nothing is written"
    );
}
