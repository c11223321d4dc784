//! Little time, little memory, an end at any moment (docs/accuracy.md, 9).

#![cfg(unix)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use nephroid::film::exr;
use tempfile::TempDir;

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name)
}

/// `nephroid render` of the glass ball.
fn render(size: usize, output: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nephroid"));
    command
        .arg("render")
        .arg(scene("glass-ball.xml"))
        .args(["-D", &format!("size={size}"), "-o"])
        .arg(output)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The most memory \[bytes\] that a program had at once, as the system counts it, and how it ended.
#[cfg(target_os = "linux")]
fn peak_memory(mut child: Child) -> u64 {
    let file = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    loop {
        if let Some(kilobytes) = fs::read_to_string(&file).ok().and_then(|status| {
            let line = status
                .lines()
                .find_map(|line| line.strip_prefix("VmHWM:"))?
                .trim()
                .to_owned();
            line.strip_suffix("kB")?.trim().parse::<u64>().ok()
        }) {
            peak = peak.max(1024 * kilobytes);
        }
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success());
            return peak;
        }
        thread::sleep(Duration::from_millis(2));
    }
}

/// What `inspect` says that the floor's film takes at most \[bytes\].
#[cfg(target_os = "linux")]
fn said(size: usize, method: &str) -> u64 {
    let output = Command::new(env!("CARGO_BIN_EXE_nephroid"))
        .arg("inspect")
        .arg(scene("glass-ball.xml"))
        .args(["-D", &format!("size={size}"), "--json"])
        .output()
        .unwrap();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    json["sensors"][0]["film_bytes"][method].as_u64().unwrap()
}

/// Program, threads' stacks and buffers take the same for any film: the film is what a large one takes more than a small one.
/// The system counts in pages and an allocator rounds up: 8 MB for both.
#[cfg(target_os = "linux")]
#[test]
fn a_film_takes_no_more_memory_than_inspect_says() {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("a.exr");
    for (method, arguments) in [
        ("photons", ["--photons", "65536"].as_slice()),
        ("beams", &["--method", "beams", "--error", "10%"]),
    ] {
        let [small, large] =
            [16, 512].map(|size| peak_memory(render(size, &output, arguments).spawn().unwrap()));
        let most = said(512, method);
        println!(
            "{method}: {:.0} MB more for 512 x 512 texels; {:.0} MB at most, as inspect says",
            (large - small) as f64 / 1e6,
            most as f64 / 1e6
        );
        assert!(large - small <= most + 8_000_000, "{method}");
        // And not so much that a film that fits would be refused.
        assert!(most <= 4 * (large - small), "{method}");
    }
}

/// Photons are not kept: tasks, a few for each thread, are all that there is of them.
#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_number_of_photons() {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("a.exr");
    let [few, many] = ["65536", "4194304"].map(|photons| {
        peak_memory(
            render(64, &output, &["--photons", photons])
                .spawn()
                .unwrap(),
        )
    });
    println!(
        "{:.1} MB for 2^16 photons, {:.1} MB for 2^22",
        few as f64 / 1e6,
        many as f64 / 1e6
    );
    assert!(many <= few + 8_000_000, "{few} {many}");
}

/// What is in the file: all that a reader is told.
fn assert_marked_incomplete_and_unknown(path: &Path, total: &str) {
    let image = exr::read(path).unwrap();
    assert_eq!(image.metadata("complete"), Some("no"), "{}", path.display());
    let channel = image.channel(total).unwrap();
    assert!(
        channel.samples.iter().all(|sample| sample.is_nan()),
        "{}",
        path.display()
    );
}

#[test]
fn without_any_time_every_method_says_that_nothing_is_known() {
    let folder = TempDir::new().unwrap();
    for (method, sensor, total) in [
        ("beams", "floor", "E.G"),
        ("photons", "floor", "E.G"),
        ("path", "camera", "L.G"),
        ("photon-map", "camera", "L.G"),
        ("full", "camera", "L.G"),
    ] {
        let path = folder.path().join(format!("{method}.exr"));
        let arguments = ["--method", method, "--sensor", sensor, "--time", "0"];
        let output = render(16, &path, &arguments).output().unwrap();
        assert_eq!(
            output.status.code(),
            Some(1),
            "{method}: {}",
            message(&output)
        );
        assert_marked_incomplete_and_unknown(&path, total);
    }
}

fn signal(child: &Child, name: &str) {
    let kill = Command::new("kill")
        .args([name, &child.id().to_string()])
        .status();
    assert!(kill.unwrap().success());
}

/// Interrupts a program until it ends: one that was started in the background of a shell ignores what comes before it listens.
fn interrupt(child: &mut Child) {
    for _ in 0..4 {
        signal(child, "-INT");
        let sent = Instant::now();
        while sent.elapsed() < Duration::from_secs(10) {
            if child.try_wait().unwrap().is_some() {
                return;
            }
            thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Runs that last some seconds, interrupted after each of these times \[ms\]: while the program starts, reads, surveys, traces, goes
/// from pass to pass.
const MOMENTS: [u64; 8] = [0, 3, 10, 30, 100, 300, 700, 1500];

const ENDLESS: [[&str; 4]; 3] = [
    ["--method", "beams", "--error", "0.0001%"],
    ["--method", "photons", "--photons", "40000000000"],
    ["--method", "path", "--sensor", "camera"],
];

#[test]
fn an_interrupt_at_any_moment_leaves_no_file_or_one_that_is_marked() {
    let folder = TempDir::new().unwrap();
    for arguments in &ENDLESS {
        let mut left = Vec::new();
        for moment in MOMENTS {
            let path = folder.path().join("a.exr");
            let start = Instant::now();
            let mut child = render(64, &path, arguments).spawn().unwrap();
            thread::sleep(Duration::from_millis(moment));
            interrupt(&mut child);
            let output = child.wait_with_output().unwrap();
            // A pass or a round is left in its middle: seconds at most, on a machine however busy.
            assert!(
                start.elapsed() < Duration::from_secs(60),
                "{arguments:?} after {moment} ms"
            );
            if path.exists() {
                assert_eq!(
                    output.status.code(),
                    Some(1),
                    "{arguments:?} after {moment} ms: {}",
                    message(&output)
                );
                let image = exr::read(&path).unwrap();
                assert_eq!(
                    image.metadata("complete"),
                    Some("no"),
                    "{arguments:?} after {moment} ms"
                );
                fs::remove_file(&path).unwrap();
                left.push(moment);
            }
            let _ = fs::remove_file(path.with_extension("png"));
            assert_eq!(
                fs::read_dir(folder.path()).unwrap().count(),
                0,
                "{arguments:?} after {moment} ms"
            );
        }
        println!("{arguments:?}: files after {left:?} ms");
        assert!(left.contains(&1500), "{arguments:?}: {left:?}");
    }
}

/// No time to write anything: what was there before is there still, whole.
#[test]
fn a_kill_at_any_moment_leaves_the_old_result() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.exr");
    let first = render(16, &path, &["--photons", "4096"]).output().unwrap();
    assert!(first.status.success(), "{}", message(&first));
    let before = fs::read(&path).unwrap();
    for moment in MOMENTS {
        let mut child = render(64, &path, &ENDLESS[1]).spawn().unwrap();
        thread::sleep(Duration::from_millis(moment));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(fs::read(&path).unwrap() == before, "after {moment} ms");
    }
}
