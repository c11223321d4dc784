//! A result that replaces another: whenever the run is stopped, the old one or a whole one is there.

use std::io::Write;
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

use nephroid::internals::film::{Image, exr};
use tempfile::TempDir;

use super::program::{message, render, render_file};
use super::stops::{MOMENTS, PHOTONS, is_whole_picture};

/// No time to write anything: what was there before is there still, whole.
#[test]
fn a_kill_at_any_moment_leaves_the_old_result() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.exr");
    let first = render(16, &path, &["--photons", "4096"]).output().unwrap();
    assert!(first.status.success(), "{}", message(&first));
    let before = fs::read(&path).unwrap();
    for moment in MOMENTS {
        let mut child = render(64, &path, PHOTONS).spawn().unwrap();
        thread::sleep(Duration::from_millis(moment));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(fs::read(&path).unwrap() == before, "after {moment} ms");
    }
}

/// Noise all over a film, which no compression makes small: files of megabytes after a fraction of a second.
const NOISE: &str = r#"<scene version="3.0.0">
  <default name="size" value="1"/>
  <shape type="rectangle">
    <transform name="to_world"><scale x="0.5" y="0.5"/><rotate x="1" angle="180"/><translate z="2"/></transform>
    <emitter type="area"><rgb name="radiance" value="1, 2, 3"/></emitter>
  </shape>
  <shape type="rectangle"><bsdf type="diffuse"/></shape>
  <sensor type="perspective">
    <float name="fov" value="30"/>
    <transform name="to_world"><lookat origin="0, 0, 1.5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm">
      <integer name="width" value="$size"/><integer name="height" value="$size"/>
      <rfilter type="box"/>
    </film>
  </sensor>
</scene>"#;

/// When to end a run that is about to replace files.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// At this part of the time that it takes.
    Part(f64),
    /// So long \[ms\] after the temporary of the EXR is seen to grow.
    Writing(u64),
    /// So long \[ms\] after the EXR is seen to be another.
    Written(u64),
}

/// A result, and a run that replaces it by another.
struct Replacement {
    folder: TempDir,
    size: usize,
    old: [Vec<u8>; 2],
    new_image: Image,
    new_picture: Vec<u8>,
    takes: Duration,
}

/// State of a result after its run was ended.
#[derive(Debug, PartialEq)]
enum Left {
    /// The old EXR.
    Old,
    /// All that the run would have written there.
    New,
    /// A file that is whole, marked incomplete.
    Part,
}

