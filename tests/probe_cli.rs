//! `nephroid probe` as a user meets it.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

fn probe(scene: &str, arguments: &[&str]) -> Output {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(scene);
    Command::cargo_bin("nephroid")
        .unwrap()
        .arg("probe")
        .arg(scene)
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn the_table_lists_every_path_and_their_sum() {
    let output = probe("glass-ball.xml", &["--at", "0.57,0.52", "--max-depth", "2"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let table = text(&output.stdout);
    assert_eq!(table.matches("LTTD").count(), 3, "{table}");
    for expected in [
        "sensor floor",
        "E [W/m²]",
        "folded",
        "ball T (",
        "sum",
        "m²/sr",
    ] {
        assert!(table.contains(expected), "{expected} in {table}");
    }
}

#[test]
fn json_holds_what_the_table_holds() {
    let output = probe(
        "coffee-cup.xml",
        &["--at", "0.6,0.4", "--max-depth", "1", "--json"],
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let paths = report["paths"].as_array().unwrap();
    let sum: f64 = paths
        .iter()
        .map(|path| path["irradiance"][0].as_f64().unwrap())
        .sum();
    // The same additions, printed to the last bit.
    assert_eq!(report["irradiance"][0].as_f64().unwrap(), sum);
    let reflected = paths
        .iter()
        .find(|path| path["signature"] == "LRD")
        .unwrap();
    assert_eq!(reflected["vertices"][0]["shape"], "cup");
    assert_eq!(reflected["vertices"][0]["event"], "R");
    assert_eq!(reflected["jacobian_unit"], "m²/m²");
    assert_eq!(report["unresolved_patches"], 0);
}

#[test]
fn a_point_off_the_receiver_is_refused_by_name_and_range() {
    for at in ["1.01,0.5", "0.5,-0.2"] {
        let output = probe("glass-ball.xml", &["--at", at]);
        assert_eq!(output.status.code(), Some(2));
        let message = text(&output.stderr);
        let (u, v) = at.split_once(',').unwrap();
        assert!(
            message.contains(&format!("({u}, {v})")) && message.contains("0..=1"),
            "{message}"
        );
    }
    for at in ["0.5", "a,b", "NaN,0.5", "0.5,inf"] {
        let output = probe("glass-ball.xml", &["--at", at]);
        assert_eq!(output.status.code(), Some(2), "{at}");
        assert!(text(&output.stderr).contains("two numbers"), "{at}");
    }
}

#[test]
fn lights_with_a_surface_and_cameras_are_refused() {
    let output = probe("cornell-glass.xml", &["--at", "0.5,0.5"]);
    assert_eq!(output.status.code(), Some(2));
    let message = text(&output.stderr);
    assert!(
        message.contains("area") && message.contains("point, spot and directional"),
        "{message}"
    );
    let output = probe("glass-ball.xml", &["--at", "0.5,0.5", "--sensor", "camera"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("irradiancemeter"));
}
