//! Small studies in a folder of their own, and their reports.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::OnceLock;

use assert_cmd::Command;
use nephroid::internals::film::{Image, exr};
use serde_json::Value;

pub struct Folder(pub tempfile::TempDir);

pub const SIZE: usize = 32;

/// A study that takes a second: the truth by beams, four runs.
const STUDY: &str = r#"
margin = "5%"
[truth]
method = "beams"
error = "0.1%"
[[method]]
method = "beams"
error = "10%"
[[method]]
method = "photons"
photons = { from = 4096, to = 65536, times = 4 }
"#;

pub fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/glass-ball.xml")
}

/// The films of `STUDY`, made once for all tests: they are found again wherever they are copied to.
fn films() -> &'static Path {
    static FILMS: OnceLock<PathBuf> = OnceLock::new();
    FILMS.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("study");
        // Those of an earlier program are of no use, and may be none.
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        write_study(&folder.join("a.toml"), STUDY);
        let mut command = Command::cargo_bin("nephroid").unwrap();
        let arguments = ["validate", "a.toml", "-o", "r"];
        let made = command.current_dir(&folder).args(arguments).output();
        assert!(made.unwrap().status.success());
        folder.join("r/runs")
    })
}

fn write_study(path: &Path, rest: &str) {
    let contents = format!(
        "scene = {:?}\ndefine = {{ size = {SIZE} }}\n{rest}",
        scene().display().to_string()
    );
    fs::write(path, contents).unwrap();
}

impl Folder {
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.study("a.toml", STUDY);
        folder
    }

    /// With the films of `a.toml`, as if it had run there before.
    pub fn with_films() -> Self {
        let folder = Self::new();
        fs::create_dir_all(folder.path("r/runs")).unwrap();
        for film in fs::read_dir(films()).unwrap() {
            let film = film.unwrap();
            let copy = folder.path("r/runs").join(film.file_name());
            fs::copy(film.path(), copy).unwrap();
        }
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn study(&self, name: &str, rest: &str) {
        write_study(&self.path(name), rest);
    }

    /// The study of two sensors, of a small camera.
    pub fn two_sensors(&self) {
        let sizes = [("640", "24"), ("480", "16"), ("\"512\"", "\"32\"")];
        let mut xml = fs::read_to_string(scene()).unwrap();
        for (shipped, small) in sizes {
            assert!(xml.contains(shipped), "{shipped}");
            xml = xml.replace(shipped, small);
        }
        fs::write(self.path("small.xml"), xml).unwrap();
        fs::write(self.path("two.toml"), SENSORS).unwrap();
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::cargo_bin("nephroid").unwrap();
        command
            .current_dir(self.0.path())
            .args(arguments)
            .output()
            .unwrap()
    }

    /// Validates, and reads what the report says of the first sensor; the exit code with it.
    pub fn validate(&self, arguments: &[&str]) -> (Value, Option<i32>, String) {
        let all: Vec<&str> = ["validate"].iter().chain(arguments).copied().collect();
        let output = self.run(&all);
        let said = text(&output.stderr);
        let first = self.report(&said)["sensors"][0].clone();
        (first, output.status.code(), said)
    }

    pub fn report(&self, said: &str) -> Value {
        let report = fs::read(self.path("r/report.json")).unwrap_or_else(|_| panic!("{said}"));
        serde_json::from_slice(&report).unwrap()
    }

    pub fn truth(&self, report: &Value) -> Image {
        let file = report["truth"]["file"].as_str().unwrap();
        exr::read(&self.path("r").join(file)).unwrap()
    }

    /// Writes an image of all light as Mitsuba would: the truth's, changed.
    pub fn candidate(
        &self,
        name: &str,
        truth: &Image,
        change: impl Fn(&Image, usize, usize) -> [f64; 3],
    ) {
        let mut image = Image::new(truth.width, truth.height);
        let texels = (0..truth.width * truth.height)
            .map(|i| change(truth, i % truth.width, i / truth.width));
        image.add_rgb("", &texels.collect::<Vec<_>>());
        exr::write(&self.path(name), &image).unwrap();
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// All light of a truth's texel; beyond the border that of the nearest texel.
pub fn light(truth: &Image, x: isize, y: isize) -> [f64; 3] {
    let clamp = |at: isize, size: usize| at.clamp(0, size as isize - 1) as usize;
    let at = clamp(y, truth.height) * truth.width + clamp(x, truth.width);
    ["E.R", "E.G", "E.B"].map(|name| f64::from(truth.channel(name).unwrap().samples[at]))
}

pub fn row<'a>(report: &'a Value, name: &str) -> &'a Value {
    let rows = report["rows"].as_array().unwrap();
    rows.iter().find(|row| row["name"] == name).unwrap()
}

pub fn kinds(row: &Value) -> Vec<&str> {
    let checks = row["checks"].as_array().unwrap();
    checks
        .iter()
        .map(|check| check["kind"].as_str().unwrap())
        .collect()
}

/// A receiver and a camera, each with a truth of its own.
const SENSORS: &str = r#"
scene = "small.xml"
sensors = ["floor", "camera"]
[truth.floor]
method = "beams"
error = "1%"
[truth.camera]
method = "path"
spp = 4
[[method]]
method = "path"
spp = 2
[[method]]
name = "beams here"
method = "beams"
error = "10%"
sensor = "floor"
[max-error]
"path@camera" = 1000
"#;
