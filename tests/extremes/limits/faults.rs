//! A full disk, a folder that takes no file, a file that can be read only once, a signal: a clear error or a
//! marked result, and the old result whole.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use nephroid::internals::film::exr;
use tempfile::TempDir;

use super::program::{message, render, scene};
use super::stops::PHOTONS;

/// Runs a script of the shell in a folder, with the program as `$N` and the glass ball as `$B`.
fn shell(folder: &Path, script: &str) -> Output {
    Command::new("sh")
        .args(["-c", script])
        .env("N", env!("CARGO_BIN_EXE_nephroid"))
        .env("B", scene("glass-ball.xml"))
        .current_dir(folder)
        .output()
        .unwrap()
}

/// The same where all of it must succeed.
fn prepare(folder: &Path, script: &str) {
    let output = shell(folder, script);
    assert!(output.status.success(), "{}", message(&output));
}

/// The file in a folder after a run that could not write its result.
fn assert_refused_and_kept(output: &Output, path: &Path, old: &[u8], reasons: &[&str]) {
    let said = message(output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("cannot write"), "{said}");
    assert!(
        said.contains(&*path.file_name().unwrap().to_string_lossy()),
        "{said}"
    );
    assert!(reasons.iter().any(|reason| said.contains(reason)), "{said}");
    assert!(fs::read(path).unwrap() == old, "the old result is another");
    let names: Vec<_> = fs::read_dir(path.parent().unwrap())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .filter(|name| name.to_string_lossy().ends_with(".partial"))
        .collect();
    assert!(names.is_empty(), "{names:?}");
}

/// Each command's result, of some hundred kilobytes where there is room for eight.
#[test]
fn a_file_that_grows_beyond_what_is_allowed_leaves_the_old_one() {
    let folder = TempDir::new().unwrap();
    prepare(
        folder.path(),
        "$N render $B -D size=128 --photons 65536 -o a.exr && $N render $B -D size=128 --photons 4096 --shard 1/1 -o a.shard",
    );
    // Blocks of 512 bytes, or of 1024 of some shells. Without a trap the system would end the program.
    let limited = "trap '' XFSZ; ulimit -f 8; exec $N";
    for (file, arguments) in [
        (
            "a.exr",
            "render $B -D size=128 --photons 65536 --seed 2 -o a.exr",
        ),
        (
            "a.shard",
            "render $B -D size=128 --photons 65536 --shard 1/1 -o a.shard",
        ),
        (
            "a.exr",
            "merge $B -D size=128 --photons 4096 a.shard -o a.exr",
        ),
    ] {
        let path = folder.path().join(file);
        let old = fs::read(&path).unwrap();
        assert!(old.len() > 8192, "{file}: {}", old.len());
        let output = shell(folder.path(), &format!("{limited} {arguments}"));
        assert_refused_and_kept(&output, &path, &old, &["File too large"]);
    }
}

/// A disk of 300 kB that a first result half fills. Whoever may not mount one skips this.
#[test]
fn a_full_disk_leaves_the_old_result() {
    let folder = TempDir::new().unwrap();
    fs::create_dir(folder.path().join("d")).unwrap();
    let script = "mount -t tmpfs -o size=300k none d 2>/dev/null || { echo no mount; exit 77; }
        $N render $B -D size=64 --photons 4096 -o d/a.exr >/dev/null 2>&1 || exit 78
        cp d/a.exr before
        $N render $B -D size=512 --photons 65536 -o d/a.exr; code=$?
        cmp d/a.exr before || exit 79
        ls -A d | grep partial && exit 80
        exit $code";
    let output = Command::new("unshare")
        .args(["--mount", "sh", "-c", script])
        .env("N", env!("CARGO_BIN_EXE_nephroid"))
        .env("B", scene("glass-ball.xml"))
        .current_dir(folder.path())
        .output();
    let Ok(output) = output else {
        println!("skipped: there is no unshare");
        return;
    };
    let said = message(&output);
    match output.status.code() {
        Some(77 | 1) if !said.contains("error:") => {
            println!("skipped: nothing can be mounted here")
        }
        code => {
            assert_eq!(code, Some(2), "{said}");
            assert!(
                said.contains("cannot write") && said.contains("No space left"),
                "{said}"
            );
        }
    }
}

