//! Little time, little memory, an end at any moment (docs/accuracy.md, 9).

#![cfg(unix)]

use std::fs;
use std::io::Write;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

#[cfg(target_os = "linux")]
use glam::DVec3;
use nephroid::film::{Image, exr};
#[cfg(target_os = "linux")]
use nephroid::generate::{WATER, height_field, write_ply};
#[cfg(target_os = "linux")]
use nephroid::geometry::MeshParts;
use tempfile::TempDir;

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name)
}

/// `nephroid render` of the glass ball.
fn render(size: usize, output: &Path, arguments: &[&str]) -> Command {
    render_file(&scene("glass-ball.xml"), size, output, arguments)
}

/// `nephroid render` of a scene that has a parameter `size`.
fn render_file(scene: &Path, size: usize, output: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nephroid"));
    command
        .arg("render")
        .arg(scene)
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

/// The most memory \[bytes\] that a program had at once, as the system counts it, and what it printed where it did not fail.
#[cfg(target_os = "linux")]
fn peak_memory(mut child: Child) -> (u64, Vec<u8>) {
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
        if child.try_wait().unwrap().is_some() {
            let output = child.wait_with_output().unwrap();
            assert!(output.status.success(), "{}", message(&output));
            return (peak, output.stdout);
        }
        thread::sleep(Duration::from_millis(2));
    }
}

