//! Studies of several sensors.

use std::fs;

use nephroid::internals::film::{Image, exr};
use serde_json::Value;

use super::folder::{Folder, SIZE, text};

#[test]
fn each_of_several_sensors_has_its_truth_its_runs_its_candidates_and_its_limits() {
    let folder = Folder::new();
    folder.two_sensors();
    let mut grey = Image::new(SIZE, SIZE);
    grey.add_rgb("", &vec![[1.0; 3]; SIZE * SIZE]);
    exr::write(&folder.path("grey.exr"), &grey).unwrap();
    let placed = [
        "--candidate",
        "mine@floor=grey.exr",
        "--max-error",
        "mine=1000",
    ];
    let arguments = [&["two.toml", "-o", "r"], &placed[..]].concat();
    let (_, code, said) = folder.validate(&arguments);
    assert_eq!(code, Some(0), "{said}");
    let report = folder.report(&said);
    let of = |sensor: usize, list: &str, key: &str| -> Vec<String> {
        let all = report["sensors"][sensor][list].as_array().unwrap();
        let texts = all.iter().map(|one| one[key].as_str().unwrap().to_owned());
        texts.collect()
    };
    assert_eq!(of(0, "rows", "name"), ["beams here", "mine"]);
    assert_eq!(of(1, "rows", "name"), ["path"]);
    assert_eq!(of(0, "gates", "name"), ["mine"]);
    assert_eq!(of(1, "gates", "name"), ["path"]);
    assert_eq!(report["sensors"][0]["truth"]["method"], "beams");
    assert_eq!(report["sensors"][1]["truth"]["method"], "path");
    assert_eq!(report["sensors"][1]["unit"], "W/m²/sr");
    let page = fs::read_to_string(folder.path("r/index.html")).unwrap();
    let data = page.split("id=\"data\">").nth(1).unwrap();
    let data: Value = serde_json::from_str(data.split("</script>").next().unwrap()).unwrap();
    assert_eq!(data["pictures"].as_array().unwrap().len(), 2);
    assert_eq!(data["pictures"][1]["size"], report["sensors"][1]["size"]);
    let (_, code, said) = folder.validate(&arguments);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(said.matches("kept from before").count(), 4, "{said}");
}

#[test]
fn an_image_that_could_be_of_several_sensors_must_name_its_own() {
    let folder = Folder::new();
    folder.two_sensors();
    for (arguments, says) in [
        (
            ["--candidate", "mine=grey.exr"],
            "--candidate mine@floor=FILE.exr",
        ),
        (
            ["--candidate", "mine@flour=grey.exr"],
            "did you mean \"floor\"?",
        ),
        (
            ["--max-error", "path@floor=5%"],
            "there are beams here, path, beams here@floor, path@camera",
        ),
        (["--sensor", "celing"], "no sensor with id \"celing\""),
    ] {
        let output = folder.run(&[&["validate", "two.toml", "-o", "r"], &arguments[..]].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(says), "{said}");
    }
}
