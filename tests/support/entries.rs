//! The entry points of everything that reads a file, by the name of a fuzz target: shared by `fuzz/`, which
//! makes long runs on new inputs, and `tests/hostile/replay.rs`, which replays the inputs that are kept.
//!
//! Errors are fine: the claim is that each returns, in little time and memory, without a panic.

use std::cell::RefCell;
use std::io::{Cursor, Write as _};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use flate2::Compression;
use flate2::write::GzEncoder;
use nephroid::internals::approximation::Technique as _;
use nephroid::internals::approximation::local_irradiance::chunk::{Content, Key, sealed};
use nephroid::internals::approximation::local_irradiance::file::{Expected, radii_of, table_of};
use nephroid::internals::approximation::local_irradiance::layout::Layout;
use nephroid::internals::approximation::local_irradiance::{LocalIrradiance, Settings};
use nephroid::internals::film::bitmap::{Bitmap, BitmapEncoding};
use nephroid::internals::film::exr;
use nephroid::internals::metric::{CompareImage, CompareSettings, compare};
use nephroid::internals::mitsuba;
use nephroid::internals::reference::parts::{Divided, Shards};
use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::reference::path::run::Setup as Paths;
use nephroid::internals::reference::photon_map::PhotonMapSettings;
use nephroid::internals::reference::photon_map::setup::Setup as PhotonMaps;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup as Photons;
use nephroid::internals::run::Progress;
use nephroid::internals::scene::Scene;
use nephroid::internals::setting::Values;
use nephroid::internals::study::file::{StudyFile, frames};
use tempfile::TempDir;

/// All targets.
pub const TARGETS: [&str; 9] = [
    "xml",
    "obj",
    "ply",
    "serialized",
    "picture",
    "film",
    "study",
    "shard",
    "table",
];

/// Reads `bytes` as a file of this target's kind.
///
/// # Panics
///
/// If there is no such target, or what reads the bytes panics.
pub fn enter(target: &str, bytes: &[u8]) {
    match target {
        "xml" => load("scene.xml", bytes, None),
        "obj" | "ply" | "serialized" => load_mesh(target, bytes),
        "picture" => {
            drop(Bitmap::read(bytes, BitmapEncoding::Color));
            drop(Bitmap::read(bytes, BitmapEncoding::Raw));
        }
        "film" => film(bytes),
        "study" => study(bytes),
        "shard" => shard(bytes),
        "table" => table(bytes),
        _ => panic!("no target {target}: {}", TARGETS.join(", ")),
    }
}

thread_local! {
    /// A folder that lasts as long as the thread.
    static FOLDER: RefCell<Option<TempDir>> = const { RefCell::new(None) };
}

/// Writes `bytes` as the file `name` of the thread's folder; returns its path.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    FOLDER.with_borrow_mut(|folder| {
        let folder = folder.get_or_insert_with(|| TempDir::new().expect("a temporary folder"));
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file in a temporary folder");
        path
    })
}

/// Writes `bytes` as the file `name`, and loads a scene: the text `scene` as the file `scene.xml` beside it,
/// or the file itself if there is none.
fn load(name: &str, bytes: &[u8], scene: Option<&str>) {
    let written = file(name, bytes);
    let scene = scene.map_or(written, |text| file("scene.xml", text.as_bytes()));
    drop(mitsuba::load(&scene, &[]));
}

fn load_mesh(plugin: &str, bytes: &[u8]) {
    let scene = format!(
        "<scene version=\"3.0.0\"><shape type=\"{plugin}\"><string name=\"filename\" value=\"mesh\"/></shape></scene>"
    );
    load("mesh", bytes, Some(&scene));
}

/// A film, and its comparison with itself: layers, bars and places come from its names and metadata.
fn film(bytes: &[u8]) {
    let Ok(image) = exr::read(&file("film.exr", bytes)) else {
        return;
    };
    if image.width.saturating_mul(image.height) > 1 << 12 || image.channels.len() > 32 {
        return;
    }
    let film = CompareImage::new("film.exr", image);
    drop(compare(&film, &film, &CompareSettings::default()));
}

