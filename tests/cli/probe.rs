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
    assert_eq!(report["complete"], true);
}

#[test]
fn as_many_specular_events_are_allowed_as_a_signature_holds_and_no_more() {
    let probed = |depth: &str| {
        let arguments = ["--at", "0.6,0.4", "--rays", "1", "--max-depth", depth];
        probe("coffee-cup.xml", &arguments)
    };
    let longest = probed("127");
    let said = text(&longest.stderr);
    assert!(matches!(longest.status.code(), Some(0 | 1)), "{said}");
    let beyond = probed("128");
    let said = text(&beyond.stderr);
    assert_eq!(beyond.status.code(), Some(2), "{said}");
    assert!(said.contains("0..=127"), "{said}");
}

/// Below the ball's centre the light of whole circles meets: a curve of light space, of which each division has twice
/// the pieces.
#[test]
fn a_search_without_end_is_ended_and_says_how_far_it_got() {
    let focus = ["--at", "0.5,0.5", "--max-depth", "2"];
    for (limit, reason) in [
        (["--rays", "100000"], "ran out of rays"),
        (["--time", "1s"], "was stopped"),
    ] {
        let output = probe("glass-ball.xml", &[&focus[..], &limit].concat());
        let table = text(&output.stdout);
        assert_eq!(output.status.code(), Some(1), "{table}");
        for expected in ["INCOMPLETE", reason, "of at most 30", "LTTD"] {
            assert!(table.contains(expected), "{expected} in {table}");
        }
    }
    let arguments = [&focus[..], &["--rays", "100000", "--json"]].concat();
    let output = probe("glass-ball.xml", &arguments);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["complete"], false);
    assert_eq!(report["search"], "out-of-rays");
    assert!(report["divisions"].as_u64().unwrap() < 30);
    assert!(report["unresolved_patches"].as_u64().unwrap() > 0);
    // 256 pieces of 9 nodes are looked at in one go, with some dozen rays a node.
    let rays = report["counters"]["rays"].as_u64().unwrap();
    assert!((100_000..400_000).contains(&rays), "{rays}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_search_shows_what_it_found_and_marks_it() {
    use std::process::{Command, Stdio};
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/glass-ball.xml");
    let child = Command::new(env!("CARGO_BIN_EXE_nephroid"))
        .arg("probe")
        .arg(scene)
        .args(["--at", "0.5,0.5", "--rays", "281474976710656"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_secs(3));
    let interrupted = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(interrupted.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let table = text(&output.stdout);
    assert!(
        table.contains("INCOMPLETE") && table.contains("was stopped"),
        "{table}"
    );
}

/// A point in the corner of a floor that no light gets to: a wall stands around the lamp's sight.
#[test]
fn without_any_path_there_is_nothing_to_explain() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("dark.xml");
    let lid = r#"<shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="180"/><translate z="1"/></transform>
    </shape>"#;
    std::fs::write(&scene, floor_under(lid)).unwrap();
    let output = probe(scene.to_str().unwrap(), &["--at", "0.5,0.5"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let table = text(&output.stdout);
    assert!(table.contains("0 paths"), "{table}");
    assert!(!table.contains("|J| is"), "{table}");
}

/// As many as photons pass: both have one limit on surfaces that are nothing.
#[test]
fn light_passes_hundreds_of_surfaces_that_are_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("veils.xml");
    let veils: String = (1..=400)
        .map(|index| {
            format!(
                r#"<shape type="rectangle"><bsdf type="null"/>
                <transform name="to_world"><translate z="{}"/></transform></shape>"#,
                f64::from(index) / 200.0
            )
        })
        .collect();
    std::fs::write(&scene, floor_under(&veils)).unwrap();
    let output = probe(scene.to_str().unwrap(), &["--at", "0.5,0.5", "--json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["paths"].as_array().unwrap().len(), 1);
    // 9 W/sr from 3 m above. At each veil the ray begins anew, a dozen operations of half an ulp from where
    // it was.
    let irradiance = report["irradiance"][0].as_f64().unwrap();
    let rounding = 400.0 * 16.0 * f64::EPSILON;
    assert!((irradiance - 1.0).abs() < rounding, "{irradiance}");
}

/// A lamp 3 m above the middle of a floor, with something between.
fn floor_under(between: &str) -> String {
    format!(
        r#"<scene version="3.0.0">
    <emitter type="point">
        <point name="position" x="0" y="0" z="3"/><rgb name="intensity" value="9"/>
    </emitter>
    {between}
    <shape type="rectangle">
        <bsdf type="diffuse"/>
        <sensor type="irradiancemeter">
            <film type="hdrfilm">
                <integer name="width" value="4"/><integer name="height" value="4"/>
                <rfilter type="box"/>
            </film>
        </sensor>
    </shape>
</scene>"#
    )
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
