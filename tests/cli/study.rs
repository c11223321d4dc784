//! `nephroid validate` as a user meets it: reports, figures, candidates, limits, interruption.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use assert_cmd::Command;
use nephroid::film::{Image, exr};
use serde_json::Value;

struct Folder(tempfile::TempDir);

const SIZE: usize = 32;

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

fn scene() -> PathBuf {
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
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.study("a.toml", STUDY);
        folder
    }

    /// With the films of `a.toml`, as if it had run there before.
    fn with_films() -> Self {
        let folder = Self::new();
        fs::create_dir_all(folder.path("r/runs")).unwrap();
        for film in fs::read_dir(films()).unwrap() {
            let film = film.unwrap();
            let copy = folder.path("r/runs").join(film.file_name());
            fs::copy(film.path(), copy).unwrap();
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn study(&self, name: &str, rest: &str) {
        write_study(&self.path(name), rest);
    }

    /// The study of two sensors, of a small camera.
    fn two_sensors(&self) {
        let sizes = [("640", "24"), ("480", "16"), ("\"512\"", "\"32\"")];
        let mut xml = fs::read_to_string(scene()).unwrap();
        for (shipped, small) in sizes {
            assert!(xml.contains(shipped), "{shipped}");
            xml = xml.replace(shipped, small);
        }
        fs::write(self.path("small.xml"), xml).unwrap();
        fs::write(self.path("two.toml"), SENSORS).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::cargo_bin("nephroid").unwrap();
        command
            .current_dir(self.0.path())
            .args(arguments)
            .output()
            .unwrap()
    }

    /// Validates, and reads what the report says of the first sensor; the exit code with it.
    fn validate(&self, arguments: &[&str]) -> (Value, Option<i32>, String) {
        let all: Vec<&str> = ["validate"].iter().chain(arguments).copied().collect();
        let output = self.run(&all);
        let said = text(&output.stderr);
        let first = self.report(&said)["sensors"][0].clone();
        (first, output.status.code(), said)
    }

    fn report(&self, said: &str) -> Value {
        let report = fs::read(self.path("r/report.json")).unwrap_or_else(|_| panic!("{said}"));
        serde_json::from_slice(&report).unwrap()
    }

    fn truth(&self, report: &Value) -> Image {
        let file = report["truth"]["file"].as_str().unwrap();
        exr::read(&self.path("r").join(file)).unwrap()
    }

    /// Writes an image of all light as Mitsuba would: the truth's, changed.
    fn candidate(
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

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// All light of a truth's texel; beyond the border that of the nearest texel.
fn light(truth: &Image, x: isize, y: isize) -> [f64; 3] {
    let clamp = |at: isize, size: usize| at.clamp(0, size as isize - 1) as usize;
    let at = clamp(y, truth.height) * truth.width + clamp(x, truth.width);
    ["E.R", "E.G", "E.B"].map(|name| f64::from(truth.channel(name).unwrap().samples[at]))
}

fn row<'a>(report: &'a Value, name: &str) -> &'a Value {
    let rows = report["rows"].as_array().unwrap();
    rows.iter().find(|row| row["name"] == name).unwrap()
}

fn kinds(row: &Value) -> Vec<&str> {
    let checks = row["checks"].as_array().unwrap();
    checks
        .iter()
        .map(|check| check["kind"].as_str().unwrap())
        .collect()
}

#[test]
fn figures_are_those_of_compare_to_the_last_digit() {
    let folder = Folder::with_films();
    let (report, code, said) = folder.validate(&["a.toml", "-o", "r"]);
    assert_eq!(code, Some(0), "{said}");
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let command = row["compare"].as_str().unwrap();
        let words: Vec<&str> = command.split(' ').skip(1).chain(["--json"]).collect();
        let mut compare = Command::cargo_bin("nephroid").unwrap();
        let output = compare
            .current_dir(folder.path("r"))
            .args(words)
            .output()
            .unwrap();
        let compared: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(row["comparison"]["layers"], compared["layers"], "{command}");
        assert_eq!(row["comparison"]["notes"], compared["notes"]);
        let total = &compared["layers"][0];
        assert_eq!(row["error"], total["difference"]["relative_rmse"]);
        assert_eq!(row["bias"], total["equivalence"]["bias"]["relative"]);
    }
}

