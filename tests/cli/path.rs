//! `nephroid render --method path`, as a user meets it.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use nephroid::internals::film::exr;

/// A lamp and a glass ball over a floor, small enough to be quick; the file asks for two legs.
const SCENE: &str = "<scene version=\"3.0.0\"><integrator type=\"path\"><integer name=\"max_depth\" value=\"2\"/>\
    </integrator><sensor type=\"thinlens\" id=\"eye\"><float name=\"aperture_radius\" value=\"0.1\"/>\
    <float name=\"focus_distance\" value=\"3\"/><float name=\"fov\" value=\"40\"/>\
    <transform name=\"to_world\"><lookat origin=\"0, -3, 1\" target=\"0, 0, 0\" up=\"0, 0, 1\"/></transform>\
    <film type=\"hdrfilm\"><integer name=\"width\" value=\"20\"/><integer name=\"height\" value=\"12\"/>\
    <rfilter type=\"gaussian\"/></film></sensor>\
    <shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/><translate z=\"-0.5\"/></transform>\
    <sensor type=\"irradiancemeter\" id=\"floor\"/></shape>\
    <shape type=\"sphere\"><float name=\"radius\" value=\"0.4\"/><bsdf type=\"dielectric\"/></shape>\
    <shape type=\"rectangle\"><transform name=\"to_world\"><rotate x=\"1\" angle=\"180\"/><translate z=\"3\"/>\
    </transform><emitter type=\"area\"><rgb name=\"radiance\" value=\"4\"/></emitter></shape></scene>";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        std::fs::write(folder.path("scene.xml"), SCENE).unwrap();
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn render(&self, arguments: &[&str]) -> Output {
        Command::cargo_bin("nephroid")
            .unwrap()
            .current_dir(&self.0)
            .args(["render", "scene.xml", "-o", "a.exr"])
            .args(arguments)
            .output()
            .unwrap()
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn attribute(image: &Path, name: &str) -> String {
    exr::read(image).unwrap().metadata(name).unwrap().to_owned()
}

#[test]
fn an_image_by_paths_has_a_layer_a_class_and_an_error_bar_for_each() {
    let folder = Folder::new();
    // The first camera, not the meter, and as many legs as the file says: direct light ends there.
    let output = folder.render(&["--method", "path", "--spp", "64"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    for words in [
        "sensor eye",
        "20 x 12",
        "path",
        "64 samples a pixel",
        "radiance [W/m²/sr]",
        "direct",
    ] {
        assert!(said.contains(words), "{words:?} in:\n{said}");
    }
    let image = exr::read(&folder.path("a.exr")).unwrap();
    assert_eq!((image.width, image.height), (20, 12));
    for channel in ["L.R", "L.stderr.G", "direct.B", "direct.stderr.R"] {
        assert!(image.channel(channel).is_some(), "{channel}");
    }
    for channel in ["indirect.R", "L.lo.R", "count.Y"] {
        assert!(image.channel(channel).is_none(), "{channel}");
    }
    assert!(folder.path("a.png").exists());
    let settings = attribute(&folder.path("a.exr"), "settings");
    assert!(settings.contains("\"max_depth\":2"), "{settings}");
    assert_eq!(attribute(&folder.path("a.exr"), "method"), "path");
}

#[test]
fn flags_win_over_the_files_integrator() {
    let folder = Folder::new();
    let output = folder.render(&[
        "--spp",
        "32",
        "--sensor",
        "eye",
        "--max-depth",
        "40",
        "--rr-depth",
        "3",
        "--hide-emitters",
        "--light-sampling",
        "balance",
        "--without-caustics",
        "--samples",
        "random",
        "--json",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let settings = attribute(&folder.path("a.exr"), "settings");
    for words in [
        "\"max_depth\":40",
        "\"rr_depth\":3",
        "\"hide_emitters\":true",
        "\"light_sampling\":\"balance\"",
        "\"classes\":[\"emitted\",\"direct\",\"indirect\"]",
        "\"stream\":\"random\"",
    ] {
        assert!(settings.contains(words), "{words} in {settings}");
    }
    let said: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(said["path"]["samples"], 32);
    assert_eq!(said["path"]["cut_off"], 0);
    let names: Vec<_> = said["layers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|it| it["name"].clone())
        .collect();
    assert!(
        names.contains(&"indirect".into()) && !names.contains(&"caustic".into()),
        "{names:?}"
    );
}

#[test]
fn options_of_other_methods_and_sensors_that_are_no_cameras_are_refused() {
    let folder = Folder::new();
    for (arguments, words) in [
        (
            &["--method", "path", "--sensor", "floor"][..],
            "paths start at cameras",
        ),
        (
            &["--method", "path", "--photons", "9"],
            "no setting of path is called \"--photons\"; it is one of photons",
        ),
        (
            &["--method", "path", "--rays", "9"],
            "\"--rays\"; it is one of beams",
        ),
        (
            &["--method", "photons", "--spp", "9"],
            "\"--spp\"; it is one of path",
        ),
        (
            &["--method", "beams", "--rr-depth", "9"],
            "\"--rr-depth\"; it is one of path",
        ),
        (
            &["--method", "path", "--error", "1%", "--replicates", "1"],
            "at least 2 replicates",
        ),
    ] {
        let output = folder.render(arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(words), "{arguments:?}: {said}");
        assert!(!folder.path("a.exr").exists());
    }
}