impl Replacement {
    /// A replacement of a film of so many pixels each way.
    fn new(size: usize) -> Self {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("noise.xml"), NOISE).unwrap();
        let mut replacement = Self {
            folder,
            size,
            old: [Vec::new(), Vec::new()],
            new_image: Image::new(0, 0),
            new_picture: Vec::new(),
            takes: Duration::ZERO,
        };
        // The faster of two: on a busy machine one may have had to wait.
        replacement.takes = Duration::MAX;
        for _ in 0..2 {
            let start = Instant::now();
            let run = replacement.run(size).output().unwrap();
            replacement.takes = replacement.takes.min(start.elapsed());
            assert!(run.status.success(), "{}", message(&run));
        }
        let [exr, png] = replacement.paths();
        replacement.new_image = exr::read(&exr).unwrap();
        replacement.new_picture = fs::read(&png).unwrap();
        let run = replacement.run(16).output().unwrap();
        assert!(run.status.success(), "{}", message(&run));
        replacement.old = [exr, png].map(|path| fs::read(path).unwrap());
        replacement
    }

    fn run(&self, size: usize) -> Command {
        let arguments = [
            "--method",
            "path",
            "--spp",
            "2",
            "--replicates",
            "2",
            "--max-depth",
            "2",
        ];
        let scene = self.folder.path().join("noise.xml");
        render_file(&scene, size, &self.paths()[0], &arguments)
    }

    fn paths(&self) -> [PathBuf; 2] {
        ["a.exr", "a.png"].map(|name| self.folder.path().join(name))
    }

    /// Names and sizes of what else there is.
    fn others(&self) -> Vec<(String, u64)> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        entries
            .filter_map(|entry| {
                let entry = entry.unwrap();
                let name = entry.file_name().into_string().unwrap();
                let is_known = ["noise.xml", "a.exr", "a.png"].contains(&&*name);
                // It may be gone since.
                (!is_known).then(|| Some((name, entry.metadata().ok()?.len())))?
            })
            .collect()
    }

    /// Starts a run that replaces the result.
    fn start(&self) -> Running<'_> {
        Running {
            replacement: self,
            old: fs::metadata(&self.paths()[0]).unwrap().ino(),
            start: Instant::now(),
            child: self.run(self.size).spawn().unwrap(),
        }
    }

    /// Checks that both files are whole, and puts back what was there. Returns what the EXR was, and the size
    /// of a temporary that was left.
    fn checked(&self, case: &str) -> (Left, Option<u64>) {
        let [exr, png] = self.paths();
        let left = if fs::read(&exr).unwrap() == self.old[0] {
            Left::Old
        } else {
            let image = exr::read(&exr).unwrap_or_else(|error| panic!("{case}: {error}"));
            if image.metadata("complete") == Some("no") {
                Left::Part
            } else {
                assert!(is_same(&image, &self.new_image), "{case}: a third result");
                Left::New
            }
        };
        assert!(is_whole_picture(&png), "{case}");
        let picture = fs::read(&png).unwrap();
        // It is drawn after the EXR is written.
        let may_be_new = match left {
            Left::Old => false,
            Left::New => picture == self.new_picture,
            Left::Part => true,
        };
        assert!(
            picture == self.old[1] || may_be_new,
            "{case}: {left:?} with a picture of something else"
        );
        // What the program could not take away is hidden, and has another ending than a result.
        let others = self.others();
        assert!(others.len() <= 1, "{case}: {others:?}");
        for (name, _) in &others {
            assert!(
                (name.starts_with(".a.exr") || name.starts_with(".a.png"))
                    && name.ends_with(".partial"),
                "{case}: {name}"
            );
            fs::remove_file(self.folder.path().join(name)).unwrap();
        }
        for (path, bytes) in [exr, png].iter().zip(&self.old) {
            fs::write(path, bytes).unwrap();
        }
        (left, others.first().map(|(_, size)| *size))
    }
}

/// A run that is replacing the result.
struct Running<'a> {
    replacement: &'a Replacement,
    /// The old EXR's number in the file system.
    old: u64,
    start: Instant,
    child: Child,
}

impl Running<'_> {
    /// Waits for this moment, or for the run's end.
    fn wait(&mut self, moment: Moment) {
        let [exr, _] = self.replacement.paths();
        let has_come = |start: Instant| match moment {
            Moment::Part(part) => start.elapsed() >= self.replacement.takes.mul_f64(part),
            Moment::Writing(_) => {
                let grows = |(name, size): &(String, u64)| name.starts_with(".a.exr") && *size > 0;
                self.replacement.others().iter().any(grows)
            }
            Moment::Written(_) => fs::metadata(&exr).unwrap().ino() != self.old,
        };
        while !has_come(self.start) && self.child.try_wait().unwrap().is_none() {
            thread::sleep(Duration::from_micros(50));
        }
        if let Moment::Writing(delay) | Moment::Written(delay) = moment {
            thread::sleep(Duration::from_millis(delay));
        }
    }
}

/// True if two images are the same, but for the time that they took.
pub fn is_same(a: &Image, b: &Image) -> bool {
    let untimed = |image: &Image| -> Vec<(String, String)> {
        let metadata = image.metadata.iter().filter(|(key, _)| key != "timing");
        metadata.cloned().collect()
    };
    a.channels.len() == b.channels.len()
        && untimed(a) == untimed(b)
        && a.channels.iter().zip(&b.channels).all(|(a, b)| {
            let bits = |samples: &[f32]| samples.iter().map(|it| it.to_bits()).collect::<Vec<_>>();
            a.name == b.name && bits(&a.samples) == bits(&b.samples)
        })
}

