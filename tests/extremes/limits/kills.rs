//! Kills at random moments of every command that writes files: nothing is torn, and nothing that was whole is
//! lost.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use nephroid::internals::film::exr;
use nephroid::internals::reference::parts::Part;
use tempfile::TempDir;

use super::program::{message, scene};
use super::replacement::is_same;

/// A command that writes files below a folder.
struct Job {
    name: &'static str,
    folder: TempDir,
    arguments: Vec<String>,
    /// The files of an undisturbed run, below the folder.
    whole: BTreeMap<PathBuf, Vec<u8>>,
    takes: Duration,
}

/// What became of some kills.
#[derive(Debug, Default)]
struct Toll {
    kills: u32,
    /// Of runs that had ended before.
    late: u32,
    /// Temporary files that were left with something in them: kills amid a file.
    amid: u32,
}

impl Job {
    fn new(name: &'static str, before: &[&[&str]], arguments: &[&str]) -> Self {
        let folder = TempDir::new().unwrap();
        let study = format!(
            "scene = {:?}\ndefine = {{ size = 24 }}\n[truth]\nmethod = \"closed-form\"\nmax-depth = 3\n\
             [[method]]\nmethod = \"photons\"\nphotons = [4096, 16384]\n",
            scene("glass-ball.xml").display().to_string()
        );
        fs::write(folder.path().join("a.toml"), study).unwrap();
        let mut job = Self {
            name,
            folder,
            arguments: arguments.iter().map(|it| (*it).to_owned()).collect(),
            whole: BTreeMap::new(),
            takes: Duration::MAX,
        };
        for arguments in before {
            let output = job.command(arguments).output().unwrap();
            assert!(output.status.success(), "{name}: {}", message(&output));
        }
        for _ in 0..2 {
            job.clear();
            let start = Instant::now();
            let output = job.run().output().unwrap();
            job.takes = job.takes.min(start.elapsed());
            assert!(output.status.success(), "{name}: {}", message(&output));
        }
        job.whole = job.files();
        assert!(!job.whole.is_empty(), "{name} writes nothing");
        job
    }

    fn command<T: AsRef<str>>(&self, arguments: &[T]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nephroid"));
        command
            .current_dir(self.folder.path())
            .args(arguments.iter().map(AsRef::as_ref))
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        command
    }

    fn run(&self) -> Command {
        self.command(&self.arguments)
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn clear(&self) {
        let _ = fs::remove_dir_all(self.out());
        fs::create_dir_all(self.out()).unwrap();
    }

    /// All files below `out` but temporary ones.
    fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut found = BTreeMap::new();
        walk(&self.out(), &mut |path| {
            if !is_temporary(path) {
                found.insert(path.to_owned(), fs::read(path).unwrap());
            }
        });
        found
    }

    /// Kills that many runs, each at a random moment.
    fn kill(&self, kills: u32) -> Toll {
        let mut toll = Toll::default();
        let mut random = 0x9e37_79b9_7f4a_7c15_u64;
        self.clear();
        let mut before: Vec<PathBuf> = Vec::new();
        let mut takes = self.takes;
        while toll.kills < kills {
            // Knuth's multiplier; the high bits are random enough for moments.
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let part = (random >> 40) as f64 / f64::from(1 << 24);
            let mut child = self.run().spawn().unwrap();
            let start = Instant::now();
            let moment = takes.mul_f64(1.1 * part);
            while start.elapsed() < moment && child.try_wait().unwrap().is_none() {
                thread::sleep(Duration::from_micros(500));
            }
            child.kill().unwrap();
            let is_late = child.wait().unwrap().success();
            if is_late {
                // A machine that was busy at first may have told too much.
                takes = takes.min(start.elapsed());
            }
            toll.kills += 1;
            toll.late += u32::from(is_late);
            let case = format!("{}, kill {}", self.name, toll.kills);
            walk(&self.out(), &mut |path| {
                if is_temporary(path) {
                    toll.amid += u32::from(fs::metadata(path).unwrap().len() > 0);
                    fs::remove_file(path).unwrap();
                } else {
                    assert_is_whole(path, &case);
                }
            });
            let after = self.files();
            for path in before {
                assert!(
                    after.contains_key(&path),
                    "{case}: {} is lost",
                    path.display()
                );
            }
            before = after.into_keys().collect();
            if is_late {
                self.assert_same(&case);
                self.clear();
                before.clear();
            }
        }
        // Whoever goes on from what kills left has the whole result.
        let output = self.run().output().unwrap();
        assert!(
            output.status.success(),
            "{}: {}",
            self.name,
            message(&output)
        );
        self.assert_same(self.name);
        toll
    }

