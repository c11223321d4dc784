//! Results that a run prints and writes: summaries, films, bounds.

use nephroid::internals::film::exr;

use super::folder::{Folder, nephroid, scene, text};
use crate::support;

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
                // Neither standard errors nor bounds: `LAYER.G`.
                channel.name.ends_with(".G")
                    && channel.name.matches('.').count() == 1
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
        (
            &["--method", "photons", "--radius", "2"][..],
            "\"--radius\"",
        ),
        (&["--method", "beams", "--seen", "anyhow"], "\"--seen\""),
        (&["--method", "photon-map", "--radius=-1"], "radius"),
    ] {
        let output = render(more);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {message}");
        assert!(message.contains(expected), "{more:?}: {message}");
    }
}

/// Texels of which nothing is known are NaN in the file, null in JSON, "unknown" in the table and magenta in
/// the picture, whichever method was to measure them; and nothing is called known.
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
        assert!(image.channel("E.lo.R").is_some());
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
            assert_eq!(value[texel], layer.values[texel].0[1] as f32);
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