/// The end of a run is where files change: kills from half of its time on, while it writes and after.
#[test]
fn a_kill_while_a_result_is_replaced_leaves_the_old_or_the_new_one() {
    let replacement = Replacement::new(320);
    let parts = (0..12).map(|i| Moment::Part(0.5 + 0.6 * f64::from(i) / 11.0));
    let writing = [0, 0, 0, 0, 1, 1, 2, 3, 5, 8].map(Moment::Writing);
    let written = [0, 0, 1, 3, 10, 30].map(Moment::Written);
    let (mut old, mut new, mut torn) = (0, 0, Vec::new());
    for moment in parts.chain(writing).chain(written) {
        let case = format!("killed at {moment:?}");
        let mut run = replacement.start();
        run.wait(moment);
        run.child.kill().unwrap();
        run.child.wait().unwrap();
        let (left, temporary) = replacement.checked(&case);
        match left {
            Left::Old => old += 1,
            Left::New => new += 1,
            Left::Part => panic!("{case}: nobody asked it to stop"),
        }
        torn.extend(temporary);
    }
    println!(
        "28 kills of a run of {:.2} s: {old} left the old result, {new} the new one; temporaries of {torn:?} bytes",
        replacement.takes.as_secs_f64()
    );
    // Some came before and some after; and some in between, or there would be no temporary left.
    assert!(old >= 4 && new >= 4, "{old} old, {new} new");
    assert!(torn.iter().any(|size| *size > 0), "{torn:?}");
}

/// Whoever interrupts a run while it writes its whole result comes too late, and the program says so: the
/// exit code is that of the file's mark.
#[test]
fn an_interrupt_while_a_result_is_written_ends_as_the_file_says() {
    let replacement = Replacement::new(512);
    let mut shell = Command::new("sh").stdin(Stdio::piped()).spawn().unwrap();
    let mut orders = shell.stdin.take().unwrap();
    let mut amid = 0;
    for attempt in 0..16 {
        let mut run = replacement.start();
        run.wait(Moment::Writing(attempt % 4));
        if run.child.try_wait().unwrap().is_none() {
            writeln!(orders, "kill -INT {}", run.child.id()).unwrap();
        }
        let output = run.child.wait_with_output().unwrap();
        let said = message(&output);
        let case = format!("interrupt {attempt} while it wrote: {said}");
        amid += u32::from(said.contains("stopping"));
        let (left, temporary) = replacement.checked(&case);
        assert_eq!(output.status.code(), Some(0), "{case}");
        assert_eq!((left, temporary), (Left::New, None), "{case}");
    }
    println!("{amid} of 16 interrupts came before the end");
    assert!(amid >= 4, "{amid}");
    drop(orders);
    shell.wait().unwrap();
}

/// The second Ctrl-C ends the program at once, with exit code 130: here while it writes what it has since the
/// first.
#[test]
fn two_interrupts_while_a_result_is_replaced_leave_the_old_or_a_whole_one() {
    let replacement = Replacement::new(512);
    // A shell that is there already sends a signal in no time; a new one would be late.
    let mut shell = Command::new("sh").stdin(Stdio::piped()).spawn().unwrap();
    let mut orders = shell.stdin.take().unwrap();
    let mut interrupt = |run: &mut Running| {
        if run.child.try_wait().unwrap().is_none() {
            writeln!(orders, "kill -INT {}", run.child.id()).unwrap();
        }
    };
    let mut ends = Vec::new();
    let mut torn = 0;
    // Until one was in the middle of writing, which is a matter of milliseconds: eight will do, on a busy
    // machine not always.
    for attempt in 0..64 {
        if ends.len() >= 8 && torn >= 1 {
            break;
        }
        let part = 0.3 + 0.1 * f64::from(attempt % 8);
        let mut run = replacement.start();
        run.wait(Moment::Part(part));
        interrupt(&mut run);
        run.wait(Moment::Writing(0));
        interrupt(&mut run);
        let output = run.child.wait_with_output().unwrap();
        let case = format!("interrupted at {part:.1} of its time and while it wrote");
        let (left, temporary) = replacement.checked(&case);
        match output.status.code() {
            // The second came too late, or both.
            Some(0) => assert_eq!(left, Left::New, "{case}"),
            Some(1) => assert_eq!(left, Left::Part, "{case}"),
            Some(130) => torn += u32::from(temporary.is_some_and(|size| size > 0)),
            _ => panic!("{case}: {:?}, {}", output.status, message(&output)),
        }
        ends.push((
            output.status.code().unwrap_or(0),
            left,
            temporary.unwrap_or(0),
        ));
    }
    println!("exit codes, what was left, bytes of temporaries: {ends:?}");
    drop(orders);
    shell.wait().unwrap();
    assert!(torn >= 1, "{ends:?}");
}
