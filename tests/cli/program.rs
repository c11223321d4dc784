//! The program as a user meets it: exit codes, messages, files.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use nephroid::film::exr;

use crate::support;

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
fn a_caustic_behind_a_pane_is_written_with_its_bias() {
    let folder = Folder::new();
    let path = folder.path("pane.exr");
    let pane = scene("glass-ball-behind-pane.xml");
    let render = |more: &[&str]| {
        let common = ["render", &pane, "--sensor", "camera", "-o"];
        nephroid(&[&common[..], &[path.to_str().unwrap()], more].concat())
    };
    let output = render(&[
        "--method",
        "photon-map",
        "--photons",
        "20000",
        "--map-photons",
        "5000",
        "--replicates",
        "2",
        "--radius",
        "3",
        "--json",
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["method"], "photon-map");
    assert_eq!(summary["quantity"], "radiance");
    assert_eq!(summary["photons"], 20_000);
    assert_eq!(summary["photon_map"]["passes"], 2);
    assert_eq!(summary["photon_map"]["radius"][0], 3.0);
    assert!(summary["photon_map"]["relative_bias"].as_f64().unwrap() >= 0.0);
    let image = exr::read(&path).unwrap();
    for channel in [
        "L",
        "L.stderr",
        "L.lo",
        "L.hi",
        "LTTDSE",
        "bias",
        "bias.stderr",
    ] {
        assert!(
            image.channel(&format!("{channel}.G")).is_some(),
            "{channel}"
        );
    }
    assert!(image.channel("LTTD.G").is_none());
    // Photons cannot be connected through the pane; and what is for maps is for nothing else.
    for (more, expected) in [
        (&["--method", "photons", "--radius", "2"][..], "--radius"),
        (&["--method", "beams", "--seen", "anyhow"], "--seen"),
        (&["--method", "photon-map", "--radius=-1"], "radius"),
    ] {
        let output = render(more);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {message}");
        assert!(message.contains(expected), "{more:?}: {message}");
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

/// Texels of which nothing is known are NaN in the file, null in JSON, "unknown" in the table and magenta in the
/// picture, whichever method was to measure them; and nothing is called known.
#[test]
fn what_is_not_known_is_not_shown_as_zero() {
    let folder = Folder::new();
    let path = folder.path("unknown.exr");
    for method in ["beams", "photons"] {
        let run = |more: &[&str]| {
            let glass_ball = scene("glass-ball.xml");
            let common = ["render", &glass_ball, "-D", "size=16", "--time", "0s"];
            let output = ["-o", path.to_str().unwrap(), "--method", method];
            let output = nephroid(&[&common[..], &output, more].concat());
            assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
            text(&output.stdout)
        };
        let table = run(&[]);
        for layer in ["E", "LD"] {
            let line = table
                .lines()
                .find(|line| line.split_whitespace().next() == Some(layer));
            let words = line.unwrap().split_whitespace();
            let unknown = words.filter(|word| *word == "unknown").count();
            assert_eq!(unknown, 4, "{layer} in {table}");
        }
        assert!(table.contains("before direct light (LD) was measured"));
        assert!(!table.contains("only direct light"), "{table}");
        assert!(!table.contains("set out"), "no flux was traced: {table}");
        let summary: serde_json::Value = serde_json::from_str(&run(&["--json"])).unwrap();
        for layer in 0..2 {
            let layer = &summary["layers"][layer];
            assert!(layer["mean"].is_null() && layer["max"].is_null(), "{layer}");
        }
        assert!(summary["ledger"].is_null());
        let image = exr::read(&path).unwrap();
        assert!(image.channel("E.R").is_some() && image.channel("LD.R").is_some());
        assert_eq!(image.channel("E.stderr.R").is_some(), method == "photons");
        assert_eq!(image.channel("E.lo.R").is_some(), method == "beams");
        for channel in &image.channels {
            // Photons do count: no photon was there.
            let is_known = channel.samples.iter().any(|sample| !sample.is_nan());
            assert!(!is_known || channel.name == "count.Y", "{}", channel.name);
        }
        let picture = image::open(path.with_extension("png")).unwrap().to_rgb8();
        let magenta = picture.pixels().filter(|pixel| pixel.0 == [255, 0, 255]);
        // 16 texels a side are enlarged to 256 pixels at least.
        assert!(magenta.count() >= 256 * 256, "{method}");
    }
}

/// The run is deterministic, so that the file's numbers are those of this process, rounded.
#[test]
fn bounds_in_the_file_are_bounds_of_the_numbers_they_were_rounded_from() {
    let folder = Folder::new();
    let path = folder.path("bounds.exr");
    let output = nephroid(&[
        "render",
        &scene("glass-ball.xml"),
        "-D",
        "size=48",
        "--error",
        "1%",
        "--layers",
        "256",
        "-o",
        path.to_str().unwrap(),
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let image = exr::read(&path).unwrap();
    let scene = support::bundled("glass-ball", 48);
    let (estimate, _) = support::beams::beams_to(16, &scene, 0.01);
    let layers = || std::iter::once(&estimate.total).chain(&estimate.layers);
    let mut rounded = 0;
    for layer in layers() {
        let samples = |end: &str| {
            let name = format!("{}{end}.G", layer.name);
            image.channel(&name).unwrap().samples.clone()
        };
        let (value, low, high) = (samples(""), samples(".lo"), samples(".hi"));
        let bounds = layer.interval.as_ref().unwrap();
        for texel in 0..48 * 48 {
            let [exact_low, exact_high] =
                [&bounds.low, &bounds.high].map(|bound| bound[texel].0[1]);
            assert_eq!(value[texel], layer.irradiance[texel].0[1] as f32);
            assert!(f64::from(low[texel]) <= exact_low, "{} {texel}", layer.name);
            assert!(
                f64::from(high[texel]) >= exact_high,
                "{} {texel}",
                layer.name
            );
            assert!(low[texel] <= value[texel] && value[texel] <= high[texel]);
            // Half of all would be inside if they were rounded to the nearest.
            rounded += u32::from(f64::from(exact_low as f32) > exact_low);
            rounded += u32::from(f64::from(exact_high as f32) < exact_high);
        }
    }
    assert!(rounded > 1000, "{rounded}");
}

#[test]
fn a_summary_of_beams_says_what_is_known_by_difference_and_claims_no_closure() {
    let folder = Folder::new();
    let path = folder.path("cup.exr");
    let arguments = |more: &'static str| {
        vec![
            "render".to_owned(),
            scene("coffee-cup.xml"),
            "-D".to_owned(),
            "size=32".to_owned(),
            "--error".to_owned(),
            "5%".to_owned(),
            "-o".to_owned(),
            path.display().to_string(),
            more.to_owned(),
        ]
    };
    let run = |more: &'static str| {
        let arguments = arguments(more);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        text(&nephroid(&arguments).stdout)
    };
    let table = run("--layers=8");
    for expected in [
        "elsewhere (by difference)",
        "largest balance error",
        "set out",
    ] {
        assert!(table.contains(expected), "{expected} in {table}");
    }
    // The cup is of metal: what it absorbs has not escaped.
    for claim in ["closes", "escaped", "absorbed"] {
        assert!(!table.contains(claim), "{claim} in {table}");
    }
    let summary: serde_json::Value = serde_json::from_str(&run("--json")).unwrap();
    let ledger = &summary["ledger"];
    assert!(ledger["closure_error"].is_null());
    let mean = |value: &serde_json::Value| {
        let channels = value.as_array().unwrap().iter();
        channels
            .map(|channel| channel.as_f64().unwrap())
            .sum::<f64>()
            / 3.0
    };
    let rows = ledger["rows"].as_array().unwrap();
    let received: f64 = rows.iter().map(|row| mean(&row[1]["received"])).sum();
    let rest = mean(&ledger["emitted"]) - received;
    let elsewhere = ledger["elsewhere"].as_f64().unwrap();
    // A dozen additions of numbers no larger than what set out.
    assert!((elsewhere - rest).abs() <= 16.0 * f64::EPSILON * mean(&ledger["emitted"]));
    for row in rows {
        assert!(row[1]["escaped"].is_null(), "{row}");
    }
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_run_with_its_cause_once() {
    let folder = Folder::new();
    let glass_ball = scene("glass-ball.xml");
    std::fs::create_dir(folder.path("folder.exr")).unwrap();
    std::fs::create_dir(folder.path("taken.png")).unwrap();
    let mut outputs = vec![folder.path("folder.exr"), folder.path("taken.exr")];
    if cfg!(target_os = "linux") {
        outputs.push(PathBuf::from("/proc/a.exr"));
    }
    for output in outputs {
        // A year's photons: the test would not end if the run began.
        let arguments = ["render", &glass_ball, "--photons", "281474976710656", "-o"];
        let output = output.to_str().unwrap();
        let done = nephroid(&[&arguments[..], &[output]].concat());
        let message = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{message}");
        assert!(message.contains("cannot write"), "{message}");
        let parts: Vec<&str> = message.trim().split(": ").collect();
        for part in &parts {
            let times = parts.iter().filter(|other| *other == part).count();
            assert_eq!(times, 1, "{message}");
        }
    }
    assert_eq!(std::fs::read_dir(folder.0.path()).unwrap().count(), 2);
}

#[test]
fn an_option_that_changes_the_method_or_has_no_effect_is_noticed() {
    let folder = Folder::new();
    let path = folder.path("seed.exr");
    let note = |name: &str, more: &[&str]| {
        let scene = scene(name);
        let common = ["render", &scene, "-D", "size=8", "--error", "90%", "-o"];
        let output = nephroid(&[&common[..], &[path.to_str().unwrap()], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        (text(&output.stdout), text(&output.stderr))
    };
    let (summary, notice) = note("glass-ball.xml", &["--seed", "3"]);
    assert!(summary.contains("· photons"), "{summary}");
    assert!(
        notice.starts_with("note: --seed") && notice.contains("beams"),
        "{notice}"
    );
    for option in ["--seed", "--replicates"] {
        let (_, notice) = note("glass-ball.xml", &["--method", "beams", option, "3"]);
        assert!(
            notice.contains(option) && notice.contains("no effect"),
            "{notice}"
        );
    }
    // Where it does what one would think, there is nothing to say.
    for more in [&["--seed", "3", "--method", "photons"][..], &[]] {
        assert_eq!(note("glass-ball.xml", more).1, "");
    }
    assert_eq!(note("cornell-glass.xml", &["--seed", "3"]).1, "");
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
