//! `nephroid render --method full`, as a user meets it.

use std::process::Output;

use assert_cmd::Command;
use nephroid::internals::film::exr;

/// A point light and a glass ball over a floor, small enough to be quick.
const SCENE: &str = "<scene version=\"3.0.0\"><sensor type=\"perspective\" id=\"eye\"><float name=\"fov\" value=\"40\"/>\
    <transform name=\"to_world\"><lookat origin=\"0, -3, 1\" target=\"0, 0, 0\" up=\"0, 0, 1\"/></transform>\
    <film type=\"hdrfilm\"><integer name=\"width\" value=\"20\"/><integer name=\"height\" value=\"12\"/>\
    <rfilter type=\"box\"/></film></sensor>\
    <shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/><translate z=\"-0.5\"/></transform>\
    <sensor type=\"irradiancemeter\" id=\"floor\"/></shape>\
    <shape type=\"sphere\"><float name=\"radius\" value=\"0.4\"/><bsdf type=\"dielectric\"/></shape>\
    <emitter type=\"point\"><point name=\"position\" value=\"0, 0, 3\"/></emitter></scene>";

fn render(arguments: &[&str]) -> (Output, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.xml"), SCENE).unwrap();
    let output = Command::cargo_bin("nephroid")
        .unwrap()
        .current_dir(&folder)
        .args(["render", "scene.xml", "--method", "full"])
        .args(arguments)
        .output()
        .unwrap();
    (output, folder)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn one_report_and_one_file_hold_all_classes_and_who_measured_them() {
    let (output, folder) = render(&["--spp", "32", "--photons", "1048576", "-o", "a.exr"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    for words in [
        "sensor eye",
        "full",
        "warning: caustic-indirect",
        "caustic by beams",
        "caustic-sds by photon-map: 1048576 photons",
        "emitted, direct, indirect, caustic-indirect by path: 32 samples a pixel",
    ] {
        assert!(said.contains(words), "{words:?} in:\n{said}");
    }
    // What else warns of missing direct light is for methods that have none.
    assert!(!said.contains("(LD)"), "{said}");
    let image = exr::read(&folder.path().join("a.exr")).unwrap();
    for channel in [
        "L.R",
        "L.lo.G",
        "L.stderr.B",
        "direct.hi.R",
        "caustic.R",
        "caustic.lo.R",
    ] {
        assert!(image.channel(channel).is_some(), "{channel}");
    }
    // Deterministic; and a point light's, never found.
    for channel in ["caustic.stderr.R", "caustic-indirect.R", "count.Y"] {
        assert!(image.channel(channel).is_none(), "{channel}");
    }
    assert!(image.channel("caustic-sds.hi.B").is_some());
    assert_eq!(image.metadata("method"), Some("full"));
    let full: serde_json::Value = serde_json::from_str(image.metadata("full").unwrap()).unwrap();
    let methods: Vec<_> = full["parts"].as_array().unwrap().iter().collect();
    assert_eq!(methods.len(), 3);
    assert_eq!(methods[0]["method"], "beams");
    assert_eq!(methods[1]["classes"][0], "caustic-sds");
    assert_eq!(methods[2]["path"]["samples"], 32);
    assert!(
        image
            .metadata("warnings")
            .unwrap()
            .contains("caustic-indirect")
    );
}

#[test]
fn options_that_contradict_all_light_and_receivers_are_refused() {
    for (arguments, words) in [
        (&["--sensor", "floor"][..], "paths start at cameras"),
        (
            &["--rays", "9"],
            "no setting of full is called \"--rays\"; it is one of beams",
        ),
        (
            &["--shard", "1/2", "--photons", "9", "-o", "a.shard"],
            "shards are for --method photons, path, photon-map: a run of full is made in one piece",
        ),
        (&["--seen", "anyhow"], "\"--seen\"; it is one of photon-map"),
        (
            &["--without-caustics"],
            "\"--without-caustics\"; it is one of path",
        ),
        (
            &["--error", "1%", "--replicates", "1"],
            "--replicates is \"1\"; allowed are whole numbers 2..=255",
        ),
    ] {
        let (output, folder) = render(arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(words), "{arguments:?}: {said}");
        assert!(!folder.path().join("out/scene.exr").exists());
    }
}