/// A study, and frames of an animation: both are tables of values, lists and ranges.
fn study(bytes: &[u8]) {
    drop(StudyFile::read(&file("study.toml", bytes)));
    let text = String::from_utf8_lossy(bytes).into_owned();
    drop(frames(&[text]));
}

/// The runs of the shards that are read: photons on `meter`, photon maps and paths of `camera`.
type SmallRuns = (Photons<'static>, PhotonMaps<'static>, Paths<'static>);

/// Those of a small scene.
pub fn small_runs() -> &'static SmallRuns {
    static RUNS: OnceLock<SmallRuns> = OnceLock::new();
    RUNS.get_or_init(|| {
        const SCENE: &str = r#"<scene version="3.0.0">
            <emitter type="point"><point name="position" x="0" y="0" z="3"/></emitter>
            <shape type="sphere"><point name="center" x="0" y="0" z="1"/><float name="radius" value="0.5"/><bsdf type="dielectric"/></shape>
            <shape type="rectangle"><sensor type="irradiancemeter" id="meter"><film type="hdrfilm">
                <integer name="width" value="2"/><integer name="height" value="2"/><rfilter type="box"/>
            </film></sensor></shape>
            <sensor type="perspective" id="camera"><transform name="to_world">
                <lookat origin="0, -3, 2" target="0, 0, 0" up="0, 0, 1"/>
            </transform><film type="hdrfilm">
                <integer name="width" value="3"/><integer name="height" value="2"/><rfilter type="gaussian"/>
            </film></sensor></scene>"#;
        let scene = mitsuba::load(&file("shards.xml", SCENE.as_bytes()), &[]).expect("a scene");
        let scene: &'static Scene = Box::leak(Box::new(scene));
        let progress: &'static Progress = Box::leak(Box::default());
        let sensor = |id: &str| scene.sensors().iter().find(|it| it.id == id).expect("a sensor");
        let photons = PhotonSettings {
            replicates: 2,
            ..PhotonSettings::default()
        };
        let maps = PhotonMapSettings {
            photons,
            map_photons: 16,
            ..PhotonMapSettings::default()
        };
        let paths = PathSettings {
            replicates: 2,
            ..PathSettings::default()
        };
        (
            Photons::new(scene, sensor("meter"), photons, progress).expect("a run"),
            PhotonMaps::new(scene, sensor("camera"), maps, progress).expect("a run"),
            Paths::new(scene, sensor("camera"), paths, progress).expect("a run"),
        )
    })
}

/// The first bytes of a shard whose sums are not deflated: changes of what is deflated would all be found by
/// checksums, and what is behind these would be tried by nobody.
pub const PLAIN: &[u8] = b"plain sums\n";

/// What is between the parts of a shard of several rounds.
pub const NEXT: &[u8] = b"\nnext part\n";

/// A shard whose parts lack the hash at their end, and its merge: a whole run of a small scene.
fn shard(bytes: &[u8]) {
    let mut file = Vec::new();
    let mut seal = |part: &[u8]| {
        let part = match part.strip_prefix(PLAIN) {
            Some(plain) => deflate_sums(plain),
            None => part.to_vec(),
        };
        file.extend(&part);
        file.extend(blake3::hash(&part).as_bytes());
    };
    let mut rest = bytes;
    while let Some(at) = rest.windows(NEXT.len()).position(|there| there == NEXT) {
        seal(&rest[..at]);
        rest = &rest[at + NEXT.len()..];
    }
    seal(rest);
    let mut shards = Shards::default();
    if shards
        .open("fuzzed".to_owned(), Box::new(Cursor::new(file)))
        .is_err()
    {
        return;
    }
    let (photons, maps, paths) = small_runs();
    match shards.method() {
        Some("photons") => drop(photons.merge("meter", &mut shards)),
        Some("photon-map") => drop(maps.merge("camera", &mut shards)),
        _ => drop(paths.merge("camera", &mut shards)),
    }
}

