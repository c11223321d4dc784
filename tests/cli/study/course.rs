//! The course of a study: its first line, interruption, resumption, and what it refuses.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use nephroid::internals::film::{Image, exr};

use super::folder::{Folder, SIZE, scene, text};

/// Some runs kept and some not is what an interruption leaves, wherever it comes: a run is kept whole or not
/// at all.
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
    // The truth, 2 + 5 runs of references, 4 of caustic maps, 3 of caustics volumes, and the attributions to
    // the stages of both.
    assert!(line.contains("22 runs"), "{line}");
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