#[test]
fn a_folder_that_takes_no_file_is_refused_before_the_run() {
    let folder = TempDir::new().unwrap();
    // Not even root can make a file there.
    let nowhere = Path::new("/proc/nephroid.exr");
    let start = Instant::now();
    if Path::new("/proc/version").exists() {
        let output = render(16, nowhere, PHOTONS).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(
            message(&output).contains("cannot write /proc/nephroid.exr"),
            "{}",
            message(&output)
        );
    }
    prepare(
        folder.path(),
        "mkdir d && $N render $B -D size=16 --photons 4096 -o d/a.exr && chmod 555 d",
    );
    let path = folder.path().join("d/a.exr");
    let old = fs::read(&path).unwrap();
    if shell(folder.path(), "touch d/probe 2>/dev/null")
        .status
        .success()
    {
        println!("half skipped: root may write into any folder");
    } else {
        let output = render(16, &path, PHOTONS).output().unwrap();
        assert_refused_and_kept(&output, &path, &old, &["Permission denied"]);
    }
    shell(folder.path(), "chmod 755 d");
    // Photons of hours: nobody waited for these.
    assert!(start.elapsed() < Duration::from_secs(60));
}

/// A pipe gives its bytes once, and then they are gone: as a file that vanishes after it was read.
#[test]
fn an_image_that_is_judged_is_read_once() {
    let folder = TempDir::new().unwrap();
    prepare(
        folder.path(),
        "mkfifo pipe.exr && $N render $B -D size=16 --photons 4096 -o a.exr",
    );
    fs::write(
        folder.path().join("a.toml"),
        format!(
            "scene = {:?}\ndefine = {{ size = 16 }}\n[truth]\nmethod = \"closed-form\"\nmax-depth = 3\n\
             [[candidate]]\nname = \"mine\"\nfile = \"pipe.exr\"\n",
            scene("glass-ball.xml").display().to_string()
        ),
    )
    .unwrap();
    let bytes = fs::read(folder.path().join("a.exr")).unwrap();
    let pipe = folder.path().join("pipe.exr");
    let mut child = Command::new(env!("CARGO_BIN_EXE_nephroid"))
        .args(["validate", "a.toml", "-o", "r"])
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let writer = thread::spawn(move || {
        let mut pipe = fs::OpenOptions::new().write(true).open(pipe).unwrap();
        pipe.write_all(&bytes).unwrap();
    });
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("it waits for the image once more");
        }
        thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", message(&output));
    writer.join().unwrap();
    let runs = fs::read_dir(folder.path().join("r/runs")).unwrap();
    let is_copy =
        |name: &str| name.starts_with("floor-candidate-1-mine-") && name.ends_with(".exr");
    let copies: Vec<PathBuf> = runs
        .map(|entry| entry.unwrap().path())
        .filter(|path| is_copy(&path.file_name().unwrap().to_string_lossy()))
        .collect();
    let original = fs::read(folder.path().join("a.exr")).unwrap();
    assert_eq!(copies.len(), 1, "{copies:?}");
    assert!(
        fs::read(&copies[0]).unwrap() == original,
        "the copy is another"
    );
}

/// An image that is not there any more, after the study was made: the error names it.
#[test]
fn an_image_that_is_gone_is_named() {
    let folder = TempDir::new().unwrap();
    let output = shell(
        folder.path(),
        "$N validate $B -D size=16 -o r --candidate mine=gone.exr",
    );
    let said = message(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("cannot read gone.exr: No such file"),
        "{said}"
    );
}

/// Nothing reads a clock that can be set: times are of a clock that only goes forward.
#[test]
fn no_time_is_of_a_clock_that_can_jump() {
    fn sources(folder: &Path, found: &mut Vec<String>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                sources(&path, found);
            } else if path.extension().is_some_and(|it| it == "rs") {
                found.push(fs::read_to_string(path).unwrap());
            }
        }
    }
    let mut found = Vec::new();
    sources(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("src"),
        &mut found,
    );
    assert!(found.len() > 100);
    assert!(found.iter().any(|text| text.contains("Instant::now")));
    for word in ["SystemTime", "UNIX_EPOCH", ".modified()", ".created()"] {
        assert!(found.iter().all(|text| !text.contains(word)), "{word}");
    }
}

/// SIGTERM is heard as Ctrl-C is: by whoever shuts a machine down, or a queue that ends a job.
#[test]
fn a_request_to_end_leaves_what_there_is_marked() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.exr");
    let child = render(32, &path, PHOTONS).spawn().unwrap();
    thread::sleep(Duration::from_millis(1500));
    let kill = Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status();
    assert!(kill.unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", message(&output));
    assert_eq!(exr::read(&path).unwrap().metadata("complete"), Some("no"));
}