/// `nephroid inspect` of a scene.
#[cfg(target_os = "linux")]
fn inspect(scene: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nephroid"));
    command
        .arg("inspect")
        .arg(scene)
        .arg("--json")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// What `inspect` says that a sensor's film takes at most \[bytes\].
#[cfg(target_os = "linux")]
fn said(scene: &Path, size: usize, sensor: &str, method: &str) -> u64 {
    let definition = ["-D", &format!("size={size}")];
    let output = inspect(scene).args(definition).output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let sensors = json["sensors"].as_array().unwrap();
    let sensor = sensors.iter().find(|one| one["id"] == sensor).unwrap();
    sensor["film_bytes"][method].as_u64().unwrap()
}

/// The glass ball with a camera that has as many pixels as the floor has texels.
fn with_a_square_camera(folder: &Path) -> PathBuf {
    let text = fs::read_to_string(scene("glass-ball.xml")).unwrap();
    let square = text
        .replace(r#"value="640""#, r#"value="$size""#)
        .replace(r#"value="480""#, r#"value="$size""#);
    assert_ne!(square, text);
    let path = folder.join("square.xml");
    fs::write(&path, square).unwrap();
    path
}

/// Each method, the sensor that it fills, and a run of it that takes little time and much memory: photon maps keep light that is
/// seen directly and by way of glass apart.
#[cfg(target_os = "linux")]
const RUNS: [(&str, &str, &[&str]); 6] = [
    ("photons", "floor", &["--photons", "65536"]),
    ("beams", "floor", &["--error", "10%"]),
    ("caustic-map", "floor", &["--set", "photons=64"]),
    ("path", "camera", &["--spp", "2", "--replicates", "2"]),
    (
        "photon-map",
        "camera",
        &[
            "--seen",
            "anyhow",
            "--photons",
            "65536",
            "--map-photons",
            "4096",
            "--replicates",
            "2",
        ],
    ),
    (
        "full",
        "camera",
        &[
            "--error",
            "50%",
            "--photons",
            "65536",
            "--spp",
            "2",
            "--replicates",
            "2",
        ],
    ),
];

/// What the system and the allocator add \[bytes\]: pages are counted, sizes rounded up, freed memory kept for later.
#[cfg(target_os = "linux")]
const SLACK: u64 = 8_000_000;

/// Program, threads' stacks and buffers take the same for any film: the film is what a larger one takes more than one of 16 x 16.
#[cfg(target_os = "linux")]
fn assert_films_take_no_more_than_said(sizes_and_methods: &[(usize, &[&str])]) {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("a.exr");
    let scene = with_a_square_camera(folder.path());
    for (method, sensor, arguments) in RUNS {
        let run = |size: usize| {
            let mut command = render_file(&scene, size, &output, arguments);
            command.args(["--method", method, "--sensor", sensor]);
            peak_memory(command.spawn().unwrap()).0
        };
        let mut small = None;
        for (size, methods) in sizes_and_methods {
            if !methods.contains(&method) {
                continue;
            }
            let more = run(*size).saturating_sub(*small.get_or_insert_with(|| run(16)));
            let most = said(&scene, *size, sensor, method);
            println!(
                "{method}: {:.1} MB more for {size} x {size} texels; {:.1} MB at most, as inspect says",
                more as f64 / 1e6,
                most as f64 / 1e6
            );
            assert!(more <= most + SLACK, "{method}, {size}");
            // And not so much that a film that fits would be refused.
            assert!(most <= 4 * (more + SLACK), "{method}, {size}");
        }
    }
}

#[cfg(target_os = "linux")]
const ALL: &[&str] = &[
    "photons",
    "beams",
    "caustic-map",
    "path",
    "photon-map",
    "full",
];

#[cfg(target_os = "linux")]
#[test]
fn a_film_takes_no_more_memory_than_inspect_says() {
    // Photon maps take half a minute for the largest.
    let quick = &["photons", "beams", "caustic-map", "path", "full"];
    assert_films_take_no_more_than_said(&[(64, ALL), (256, ALL), (512, quick)]);
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "two minutes, and 4 GB of memory"]
fn a_film_of_1024_x_1024_takes_no_more_memory_than_inspect_says() {
    assert_films_take_no_more_than_said(&[(1024, ALL)]);
}

/// Photons are not kept: tasks, a few for each thread, are all that there is of them.
#[cfg(target_os = "linux")]
fn assert_photons_take_no_memory(powers: &[u32], more: &[&str]) {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("a.exr");
    let mut fewest = None;
    for power in powers {
        let photons = (1_u64 << power).to_string();
        let mut command = render(16, &output, &["--method", "photons", "--photons", &photons]);
        let (peak, _) = peak_memory(command.args(more).spawn().unwrap());
        println!("{:.1} MB for 2^{power} photons {more:?}", peak as f64 / 1e6);
        let few = *fewest.get_or_insert(peak);
        assert!(
            peak <= few + SLACK,
            "{few} bytes, {peak} for 2^{power} photons {more:?}"
        );
    }
}

#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_number_of_photons() {
    assert_photons_take_no_memory(&[12, 16, 22], &[]);
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "half a minute"]
fn memory_does_not_grow_up_to_2_to_24_photons() {
    assert_photons_take_no_memory(&[12, 24], &[]);
}

/// A replicate's tasks, of 4096 photons each, stay until it ends: one replicate alone has the most of them.
#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_photons_of_one_replicate() {
    assert_photons_take_no_memory(&[12, 16, 22], &["--replicates", "1"]);
}

/// A scene of one mesh; what it takes as `inspect` says \[bytes\], and the most that the program had while it read it.
#[cfg(target_os = "linux")]
fn memory_of(folder: &Path, mesh: &MeshParts) -> (u64, u64) {
    let mut bytes = Vec::new();
    write_ply(mesh, "", &mut bytes).unwrap();
    fs::write(folder.join("mesh.ply"), bytes).unwrap();
    let path = folder.join("mesh.xml");
    let text = r#"<scene version="3.0.0"><shape type="ply"><string name="filename" value="mesh.ply"/></shape></scene>"#;
    fs::write(&path, text).unwrap();
    let (peak, printed) = peak_memory(inspect(&path).spawn().unwrap());
    let json: serde_json::Value = serde_json::from_slice(&printed).unwrap();
    (json["memory_bytes"].as_u64().unwrap(), peak)
}

/// Rippled water, whose faces share each vertex with five others: 200 bytes a face. The same faces without a vertex in common: a corner of its
/// own takes a position and a normal of three `f64` each, 48 bytes more.
#[cfg(target_os = "linux")]
#[test]
fn a_triangle_takes_no_more_memory_than_is_promised() {
    let folder = TempDir::new().unwrap();
    let water = |side: u32| height_field(1.0, 0.0, &WATER, side);
    let (_, nothing) = memory_of(folder.path(), &water(2));
    let check = |what: &str, mesh: &MeshParts, promised: f64| {
        let faces = mesh.triangles.len() as f64;
        let (held, peak) = memory_of(folder.path(), mesh);
        let (each, reading) = (held as f64 / faces, peak.saturating_sub(nothing));
        println!(
            "{what} of {faces} faces: {each:.0} bytes a face, as inspect says: {:.2} MB; {:.2} MB while it was read",
            held as f64 / 1e6,
            reading as f64 / 1e6
        );
        assert!(each <= promised, "{what}, {faces} faces: {each}");
        // What is held is in memory, and reading takes less than four times the honest need.
        assert!(
            held <= reading + SLACK,
            "{what}, {faces} faces: {held} of {reading}"
        );
        assert!(
            reading <= 4 * held + SLACK,
            "{what}, {faces} faces: {held} of {reading}"
        );
    };
    for side in [8, 23, 72, 225, 708] {
        check("water", &water(side), 200.0);
    }
    let shared = water(72);
    let own = |of: &[DVec3]| {
        shared
            .triangles
            .iter()
            .flatten()
            .map(|&at| of[at as usize])
            .collect()
    };
    let soup = MeshParts {
        positions: own(&shared.positions),
        normals: shared.normals.as_deref().map(own),
        triangles: (0..shared.triangles.len() as u32)
            .map(|face| [0, 1, 2].map(|corner| 3 * face + corner))
            .collect(),
        ..MeshParts::default()
    };
    check("soup", &soup, 200.0 + 3.0 * 48.0);
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

/// Runs that last some seconds, interrupted after each of these times \[ms\]: while the program starts, reads, discovers, traces, goes
/// from pass to pass.
const MOMENTS: [u64; 8] = [0, 3, 10, 30, 100, 300, 700, 1500];

const ENDLESS: [&[&str]; 4] = [
    &["--method", "beams", "--error", "0.0001%"],
    PHOTONS,
    &["--method", "path", "--sensor", "camera"],
    &[
        "--method",
        "photon-map",
        "--sensor",
        "camera",
        "--photons",
        "40000000000",
    ],
];

const PHOTONS: &[&str] = &["--method", "photons", "--photons", "40000000000"];

/// Whether there is a picture, which is whole then.
fn is_whole_picture(path: &Path) -> bool {
    path.exists() && {
        image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        true
    }
}

/// What a run of a scene leaves that is interrupted after so long \[ms\]: nothing at all, or an image that is whole and marked incomplete, with a
/// picture that is whole.
fn interrupted(folder: &Path, scene: &Path, arguments: &[&str], moment: u64) -> Option<Image> {
    let case = format!("{arguments:?} after {moment} ms");
    let path = folder.join("a.exr");
    let picture = path.with_extension("png");
    let before = fs::read_dir(folder).unwrap().count();
    let start = Instant::now();
    let mut child = render_file(scene, 64, &path, arguments).spawn().unwrap();
    thread::sleep(Duration::from_millis(moment));
    interrupt(&mut child);
    let output = child.wait_with_output().unwrap();
    // A pass or a round is left in its middle: seconds at most, on a machine however busy.
    assert!(
        start.elapsed() < Duration::from_millis(moment) + Duration::from_secs(60),
        "{case}"
    );
    assert_eq!(is_whole_picture(&picture), path.exists(), "{case}");
    let image = path.exists().then(|| {
        assert_eq!(
            output.status.code(),
            Some(1),
            "{case}: {}",
            message(&output)
        );
        let image = exr::read(&path).unwrap();
        assert_eq!(image.metadata("complete"), Some("no"), "{case}");
        fs::remove_file(&path).unwrap();
        fs::remove_file(&picture).unwrap();
        image
    });
    assert_eq!(fs::read_dir(folder).unwrap().count(), before, "{case}");
    image
}

#[test]
fn an_interrupt_at_any_moment_leaves_no_file_or_one_that_is_marked() {
    let folder = TempDir::new().unwrap();
    for arguments in ENDLESS {
        let mut left = MOMENTS.to_vec();
        if arguments.contains(&"photon-map") {
            // Its photons fly as those of the others do.
            left.retain(|moment| [30, 300, 1500].contains(moment));
        }
        left.retain(|&moment| {
            interrupted(folder.path(), &scene("glass-ball.xml"), arguments, moment).is_some()
        });
        println!("{arguments:?}: files after {left:?} ms");
        assert!(left.contains(&1500), "{arguments:?}: {left:?}");
    }
}

/// Methods run one after the other; whichever is under way, the image has what there is, and says which part it lacks.
#[test]
fn all_methods_are_interrupted_in_each_of_their_parts() {
    let folder = TempDir::new().unwrap();
    let scene = with_a_square_camera(folder.path());
    let quick = ["--photons", "65536", "--map-photons", "2048"];
    for (part, limits) in [
        ("beams", ["--error", "0.0001%"]),
        ("photon-map", ["--photons", "40000000000"]),
        // A tile is never left in its middle: no more samples than it does in a second.
        ("path", ["--spp", "65536"]),
    ] {
        let mut arguments = vec!["--method", "full", "--sensor", "camera"];
        arguments.extend(limits);
        if part == "path" {
            arguments.extend(quick);
        }
        // Until it has come so far: a busy machine takes longer.
        let reached = [200, 800, 3200, 12_800, 51_200]
            .into_iter()
            .find(|&moment| {
                interrupted(folder.path(), &scene, &arguments, moment).is_some_and(|image| {
                    let full: serde_json::Value =
                        serde_json::from_str(image.metadata("full").unwrap()).unwrap();
                    let parts = full["parts"].as_array().unwrap();
                    let first = parts
                        .iter()
                        .find(|part| part["incomplete"] == true)
                        .unwrap();
                    println!(
                        "full, {limits:?}, after {moment} ms: interrupted in {}",
                        first["method"]
                    );
                    first["method"] == part
                })
            });
        assert!(reached.is_some(), "{part} is not reached");
    }
}

/// A lamp with a surface over a glass ball: the ball's shadow is sampled texel by texel.
const SHADOW: &str = r#"<scene version="3.0.0">
  <default name="size" value="1"/>
  <shape type="rectangle">
    <transform name="to_world"><scale x="0.5" y="0.5"/><rotate x="1" angle="180"/><translate z="2"/></transform>
    <emitter type="area"><rgb name="radiance" value="1, 1, 1"/></emitter>
  </shape>
  <shape type="sphere">
    <point name="center" x="0" y="0" z="0.6"/><float name="radius" value="0.5"/>
    <bsdf type="dielectric"/>
  </shape>
  <shape type="rectangle">
    <bsdf type="diffuse"/>
    <sensor type="irradiancemeter">
      <film type="hdrfilm">
        <integer name="width" value="$size"/><integer name="height" value="$size"/>
        <rfilter type="box"/>
      </film>
    </sensor>
  </shape>
</scene>"#;

/// A tile of an image with 4e9 samples a pixel takes hours, a texel of direct light with 2^24 some ten seconds, and a row of them minutes:
/// nobody waits for the end of either.
#[test]
fn an_interrupt_is_heard_amid_the_samples_of_one_pixel_or_texel() {
    let folder = TempDir::new().unwrap();
    let shadow = folder.path().join("shadow.xml");
    fs::write(&shadow, SHADOW).unwrap();
    let camera = with_a_square_camera(folder.path());
    for (scene, arguments) in [
        (
            camera,
            ["--sensor=camera", "--method=path", "--spp=4000000000"],
        ),
        (
            shadow,
            [
                "--method=photons",
                "--photons=65536",
                "--direct-samples=16777216",
            ],
        ),
    ] {
        let image = interrupted(folder.path(), &scene, &arguments, 1500);
        assert!(
            image.is_some(),
            "{arguments:?}: the first interrupt was not heard"
        );
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

/// What a run left that was ended.
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
    /// Of a film of so many pixels each way.
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

    /// Checks that both files are whole, and puts back what was there. Returns what the EXR was, and the size of a temporary that was left.
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

/// Whether two images are the same, but for how long they took.
fn is_same(a: &Image, b: &Image) -> bool {
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

/// The second Ctrl-C ends the program at once, with exit code 130: here while it writes what it has since the first.
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
    // Until one was in the middle of writing, which is a matter of milliseconds: eight will do, on a busy machine not always.
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
            Some(1) => assert_ne!(left, Left::Old, "{case}"),
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
