//! A run that is stopped at any moment leaves no file, or one that is marked incomplete.

use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};
use std::{fs, thread};

use nephroid::internals::film::{Image, exr};
use tempfile::TempDir;

use super::program::{message, render, render_file, scene, with_a_square_camera};

/// Asserts that a file tells its reader that nothing is known.
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

/// Interrupts a program until it ends: one that was started in the background of a shell ignores what comes
/// before it listens.
pub fn interrupt(child: &mut Child) {
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

/// Runs that last some seconds, interrupted after each of these times \[ms\]: while the program starts,
/// reads, surveys, traces, goes from pass to pass.
pub const MOMENTS: [u64; 8] = [0, 3, 10, 30, 100, 300, 700, 1500];

const ENDLESS: [&[&str]; 5] = [
    &[
        "--method",
        "caustic-map",
        "--set",
        "photons=2048",
        "--set",
        "frames=4096",
    ],
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

pub const PHOTONS: &[&str] = &["--method", "photons", "--photons", "40000000000"];

/// True if there is a picture; if so, it must be whole.
pub fn is_whole_picture(path: &Path) -> bool {
    path.exists() && {
        image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        true
    }
}

/// What a run of a scene leaves that is interrupted after so long \[ms\]: nothing at all, or an image that is
/// whole and marked incomplete, with a picture that is whole.
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

/// Methods run one after the other; whichever is under way, the image has what there is, and says which part
/// it lacks.
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

/// Light volumes of these settings take twenty seconds to a minute: light by area, at points, and by a
/// stencil buffer. Nobody waits for the end of any.
#[test]
fn a_light_volume_is_interrupted_whatever_gathers_its_light() {
    let folder = TempDir::new().unwrap();
    for (sensor, settings) in [
        ("floor", &["accumulate=exact", "levels=6"][..]),
        ("view-50", &["inside=exact"]),
        ("view-50", &["inside=stencil"]),
    ] {
        let mut arguments = vec!["--method=light-volume", "--sensor", sensor];
        arguments.extend(["--set", "lookup=exact"]);
        for setting in settings {
            arguments.extend(["--set", setting]);
        }
        let start = Instant::now();
        let image = interrupted(folder.path(), &scene("pool.xml"), &arguments, 1500);
        let took = start.elapsed();
        println!("{arguments:?}: {:.1} s", took.as_secs_f64());
        // A band of tiles, a part of the water or a band of pixels is ended, and the image written.
        assert!(image.is_some(), "{arguments:?}");
        assert!(took < Duration::from_secs(12), "{arguments:?}: {took:?}");
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

/// A tile of an image with 4e9 samples a pixel takes hours, a texel of direct light with 2^24 some ten
/// seconds, and a row of them minutes: nobody waits for the end of either.
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
