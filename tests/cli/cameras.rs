//! Scenes that have cameras alone, as files for Mitsuba mostly do.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use nephroid::internals::film::{Image, exr};

/// A glass ball in lamplight before a camera of 12 x 9 pixels with a film's filter.
fn scene(folder: &Path, filter: &str) {
    let text = format!(
        r#"<scene version="3.0.0">
        <sensor type="perspective" id="eye">
            <transform name="to_world"><lookat origin="0, -4, 2" target="0, 0, 0" up="0, 0, 1"/></transform>
            <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
            <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="9"/>{filter}</film>
        </sensor>
        <emitter type="point"><point name="position" x="0" y="-1" z="3"/><rgb name="intensity" value="20"/></emitter>
        <shape type="rectangle"><bsdf type="diffuse"/></shape>
        <shape type="sphere"><point name="center" x="0" y="0" z="0.5"/><float name="radius" value="0.4"/>
            <bsdf type="dielectric"/></shape>
        </scene>"#
    );
    fs::write(folder.join("seen.xml"), text).unwrap();
}

/// What is said of a run, and its image.
fn rendered(folder: &Path, more: &[&str]) -> (String, Image) {
    let image = folder.join("seen.exr");
    let output = Command::cargo_bin("nephroid")
        .unwrap()
        .args(["render", "seen.xml", "--output"])
        .arg(&image)
        .args(more)
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output
            .status
            .code()
            .is_some_and(|code| code == 0 || code == 3),
        "{said}"
    );
    (said, exr::read(&image).unwrap())
}

/// Few photons: pictures are made, and no better than that.
const QUICK: [&str; 6] = ["--photons", "4096", "--error", "100%", "--spp", "4"];

fn mean(image: &Image, layer: &str) -> Option<f64> {
    let samples = &image.channel(&format!("{layer}.R"))?.samples;
    Some(samples.iter().map(|value| f64::from(*value)).sum::<f64>() / samples.len() as f64)
}

#[test]
fn the_first_camera_is_rendered_with_all_of_its_light() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), r#"<rfilter type="box"/>"#);
    let (said, image) = rendered(folder.path(), &QUICK);
    let notice = "note: no sensor is an irradiancemeter: camera \"eye\" is rendered by full, with all of its light";
    assert!(said.contains(notice), "{said}");
    assert_eq!([image.width, image.height], [12, 9]);
    assert!(mean(&image, "caustic").unwrap() > 0.0);
}

#[test]
fn a_scene_without_emitters_is_black_at_once_and_said_to_be() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), r#"<rfilter type="box"/>"#);
    let file = folder.path().join("seen.xml");
    let lit = fs::read_to_string(&file).unwrap();
    let (before, rest) = lit.split_once("<emitter").unwrap();
    let (_, after) = rest.split_once("</emitter>").unwrap();
    fs::write(&file, format!("{before}{after}")).unwrap();
    // An hour of time: nobody waits for it.
    for method in ["full", "path"] {
        let (_, image) = rendered(folder.path(), &["--method", method, "--time", "1h"]);
        let said = image.metadata("warnings").unwrap();
        assert!(
            said.contains("the scene has no emitter: its image is black"),
            "{said}"
        );
        assert_eq!(mean(&image, "L"), Some(0.0));
    }
}

#[test]
fn a_film_with_a_wider_filter_has_all_light_too() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), "");
    let (said, image) = rendered(folder.path(), &QUICK);
    assert!(said.contains("rendered by full"), "{said}");
    for layer in ["L", "caustic", "caustic-sds"] {
        assert!(mean(&image, layer).unwrap() > 0.0, "{layer}");
    }
}

#[test]
fn a_box_filter_that_is_asked_for_is_the_scenes_own() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), r#"<rfilter type="box"/>"#);
    let (_, own) = rendered(folder.path(), &QUICK);
    scene(folder.path(), "");
    let (said, asked) = rendered(folder.path(), &[&QUICK[..], &["--filter", "box"]].concat());
    assert!(said.contains("rendered by full"), "{said}");
    for (own, asked) in own.channels.iter().zip(&asked.channels) {
        let bits = |samples: &[f32]| samples.iter().map(|one| one.to_bits()).collect::<Vec<_>>();
        assert_eq!(
            (&own.name, bits(&own.samples)),
            (&asked.name, bits(&asked.samples))
        );
    }
}

#[test]
fn settings_of_one_method_alone_choose_it() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), r#"<rfilter type="box"/>"#);
    let (said, _) = rendered(
        folder.path(),
        &[
            "--spp",
            "4",
            "--replicates",
            "4",
            "--set",
            "without-caustics=true",
        ],
    );
    assert!(
        said.contains("rendered by path, whose settings are given"),
        "{said}"
    );
}

#[test]
fn inspect_lists_all_problems_those_of_one_kind_together() {
    let folder = tempfile::tempdir().unwrap();
    let shape = r#"<shape type="sphere"><bsdf type="velvet"/></shape>"#;
    let text = format!(
        "<scene version=\"3.0.0\">\n{shape}\n{shape}\n<shape type=\"disk\"><float name=\"mass\" value=\"1\"/></shape>\n</scene>"
    );
    fs::write(folder.path().join("odd.xml"), text).unwrap();
    let output = Command::cargo_bin("nephroid")
        .unwrap()
        .args(["inspect", "odd.xml"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert_eq!(lines.len(), 3, "{said}");
    assert!(lines[0].contains("3 problems keep this file from being a scene"));
    assert!(lines[1].contains("odd.xml:2:") && lines[1].contains("and 1 more: bsdf \"velvet\""));
    assert!(lines[2].contains("odd.xml:4:") && lines[2].contains("\"mass\""));
}
