//! Studies of several poses.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::folder::{Folder, text};

/// A ball on its turntable in three poses of the sun; each time a truth and two runs.
fn study(folder: &Folder, poses: &str) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/turntable-ball.xml");
    let contents = format!(
        r#"
scene = {:?}
define = {{ size = 12, elevation = 45 }}
poses = {poses}
[truth]
method = "beams"
error = "3%"
[[method]]
method = "photons"
photons = [4096, 65536]
"#,
        scene.display().to_string()
    );
    fs::write(folder.path("poses.toml"), contents).unwrap();
}

#[test]
fn each_pose_has_its_truth_and_its_report_and_figures_go_over_all() {
    let folder = Folder::new();
    study(&folder, "[{ elevation = [60, 90] }, { azimuth = 200 }]");
    let output = folder.run(&["validate", "poses.toml", "-o", "r"]);
    let (said, told) = (text(&output.stderr), text(&output.stdout));
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("pose 3 of 3: azimuth=200"), "{said}");
    assert!(
        told.contains("3 poses") && told.contains("pose-002"),
        "{told}"
    );
    let json = |name: &str| -> Value {
        serde_json::from_slice(&fs::read(folder.path(name)).unwrap()).unwrap()
    };
    let all = json("r/poses.json");
    assert_eq!(all["poses"][1]["define"]["elevation"], "90");
    let rows = all["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    // The same figures as each pose's own report has, and of other scenes: the light is another.
    let mut hashes = Vec::new();
    for pose in 0..3 {
        let own = json(&format!("r/pose-{:03}/report.json", pose + 1));
        hashes.push(own["study"]["scene_hash"].as_str().unwrap().to_owned());
        let elevation = ["60", "90", "45"][pose];
        let define = own["study"]["define"].as_array().unwrap();
        assert!(define.contains(&serde_json::json!(["elevation", elevation])));
        for (row, own) in rows
            .iter()
            .zip(own["sensors"][0]["rows"].as_array().unwrap())
        {
            assert_eq!(row["label"], own["label"]);
            assert_eq!(row["l1"]["by_pose"][pose], own["error"]);
        }
    }
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), 3);
    for row in rows {
        let l1 = &row["l1"];
        let known: Vec<f64> = (0..3)
            .map(|pose| l1["by_pose"][pose].as_f64().unwrap())
            .collect();
        let worst = l1["worst"].as_f64().unwrap();
        assert_eq!(
            worst,
            known.iter().fold(0.0, |most: f64, one| most.max(*one))
        );
        let mean = known.iter().sum::<f64>() / 3.0;
        assert!((l1["mean"].as_f64().unwrap() - mean).abs() < 1e-12);
    }
    // All films are found again.
    let again = text(&folder.run(&["validate", "poses.toml", "-o", "r"]).stderr);
    assert_eq!(again.matches("kept from before").count(), 9, "{again}");
}

#[test]
fn poses_that_cannot_be_are_refused_by_name() {
    let folder = Folder::new();
    for (poses, says) in [
        ("{}", "poses have parameters of the scene"),
        ("[]", "poses have parameters of the scene"),
        ("3", "poses"),
        (
            "{ elevation = { from = 1, to = 2000, step = 1 } }",
            "more than 1000",
        ),
        ("{ elevation = [60], azimuth = [] }", "empty list"),
    ] {
        study(&folder, poses);
        let output = folder.run(&["validate", "poses.toml", "-o", "r"]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{poses}: {said}");
        assert!(
            said.contains(says) && said.contains("poses.toml"),
            "{poses}: {said}"
        );
    }
    study(&folder, "{ elevation = 60 }");
    let given = [
        "validate",
        "poses.toml",
        "-o",
        "r",
        "--candidate",
        "mine=grey.exr",
    ];
    let said = text(&folder.run(&given).stderr);
    assert!(said.contains("an image shows one pose"), "{said}");
    // A parameter that the scene does not have.
    study(&folder, "{ elevaton = 60 }");
    let said = text(&folder.run(&["validate", "poses.toml", "-o", "r"]).stderr);
    assert!(said.contains("elevaton"), "{said}");
}