#[test]
fn a_rows_command_makes_its_film() {
    let folder = Folder::with_films();
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    for name in ["beams", "photons"] {
        let row = row(&report, name);
        let command = row["command"].as_str().unwrap();
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        assert!(folder.run(&words).status.success(), "{command}");
        let kept = exr::read(&folder.path("r").join(row["file"].as_str().unwrap())).unwrap();
        let made = exr::read(&folder.path(words.last().unwrap())).unwrap();
        for channel in &kept.channels {
            let other = made.channel(&channel.name).unwrap();
            let bits = |samples: &[f32]| samples.iter().map(|it| it.to_bits()).collect::<Vec<_>>();
            assert_eq!(
                bits(&channel.samples),
                bits(&other.samples),
                "{} of {command}",
                channel.name
            );
        }
    }
}

/// Some runs kept and some not is what an interruption leaves, wherever it comes: a run is kept whole or not at all.
#[test]
fn a_resumed_study_has_the_same_report_to_the_byte() {
    let folder = Folder::with_films();
    folder.validate(&["a.toml", "-o", "r"]);
    let whole = fs::read(folder.path("r/report.json")).unwrap();
    let mut films: Vec<PathBuf> = fs::read_dir(folder.path("r/runs"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    films.sort();
    for (i, path) in films.iter().enumerate() {
        match i % 3 {
            0 => fs::remove_file(path).unwrap(),
            // Half a file: as of a full disk, or of a system that stopped.
            1 => fs::write(
                path,
                &fs::read(path).unwrap()[..40.min(fs::metadata(path).unwrap().len() as usize)],
            )
            .unwrap(),
            _ => (),
        }
    }
    let (_, code, said) = folder.validate(&["a.toml", "-o", "r", "--threads", "1"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(fs::read(folder.path("r/report.json")).unwrap() == whole);
    let (_, _, said) = folder.validate(&["a.toml", "-o", "r"]);
    assert_eq!(said.matches("kept from before").count(), 5, "{said}");
    assert!(fs::read(folder.path("r/report.json")).unwrap() == whole);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_the_study_without_a_report_and_the_same_command_goes_on() {
    let folder = Folder::new();
    // The last run takes minutes, the first ones do not.
    folder.study(
        "long.toml",
        "[truth]\nmethod = \"beams\"\nerror = \"1%\"\n[[method]]\nmethod = \"photons\"\nphotons = [4096, 4000000000]\n",
    );
    let said = folder.path("said");
    let program = assert_cmd::cargo::cargo_bin("nephroid");
    let mut child = std::process::Command::new(program)
        .current_dir(folder.0.path())
        .args(["validate", "long.toml", "-o", "r"])
        .stdout(std::process::Stdio::null())
        .stderr(fs::File::create(&said).unwrap())
        .spawn()
        .unwrap();
    let start = Instant::now();
    // Generous for a machine that is busy; the run that is stopped takes far longer.
    let patience = Duration::from_secs(120);
    while !fs::read_to_string(&said)
        .unwrap()
        .contains("[ 3/3] photons=4000000000 ...")
    {
        assert!(
            start.elapsed() < patience,
            "{}",
            fs::read_to_string(&said).unwrap()
        );
        std::thread::sleep(Duration::from_millis(50));
    }
    let kill = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(kill.success());
    let status = child.wait().unwrap();
    let said = fs::read_to_string(&said).unwrap();
    assert_eq!(status.code(), Some(1), "{said}");
    assert!(said.contains("2 of 3 runs are kept"), "{said}");
    assert!(!folder.path("r/report.json").exists());
    let list = folder.run(&["validate", "long.toml", "-o", "r", "--list"]);
    assert_eq!(
        text(&list.stdout).matches("kept").count(),
        2,
        "{}",
        text(&list.stdout)
    );
}

#[test]
fn the_truth_scaled_is_a_bias_and_not_a_mistake() {
    let folder = Folder::with_films();
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    let truth = folder.truth(&report);
    folder.candidate("mine.exr", &truth, |truth, x, y| {
        light(truth, x as isize, y as isize).map(|value| 1.02 * value)
    });
    let (report, code, said) = folder.validate(&[
        "a.toml",
        "-o",
        "r",
        "--candidate",
        "mine=mine.exr",
        "--max-error",
        "mine=50%",
    ]);
    assert_eq!(code, Some(0), "{said}");
    let mine = row(&report, "mine");
    // Each texel is rounded to f32, 6e-8 of it at most.
    assert!(
        (mine["bias"].as_f64().unwrap() - 0.02).abs() < 1e-7,
        "{mine}"
    );
    assert_eq!(kinds(mine), Vec::<&str>::new());
    assert_eq!(report["gates"][0]["verdict"], "kept");
    let summary = fs::read_to_string(folder.path("r/summary.md")).unwrap();
    assert!(summary.contains("+2.00 %"), "{summary}");
}

#[test]
fn moved_turned_and_wrongly_scaled_candidates_are_flagged() {
    let folder = Folder::new();
    // Ripples have no symmetry that hides how an image lies.
    let water = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/water.xml");
    let water = water.display().to_string();
    let size = format!("size={SIZE}");
    let first = ["-D", size.as_str(), "-o", "r"];
    fs::write(
        folder.path("p.toml"),
        format!("scene = {water:?}\n[truth]\nmethod = \"beams\"\nerror = \"1%\"\n[[method]]\nmethod = \"beams\"\nerror = \"10%\"\n"),
    )
    .unwrap();
    let (report, _, _) = folder.validate(&[&["p.toml"], &first[..]].concat());
    let truth = folder.truth(&report);
    let last = SIZE as isize - 1;
    folder.candidate("moved.exr", &truth, |truth, x, y| {
        light(truth, x as isize - 1, y as isize)
    });
    folder.candidate("flipped.exr", &truth, |truth, x, y| {
        light(truth, x as isize, last - y as isize)
    });
    folder.candidate("swapped.exr", &truth, |truth, x, y| {
        light(truth, y as isize, x as isize)
    });
    folder.candidate("radiance.exr", &truth, |truth, x, y| {
        light(truth, x as isize, y as isize).map(|value| value / std::f64::consts::PI)
    });
    let names = ["moved", "flipped", "swapped", "radiance"];
    let given: Vec<String> = names
        .iter()
        .map(|name| format!("{name}={name}.exr"))
        .collect();
    let mut arguments = [&["p.toml"], &first[..]].concat();
    for one in &given {
        arguments.extend(["--candidate", one]);
    }
    let (report, _, said) = folder.validate(&arguments);
    let message = |name: &str, kind: &str| {
        let checks = row(&report, name)["checks"].as_array().unwrap();
        let found = checks.iter().find(|check| check["kind"] == kind);
        found.unwrap_or_else(|| panic!("{name}: {checks:?}\n{said}"))["message"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    assert!(message("moved", "shift").contains("(+1, +0)"));
    assert!(message("flipped", "orientation").contains("upside down"));
    assert!(message("swapped", "orientation").contains("transposed"));
    assert!(message("radiance", "units").contains("1/π"));
    assert!(said.contains("warning: moved: it looks shifted"), "{said}");
}

#[test]
fn a_limit_that_is_exceeded_ends_with_1_and_one_that_is_kept_with_0() {
    let folder = Folder::with_films();
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    let rows = report["rows"].as_array().unwrap();
    let errors = rows.iter().filter(|row| row["name"] == "photons");
    let best = errors
        .map(|row| row["error"].as_f64().unwrap())
        .fold(f64::INFINITY, f64::min);
    for (factor, code, verdict) in [
        (1.5, 0, "kept"),
        (0.5, 1, "exceeded"),
        (1.0, 1, "undecided"),
    ] {
        let limit = format!("photons={}", factor * best);
        let (report, found, said) = folder.validate(&["a.toml", "-o", "r", "--max-error", &limit]);
        assert_eq!(report["gates"][0]["verdict"], verdict, "{said}");
        assert_eq!(found, Some(code), "{said}");
    }
}

#[test]
fn a_row_that_the_truth_cannot_resolve_is_said_to_be_so() {
    let folder = Folder::new();
    // The same beams as the truth's: no difference to resolve.
    folder.study(
        "same.toml",
        "[truth]\nmethod = \"beams\"\nerror = \"5%\"\n[[method]]\nmethod = \"beams\"\nerror = [\"5%\", \"1%\"]\n[[method]]\nmethod = \"photons\"\nphotons = 64\n",
    );
    let (report, _, _) = folder.validate(&["same.toml", "-o", "r"]);
    for row in report["rows"].as_array().unwrap() {
        let [error, truth] = ["error", "truth_error"].map(|key| row[key].as_f64().unwrap());
        assert_eq!(
            row["resolved"],
            error > 0.0 && truth <= 0.1 * error,
            "{row}"
        );
    }
    assert_eq!(report["rows"][0]["resolved"], false);
    assert_eq!(report["rows"][2]["resolved"], true);
    let summary = fs::read_to_string(folder.path("r/summary.md")).unwrap();
    assert!(summary.contains("not resolved"), "{summary}");
}

#[test]
fn the_first_line_comes_within_two_seconds() {
    use std::io::BufRead as _;
    let folder = Folder::new();
    let program = assert_cmd::cargo::cargo_bin("nephroid");
    let start = Instant::now();
    let mut child = std::process::Command::new(program)
        .current_dir(folder.0.path())
        .args(["validate", &scene().display().to_string(), "-o", "r"])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    let mut reader = std::io::BufReader::new(child.stderr.take().unwrap());
    reader.read_line(&mut line).unwrap();
    let elapsed = start.elapsed();
    child.kill().unwrap();
    child.wait().unwrap();
    // The truth, 3 + 5 runs of references, 4 of caustic maps, and 1 + 2 · 7 of their stages.
    assert!(line.contains("28 runs"), "{line}");
    assert!(elapsed < Duration::from_secs(2), "{elapsed:?}");
}

#[test]
fn what_cannot_be_validated_ends_with_2_and_says_why() {
    let folder = Folder::new();
    let refused = |arguments: &[&str], says: &str| {
        let all: Vec<&str> = ["validate"].iter().chain(arguments).copied().collect();
        let output = folder.run(&all);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(says), "{said}");
        assert!(!folder.path("r/index.html").exists());
    };
    refused(&["nowhere.toml", "-o", "r"], "nowhere.toml");
    refused(&["nowhere.xml", "-o", "r"], "nowhere.xml");
    refused(
        &["a.toml", "-o", "r", "--max-error", "fotons=5%"],
        "did you mean \"photons\"?",
    );
    refused(
        &["a.toml", "-o", "r", "--candidate", "mine=nowhere.exr"],
        "nowhere.exr",
    );
    let mut holed = Image::new(SIZE, SIZE);
    holed.add_rgb("", &vec![[f64::NAN; 3]; SIZE * SIZE]);
    exr::write(&folder.path("holed.exr"), &holed).unwrap();
    refused(
        &["a.toml", "-o", "r", "--candidate", "mine=holed.exr"],
        "holed.exr",
    );
    let mut wide = Image::new(SIZE / 2, SIZE);
    wide.add_rgb("", &vec![[1.0; 3]; SIZE / 2 * SIZE]);
    exr::write(&folder.path("wide.exr"), &wide).unwrap();
    refused(
        &["a.toml", "-o", "r", "--candidate", "mine=wide.exr"],
        "sensor \"floor\" has 32 x 32",
    );
}

#[test]
fn the_page_needs_nothing_else_and_no_text_in_it_ends_its_script() {
    let folder = Folder::with_films();
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    let truth = folder.truth(&report);
    folder.candidate("mine.exr", &truth, |truth, x, y| {
        light(truth, x as isize, y as isize)
    });
    let name = "</script><script>alert(1)</script>=mine.exr";
    let (_, code, said) = folder.validate(&["a.toml", "-o", "r", "--candidate", name]);
    assert_eq!(code, Some(0), "{said}");
    let page = fs::read_to_string(folder.path("r/index.html")).unwrap();
    assert_eq!(page.matches("</script>").count(), 2);
    assert!(!page.contains("alert(1)</script>"));
    for outside in ["src=\"http", "href=\"http", "@import", "url(http", "fetch("] {
        assert!(!page.contains(outside), "{outside}");
    }
    for left in ["{{title}}", "{{data}}", "/*style*/", "/*script*/"] {
        assert!(!page.contains(left), "{left}");
    }
    let csv = fs::read_to_string(folder.path("r/report.csv")).unwrap();
    assert_eq!(csv.lines().count(), 6);
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

#[test]
fn each_of_several_sensors_has_its_truth_its_runs_its_candidates_and_its_limits() {
    let folder = Folder::new();
    folder.two_sensors();
    let mut grey = Image::new(SIZE, SIZE);
    grey.add_rgb("", &vec![[1.0; 3]; SIZE * SIZE]);
    exr::write(&folder.path("grey.exr"), &grey).unwrap();
    let placed = [
        "--candidate",
        "mine@floor=grey.exr",
        "--max-error",
        "mine=1000",
    ];
    let arguments = [&["two.toml", "-o", "r"], &placed[..]].concat();
    let (_, code, said) = folder.validate(&arguments);
    assert_eq!(code, Some(0), "{said}");
    let report = folder.report(&said);
    let of = |sensor: usize, list: &str, key: &str| -> Vec<String> {
        let all = report["sensors"][sensor][list].as_array().unwrap();
        let texts = all.iter().map(|one| one[key].as_str().unwrap().to_owned());
        texts.collect()
    };
    assert_eq!(of(0, "rows", "name"), ["beams here", "mine"]);
    assert_eq!(of(1, "rows", "name"), ["path"]);
    assert_eq!(of(0, "gates", "name"), ["mine"]);
    assert_eq!(of(1, "gates", "name"), ["path"]);
    assert_eq!(report["sensors"][0]["truth"]["method"], "beams");
    assert_eq!(report["sensors"][1]["truth"]["method"], "path");
    assert_eq!(report["sensors"][1]["unit"], "W/m²/sr");
    let page = fs::read_to_string(folder.path("r/index.html")).unwrap();
    let data = page.split("id=\"data\">").nth(1).unwrap();
    let data: Value = serde_json::from_str(data.split("</script>").next().unwrap()).unwrap();
    assert_eq!(data["pictures"].as_array().unwrap().len(), 2);
    assert_eq!(data["pictures"][1]["size"], report["sensors"][1]["size"]);
    let (_, code, said) = folder.validate(&arguments);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(said.matches("kept from before").count(), 4, "{said}");
}

#[test]
fn an_image_that_could_be_of_several_sensors_must_name_its_own() {
    let folder = Folder::new();
    folder.two_sensors();
    for (arguments, says) in [
        (
            ["--candidate", "mine=grey.exr"],
            "--candidate mine@floor=FILE.exr",
        ),
        (
            ["--candidate", "mine@flour=grey.exr"],
            "did you mean \"floor\"?",
        ),
        (
            ["--max-error", "path@floor=5%"],
            "there are beams here, path, beams here@floor, path@camera",
        ),
        (["--sensor", "celing"], "no sensor with id \"celing\""),
    ] {
        let output = folder.run(&[&["validate", "two.toml", "-o", "r"], &arguments[..]].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(says), "{said}");
    }
}

/// In a package or an archive without its repository it is unknown; here it is a hash, or that.
#[test]
fn the_record_names_the_commit_and_the_report_does_not() {
    let folder = Folder::with_films();
    let (_, _, said) = folder.validate(&["a.toml", "-o", "r"]);
    let timings = fs::read(folder.path("r/timings.json")).unwrap();
    let timings: Value = serde_json::from_slice(&timings).unwrap();
    let commit = timings["commit"].as_str().unwrap();
    let hash = commit.trim_end_matches("-modified");
    let is_hash = hash.len() >= 40 && hash.chars().all(|c| c.is_ascii_hexdigit());
    assert!(is_hash || commit == "unknown", "{commit}");
    assert!(!folder.report(&said).to_string().contains(commit));
}

#[test]
fn a_report_of_two_machines_tells_them_by_run_and_fits_no_order_to_their_seconds() {
    let folder = Folder::with_films();
    let timings = || -> Value {
        serde_json::from_slice(&fs::read(folder.path("r/timings.json")).unwrap()).unwrap()
    };
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    let curves = report["curves"].as_array().unwrap();
    let photons = curves.iter().position(|curve| curve["name"] == "photons");
    let before = timings();
    let sensor = &before["sensors"][0];
    assert!(sensor["orders"][photons.unwrap()].is_object(), "{sensor}");
    assert_eq!(sensor["notes"].as_array().unwrap().len(), 0);
    let host = &sensor["truth"]["machine"]["host"];
    assert!(before.get("machine").is_none());
    for row in sensor["rows"].as_array().unwrap() {
        assert_eq!(row["machine"]["host"], *host);
        assert!(row["machine"]["processor"].is_string() && row["threads"].is_u64());
    }
    // One run, as if it had been made elsewhere and its folder copied.
    let film = row(&report, "photons")["file"].as_str().unwrap().to_owned();
    let time = folder.path("r").join(film.replace(".exr", ".time.json"));
    let mut elsewhere: Value = serde_json::from_slice(&fs::read(&time).unwrap()).unwrap();
    elsewhere["machine"]["host"] = "elsewhere".into();
    fs::write(&time, elsewhere.to_string()).unwrap();
    let (again, code, said) = folder.validate(&["a.toml", "-o", "r"]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(again, report);
    let after = timings();
    let sensor = &after["sensors"][0];
    assert!(sensor["orders"][photons.unwrap()].is_null(), "{sensor}");
    let note = sensor["notes"][0].as_str().unwrap();
    assert!(note.starts_with("photons: no order in seconds"), "{note}");
    let summary = fs::read_to_string(folder.path("r/summary.md")).unwrap();
    assert!(summary.contains("on elsewhere, "), "{summary}");
    assert!(summary.contains(note), "{summary}");
}