/// The bytes of a shard from two lines, and sums each after its length in 16 bits.
fn deflate_sums(plain: &[u8]) -> Vec<u8> {
    let mut lines = plain.splitn(3, |byte| *byte == b'\n');
    let mut file = Vec::new();
    for _ in 0..2 {
        file.extend(lines.next().unwrap_or_default());
        file.push(b'\n');
    }
    let mut rest = lines.next().unwrap_or_default();
    while let Some((length, more)) = rest.split_first_chunk() {
        let length = usize::from(u16::from_le_bytes(*length)).min(more.len());
        file.extend(*b"nphACC\x00\x01");
        let mut encoder = GzEncoder::new(&mut file, Compression::none());
        let written = encoder.write_all(&more[..length]);
        written
            .and_then(|()| encoder.finish().map(drop))
            .expect("memory");
        rest = &more[length..];
    }
    file
}

/// Settings of tables, checked.
pub fn table_settings(given: &[(&str, &str)]) -> Settings {
    let all = LocalIrradiance.settings().iter().collect();
    let given = given
        .iter()
        .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
        .collect();
    let values = Values::new(LocalIrradiance.name(), all, &given).expect("settings");
    Settings::of(&values).expect("settings of tables")
}

/// Settings of tables of every kind and number format, small enough for inputs of a few kilobytes.
pub const TABLES: [&[(&str, &str)]; 8] = [
    &[("space", "grid"), ("cells", "2"), ("storage", "u8")],
    &[("space", "grid"), ("cells", "3"), ("storage", "f16")],
    &[
        ("space", "shells"),
        ("shells", "2"),
        ("shell-level", "0"),
        ("storage", "f32"),
    ],
    &[
        ("space", "multi-resolution"),
        ("tree", "grid"),
        ("cells", "4"),
        ("storage", "u8"),
    ],
    &[
        ("space", "multi-resolution"),
        ("shells", "2"),
        ("shell-level", "1"),
        ("storage", "f16"),
    ],
    &[
        ("space", "shell-harmonics"),
        ("shells", "2"),
        ("shell-level", "1"),
        ("order", "2"),
        ("storage", "f32"),
    ],
    &[
        ("space", "grid"),
        ("cells", "2"),
        ("directions", "harmonics"),
        ("order", "2"),
        ("storage", "f32"),
    ],
    &[("space", "grid"), ("cells", "2"), ("storage", "exact")],
];

/// A kind of table: what its settings ask for.
struct TableKind {
    key: Key,
    expected: Expected,
    shells: u32,
}

/// All kinds of tables that are read.
fn table_kinds() -> &'static [TableKind] {
    static KINDS: OnceLock<Vec<TableKind>> = OnceLock::new();
    KINDS.get_or_init(|| {
        let kinds = TABLES.iter().map(|given| {
            let settings = table_settings(given);
            let radii: Vec<f64> = (0..=settings.shells).map(f64::from).collect();
            let layout = Layout::new(&settings, 1.0, &radii, 0.0);
            TableKind {
                key: Key::new(&Arc::from("a form"), Content::Sample(0)),
                expected: Expected::new(&settings, &layout),
                shells: settings.shells,
            }
        });
        kinds.collect()
    })
}

/// A table: its first byte says the kind, and whether the rest is a file or the content of one. Changes of a
/// file would all be found by its checksum.
fn table(bytes: &[u8]) {
    let Some((first, rest)) = bytes.split_first() else {
        return;
    };
    let kinds = table_kinds();
    let kind = &kinds[usize::from(first & 7) % kinds.len()];
    let whole = if first & 8 == 0 {
        sealed(&kind.key, rest)
    } else {
        rest.to_vec()
    };
    drop(table_of(&whole, &kind.key, &kind.expected));
    drop(radii_of(
        &whole,
        &kind.key,
        kind.shells,
        f64::from(kind.shells),
    ));
}
