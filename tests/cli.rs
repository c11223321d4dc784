//! The program as a user meets it: exit codes, messages, files.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use nephroid::film::exr;

fn nephroid(arguments: &[&str]) -> Output {
    Command::cargo_bin("nephroid")
        .unwrap()
        .args(arguments)
        .output()
        .unwrap()
}

fn scene(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name)
        .display()
        .to_string()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: &str) -> String {
        let path = self.path(name);
        std::fs::write(&path, content).unwrap();
        path.display().to_string()
    }
}

#[test]
fn a_render_says_what_it_measured_and_writes_both_files() {
    let folder = Folder::new();
    let exr_path = folder.path("a.exr");
    let output = nephroid(&[
        "render",
        &scene("glass-ball.xml"),
        "--photons",
        "50000",
        "-D",
        "size=32",
        "-o",
        exr_path.to_str().unwrap(),
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let summary = text(&output.stdout);
    for expected in [
        "irradiance [W/m²]",
        "LTTD",
        "received",
        "ledger closes",
        "rays",
    ] {
        assert!(summary.contains(expected), "{expected} in {summary}");
    }
    // Without a terminal there is no progress line.
    assert_eq!(text(&output.stderr), "");
    let image = exr::read(&exr_path).unwrap();
    assert_eq!((image.width, image.height), (32, 32));
    for channel in [
        "E.R",
        "E.stderr.G",
        "LD.B",
        "LTTD.R",
        "LTTD.stderr.R",
        "count.Y",
    ] {
        assert!(image.channel(channel).is_some(), "{channel}");
    }
    for key in [
        "scene-hash",
        "settings",
        "seed",
        "version",
        "photons",
        "summary",
        "timing",
        "conventions",
        "warnings",
        "complete",
        "method",
        "sensor",
    ] {
        assert!(image.metadata(key).is_some(), "{key}");
    }
    assert!(exr_path.with_extension("png").is_file());
}

#[test]
fn layers_sum_to_the_total() {
    let folder = Folder::new();
    let path = folder.path("sum.exr");
    let output = nephroid(&[
        "render",
        &scene("cornell-glass.xml"),
        "--photons",
        "40000",
        "-D",
        "size=24",
        "-o",
        path.to_str().unwrap(),
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let image = exr::read(&path).unwrap();
    let total = image.channel("E.G").unwrap();
    for (texel, expected) in total.samples.iter().enumerate() {
        let sum: f32 = image
            .channels
            .iter()
            .filter(|channel| {
                channel.name.ends_with(".G")
                    && !channel.name.contains("stderr")
                    && !channel.name.starts_with("E.")
            })
            .map(|channel| channel.samples[texel])
            .sum();
        // Ten f32 values, each rounded once, summed in f32.
        assert!(
            (sum - expected).abs() <= 20.0 * f32::EPSILON * expected,
            "texel {texel}"
        );
    }
}

#[test]
fn json_is_json() {
    let folder = Folder::new();
    let path = folder.path("a.exr");
    let output = nephroid(&[
        "render",
        &scene("glass-ball.xml"),
        "--photons",
        "2000",
        "-D",
        "size=16",
        "--json",
        "-o",
        path.to_str().unwrap(),
    ]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["complete"], true);
    assert!(summary["ledger"]["closure_error"].as_f64().unwrap() < 1e-12);
    assert_eq!(summary["layers"][0]["name"], "E");
    let output = nephroid(&["inspect", &scene("glass-ball.xml"), "--json"]);
    let inspection: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(inspection["emitters"][0]["plugin"], "point");
}

#[test]
fn inspect_says_what_a_scene_requires_and_why() {
    let output = nephroid(&["inspect", &scene("cornell-glass.xml")]);
    let report = text(&output.stdout);
    assert!(output.status.success());
    assert!(report.contains("yes  area lights"), "{report}");
    assert!(report.contains("ignored"), "{report}");
    let output = nephroid(&["inspect", &scene("water.xml")]);
    let report = text(&output.stdout);
    assert!(report.contains("476 open edges"), "{report}");
}

#[test]
fn light_by_way_of_rough_glass_is_left_out_with_a_warning_and_a_varying_mask_is_refused() {
    let folder = Folder::new();
    let scene = |floor: &str| {
        format!(
            "<scene version=\"3.0.0\"><emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"5\"/></emitter>\
             <shape type=\"sphere\" id=\"frosted\"><point name=\"center\" x=\"0\" y=\"0\" z=\"2\"/><bsdf type=\"roughdielectric\"/></shape>\
             <shape type=\"sphere\"><point name=\"center\" x=\"3\" y=\"0\" z=\"2\"/><bsdf type=\"dielectric\"/></shape>\
             <shape type=\"rectangle\" id=\"floor\">{floor}<sensor type=\"irradiancemeter\"><film type=\"hdrfilm\">\
             <integer name=\"width\" value=\"4\"/><integer name=\"height\" value=\"4\"/></film></sensor></shape></scene>"
        )
    };
    let exr = folder.path("a.exr").display().to_string();
    let rough = folder.write("rough.xml", &scene("<bsdf type=\"roughplastic\"/>"));
    for method in ["photons", "beams"] {
        let output = nephroid(&[
            "render", &rough, "--method", method, "--error", "30%", "-o", &exr,
        ]);
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert!(
            said.contains("light by way of frosted (roughdielectric) is left out"),
            "{said}"
        );
    }
    let mask = "<bsdf type=\"mask\"><texture type=\"checkerboard\" name=\"opacity\"/><bsdf type=\"diffuse\"/></bsdf>";
    let masked = folder.write("masked.xml", &scene(mask));
    let output = nephroid(&["render", &masked, "--photons", "100", "-o", &exr]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(
        said.contains("shape \"floor\" has a mask whose opacity is a texture"),
        "{said}"
    );
}

#[test]
fn what_is_wrong_is_said_with_its_place_and_exits_with_2() {
    let folder = Folder::new();
    let rough = folder.write(
        "rough.xml",
        "<scene version=\"3.0.0\">\n  <shape type=\"sphere\">\n    <bsdf type=\"principled\"/>\n  </shape>\n</scene>\n",
    );
    let broken = folder.write(
        "broken.xml",
        "<scene version=\"3.0.0\">\n  <shape\n</scene>",
    );
    let no_meter = folder.write("empty.xml", "<scene version=\"3.0.0\"></scene>");
    let missing = folder.path("missing.xml").display().to_string();
    let glass_ball = scene("glass-ball.xml");
    let cases: Vec<(Vec<&str>, Vec<&str>)> = vec![
        (
            vec!["render", &rough],
            vec!["rough.xml:3:5", "principled", "dielectric"],
        ),
        (vec!["render", &broken], vec!["broken.xml:"]),
        (vec!["render", &missing], vec!["missing.xml"]),
        (vec!["render", &no_meter], vec!["irradiancemeter", "none"]),
        (
            vec!["render", &glass_ball, "--sensor", "door"],
            vec!["\"door\"", "\"floor\"", "\"camera\""],
        ),
        (
            vec![
                "render",
                &glass_ball,
                "--sensor",
                "camera",
                "--photons",
                "1",
            ],
            vec!["perspective", "irradiancemeter"],
        ),
        (vec!["render", &glass_ball, "-o", "x.png"], vec![".exr"]),
        (
            vec![
                "render",
                &glass_ball,
                "--photons",
                "1",
                "-D",
                "size=8",
                "-o",
                "/no/such/folder/a.exr",
            ],
            vec!["/no/such/folder"],
        ),
        (vec!["render", &glass_ball, "--error=-1%"], vec!["--error"]),
        (vec!["render", &glass_ball, "--shard", "4/3"], vec!["1/3"]),
        (
            vec!["render", &glass_ball, "-D", "colour=red"],
            vec!["colour"],
        ),
        (vec!["render"], vec!["SCENE"]),
        (vec!["generate", "teapot"], vec!["teapot", "glass-ball"]),
    ];
    for (arguments, expected) in cases {
        let output = nephroid(&arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        for part in expected {
            assert!(
                message.contains(part),
                "{arguments:?}: {part} is not in {message}"
            );
        }
    }
}

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
        "camera",
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
fn what_cannot_be_done_is_refused_before_the_run() {
    let folder = Folder::new();
    let path = folder.path("x.exr");
    let missing = folder.path("missing").join("x.exr");
    let glass_ball = scene("glass-ball.xml");
    let exr = path.to_str().unwrap();
    for (arguments, expected) in [
        (
            vec!["-D", "size=100000000", "-o", exr],
            "1 to 1048576 each way",
        ),
        (vec!["--photons", "0", "-o", exr], "--photons"),
        (
            vec!["--photons", "18446744073709551615", "-o", exr],
            "--photons",
        ),
        (
            vec!["--error", "1%", "--replicates", "1", "-o", exr],
            "at least 2 replicates",
        ),
        (vec!["-o", missing.to_str().unwrap()], "does not exist"),
    ] {
        let arguments: Vec<&str> = ["render", &glass_ball]
            .into_iter()
            .chain(arguments)
            .collect();
        let output = nephroid(&arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(expected), "{arguments:?}: {message}");
        assert!(!path.exists());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_film_larger_than_the_memory_is_refused_with_what_it_takes() {
    let folder = Folder::new();
    let path = folder.path("huge.exr");
    // 2⁴⁰ texels of at least 400 bytes: no machine has that.
    let output = nephroid(&[
        "render",
        &scene("glass-ball.xml"),
        "-D",
        "size=1048576",
        "-o",
        path.to_str().unwrap(),
    ]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("GB of memory"), "{message}");
    assert!(!path.exists());
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
