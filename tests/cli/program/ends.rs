//! Ends of runs: by budget, by failure, by interrupt, by a reader that leaves.

use nephroid::internals::film::exr;

use super::folder::{Folder, nephroid, scene, text};

#[test]
fn a_failed_run_leaves_the_old_result_alone() {
    let folder = Folder::new();
    let path = folder.path("kept.exr");
    let output = path.to_str().unwrap();
    let good = nephroid(&[
        "render",
        &scene("glass-ball.xml"),
        "--photons",
        "1000",
        "-D",
        "size=8",
        "-o",
        output,
    ]);
    assert!(good.status.success());
    let before = std::fs::read(&path).unwrap();
    let bad = nephroid(&[
        "render",
        &scene("glass-ball.xml"),
        "--method",
        "photons",
        "--sensor",
        "door",
        "-o",
        output,
    ]);
    assert_eq!(bad.status.code(), Some(2));
    assert!(std::fs::read(&path).unwrap() == before);
    let entries = std::fs::read_dir(folder.0.path()).unwrap().count();
    assert_eq!(entries, 2, "only the EXR and its picture");
}

#[test]
fn budgets_of_time_and_error_end_a_run() {
    let folder = Folder::new();
    let path = folder.path("b.exr");
    let output = path.to_str().unwrap();
    let run = |limit: [&str; 2]| -> serde_json::Value {
        let output = nephroid(&[
            "render",
            &scene("glass-ball.xml"),
            limit[0],
            limit[1],
            "--method",
            "photons",
            "-D",
            "size=32",
            "--json",
            "-o",
            output,
        ]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let summary = run(["--error", "8%"]);
    assert!(summary["relative_error"].as_f64().unwrap() <= 0.08);
    let summary = run(["--time", "1s"]);
    // What is left of the second after a round is not begun anew: well under ten in all.
    assert!(summary["timing"]["seconds"].as_f64().unwrap() < 10.0);
    assert!(summary["photons"].as_u64().unwrap() > 0);
    let summary = run(["--photons", "1"]);
    assert_eq!(summary["photons"].as_u64().unwrap(), 1);
    assert!(summary["relative_error"].is_null());
}

#[test]
fn a_run_without_a_finished_replicate_does_not_pass_darkness_off_as_a_result() {
    let folder = Folder::new();
    let path = folder.path("none.exr");
    let output = nephroid(&[
        "render",
        &scene("glass-ball.xml"),
        "-D",
        "size=16",
        "--time",
        "0s",
        "-o",
        path.to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(1));
    let summary = text(&output.stdout);
    assert!(summary.contains("INCOMPLETE"), "{summary}");
    assert!(
        summary.contains("nothing is known of the caustic"),
        "{summary}"
    );
    let image = exr::read(&path).unwrap();
    assert_eq!(image.metadata("complete"), Some("no"));
}

#[test]
fn a_time_that_no_clock_can_tell_is_no_limit() {
    let folder = Folder::new();
    let path = folder.path("long.exr");
    for method in ["beams", "photons"] {
        let output = nephroid(&[
            "render",
            &scene("glass-ball.xml"),
            "-D",
            "size=8",
            "--method",
            method,
            "--error",
            "90%",
            "--time",
            "9300000000000000000s",
            "-o",
            path.to_str().unwrap(),
        ]);
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_writes_what_there_is_and_marks_it() {
    use std::process::{Command, Stdio};
    use std::time::Duration;
    let folder = Folder::new();
    let path = folder.path("c.exr");
    let child = Command::new(env!("CARGO_BIN_EXE_nephroid"))
        .args([
            "render",
            &scene("glass-ball.xml"),
            "-D",
            "size=64",
            "--photons",
            "40000000000",
        ])
        .args(["-o", path.to_str().unwrap()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(3));
    let interrupted = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(interrupted.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let image = exr::read(&path).unwrap();
    assert_eq!(image.metadata("complete"), Some("no"));
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_heard_enough_is_no_error() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_nephroid"))
        .args(["inspect", &scene("glass-ball.xml")])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The pipe is closed before anything is written into it.
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(text(&output.stderr), "");
    assert!(output.status.success());
}
