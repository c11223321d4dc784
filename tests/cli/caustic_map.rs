//! `nephroid render --method caustic-map` and `nephroid attribute`, as typed.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use nephroid::internals::film::exr;

fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/glass-ball.xml")
}

fn nephroid() -> Command {
    Command::cargo_bin("nephroid").unwrap()
}

#[test]
fn a_caustic_map_is_written_with_its_settings_and_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("map.exr");
    let output = nephroid()
        .arg("render")
        .arg(scene())
        .args(["-D", "size=32", "--method", "caustic-map"])
        .args(["--set", "splat=fixed", "--set", "photons=64"])
        .arg("-o")
        .arg(&file)
        .assert()
        .success();
    let said = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    assert!(said.contains("approximation"), "{said}");
    let image = exr::read(&file).unwrap();
    assert!(image.channel("LTTD.G").is_some());
    assert_eq!(image.metadata("method"), Some("caustic-map"));
    let settings = image.metadata("settings").unwrap();
    assert!(settings.contains(r#""splat":"fixed""#), "{settings}");
    assert!(settings.contains(r#""photons":64"#), "{settings}");
    assert!(image.metadata("work").unwrap().contains("fragments"));
    assert!(file.with_extension("png").is_file());
}

#[test]
fn a_wrong_setting_is_refused_with_the_one_that_was_meant() {
    let refused = |set: &str, method: &str| {
        let assert = nephroid()
            .arg("render")
            .arg(scene())
            .args(["--method", method, "--set", set])
            .assert()
            .code(2);
        String::from_utf8_lossy(&assert.get_output().stderr).into_owned()
    };
    let said = refused("spalt=fixed", "caustic-map");
    assert!(said.contains("did you mean \"splat\"?"), "{said}");
    let said = refused("photons=0", "caustic-map");
    assert!(said.contains("allowed are whole numbers 1"), "{said}");
    let said = refused("photons=8", "beams");
    assert!(
        said.contains("it is one of") && said.contains("caustic-map"),
        "{said}"
    );
}

#[test]
fn attribution_without_the_truth_that_was_asked_for_says_so_and_fails() {
    // A millionth of a percent takes hours. Whether a pass is through in a blink is the machine's affair:
    // without one there is no table, with one it is marked.
    let assert = nephroid()
        .arg("attribute")
        .arg(scene())
        .args(["-D", "size=16", "--error", "0.000001%", "--time", "200ms"])
        .args(["--set", "photons=16", "--set", "map=16"])
        .assert()
        .failure();
    let said = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
    match assert.get_output().status.code() {
        Some(1) => assert!(said.contains("unresolved"), "{said}"),
        _ => assert!(said.contains("stopped before its first pass"), "{said}"),
    }
}

#[test]
fn attribution_prints_every_stage_and_what_is_left() {
    let output = nephroid()
        .arg("attribute")
        .arg(scene())
        .args([
            "-D",
            "size=16",
            "--error",
            "5%",
            "--set",
            "photons=64",
            "--set",
            "map=64",
        ])
        .assert()
        .success();
    let said = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    for word in [
        "view",
        "refraction",
        "hit",
        "flux",
        "fresnel",
        "splat",
        "lookup",
        "adds",
        "all exact",
        "= l1",
        "not modelled",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
}

#[test]
fn truth_by_photons_gives_the_error_that_truth_by_beams_gives() {
    let attributed = |truth: &str| -> serde_json::Value {
        let output = nephroid()
            .arg("attribute")
            .arg(scene())
            .args(["-D", "size=16", "--error", "1%", "--json"])
            .args(["--truth", truth, "--set", "photons=64", "--set", "map=64"])
            .assert()
            .success();
        serde_json::from_slice(&output.get_output().stdout).unwrap()
    };
    let [beams, photons] = ["beams", "photons"].map(attributed);
    // The truths differ in how they were made, so that their errors are not the same number.
    assert_ne!(beams["truth_error"], photons["truth_error"]);
    let l2 = |found: &serde_json::Value| {
        let figures = found["figures"].as_array().unwrap();
        let l2 = figures.iter().find(|it| it["figure"] == "l2").unwrap();
        l2["whole"].as_f64().unwrap()
    };
    // L2 is a norm of the difference by the truth's. Truths that err by 1 % each, relative to a mean that is
    // no larger than the root mean square, move it by 1 % and by its own part at most.
    let (one, other) = (l2(&beams), l2(&photons));
    assert!(
        (one - other).abs() < 0.02 * (1.0 + one),
        "{one} and {other}"
    );
    // Light of other paths is 1.38 % of all by mirrors and glass (beams to 0.01 %). Of what is asked for beams
    // leave out a quarter at most; photons know the sum of all light to 1 % of it.
    let rest = [&beams, &photons].map(|found| found["not_modelled"].as_f64().unwrap());
    assert!((rest[0] - 0.0138).abs() < 0.0025, "{rest:?}");
    assert!((rest[1] - 0.0138).abs() < 0.01, "{rest:?}");
}

#[test]
fn what_stages_add_and_what_is_left_is_the_figure() {
    let attributed = |side: &str| -> serde_json::Value {
        let output = nephroid()
            .arg("attribute")
            .arg(scene())
            .args(["-D", "size=32", "--error", "5%", "--side", side, "--json"])
            .args([
                "--set",
                "photons=64",
                "--set",
                "map=64",
                "--set",
                "view=exact",
            ])
            .assert()
            .success();
        serde_json::from_slice(&output.get_output().stdout).unwrap()
    };
    let found = attributed("32");
    assert_eq!(found["size"], serde_json::json!([32, 32]));
    let names: Vec<&str> = found["figures"]
        .as_array()
        .unwrap()
        .iter()
        .map(|figure| figure["figure"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["l1", "energy", "misplaced", "displaced", "l2"]);
    for figure in found["figures"].as_array().unwrap() {
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let stages = figure["stages"].as_array().unwrap();
        let added: f64 = stages.iter().map(|stage| number(&stage["value"])).sum();
        let (whole, residual) = (number(&figure["whole"]), number(&figure["residual"]));
        // Sums of 128 products of numbers below 10.
        assert!((residual + added - whole).abs() < 1e-12, "{figure}");
        // A stage that is exact as it is set adds nothing, and to make it exact changes nothing.
        assert_eq!(stages[0]["value"], 0.0);
        assert_eq!(stages[0]["fixed"], figure["whole"]);
        assert_eq!(stages[0]["spoiled"], figure["residual"]);
        // With all stages up to the last exact, all are.
        assert_eq!(stages.last().unwrap()["cumulative"], figure["residual"]);
    }
    // Squares of 2 x 2 texels, on request.
    assert_eq!(attributed("16")["size"], serde_json::json!([16, 16]));
}