    /// Asserts that all files of an undisturbed run are there, and hold the same but for times.
    fn assert_same(&self, case: &str) {
        let found = self.files();
        let names = |files: &BTreeMap<PathBuf, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&found), names(&self.whole), "{case}");
        for (path, bytes) in &self.whole {
            let same = match extension(path) {
                "exr" => {
                    let images =
                        [bytes, &found[path]].map(|bytes| exr::parse(path, bytes).unwrap());
                    is_same(&images[0], &images[1])
                }
                // Reports and records have times.
                "html" | "json" | "md" | "csv" => true,
                _ => *bytes == found[path],
            };
            assert!(same, "{case}: {} is another", path.display());
        }
    }
}

fn is_temporary(path: &Path) -> bool {
    extension(path) == "partial"
}

fn extension(path: &Path) -> &str {
    path.extension().and_then(|it| it.to_str()).unwrap_or("")
}

fn walk(folder: &Path, each: &mut dyn FnMut(&Path)) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            walk(&path, each);
        } else {
            each(&path);
        }
    }
}

fn assert_is_whole(path: &Path, case: &str) {
    let bytes = fs::read(path).unwrap();
    let is_whole = match extension(path) {
        "exr" => exr::parse(path, &bytes).is_ok(),
        "png" => image::load_from_memory(&bytes).is_ok(),
        "json" => serde_json::from_slice::<serde_json::Value>(&bytes).is_ok(),
        "html" => String::from_utf8_lossy(&bytes).contains("</html>"),
        "shard" => Part::read_from(&bytes[..]).is_ok(),
        "table" => {
            bytes.len() > 32 && {
                let (all, hash) = bytes.split_at(bytes.len() - 32);
                blake3::hash(all).as_bytes() == hash
            }
        }
        "csv" | "md" => bytes.ends_with(b"\n"),
        other => panic!("{case}: a file of kind {other}"),
    };
    assert!(is_whole, "{case}: {} is torn", path.display());
}

/// Kills each command that many times.
fn kill_all(kills: u32) {
    let ball = scene("glass-ball.xml").display().to_string();
    let small = ["-D", "size=48", "--photons", "65536"];
    let shards = ["1/2", "2/2"].map(|part| {
        let mut all = vec!["render", &ball];
        all.extend(small);
        all.extend([
            "--shard",
            part,
            "-o",
            if part == "1/2" { "1.shard" } else { "2.shard" },
        ]);
        all
    });
    let tables =
        "tables B -D size=16 --cache out --set frequency=1 --set photons=16384 --set cells=24";
    let render = "render B -D size=48 --photons 65536 -o out/a.exr";
    let shard = "render B -D size=48 --photons 65536 --shard 1/2 -o out/a.shard";
    let merge = "merge B -D size=48 1.shard 2.shard -o out/a.exr";
    let validate = "validate a.toml -o out/r";
    for (name, line) in [
        ("render", render),
        ("render --shard", shard),
        ("merge", merge),
        ("tables", tables),
        ("validate", validate),
    ] {
        let arguments: Vec<&str> = line
            .split(' ')
            .map(|word| if word == "B" { ball.as_str() } else { word })
            .collect();
        let before: Vec<&[&str]> = if name == "merge" {
            shards.iter().map(Vec::as_slice).collect()
        } else {
            Vec::new()
        };
        let job = Job::new(name, &before, &arguments);
        let toll = job.kill(kills);
        println!(
            "{name}, {:.2} s: {} kills, {} of them after the end, {} amid a file; none torn, none lost",
            job.takes.as_secs_f64(),
            toll.kills,
            toll.late,
            toll.amid
        );
    }
}

#[test]
fn kills_at_random_moments_tear_and_lose_nothing() {
    kill_all(12);
}

#[test]
#[ignore = "ten minutes: 1000 kills"]
fn a_thousand_kills_tear_and_lose_nothing() {
    kill_all(200);
}
