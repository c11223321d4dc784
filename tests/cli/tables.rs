//! `nephroid tables`, and `--cache`, as typed.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use nephroid::internals::film::exr;

const SMALL: [&str; 6] = [
    "--set",
    "frequency=1",
    "--set",
    "photons=4096",
    "--set",
    "cells=16",
];

fn nephroid(command: &str, cache: &Path, more: &[&str]) -> Output {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/glass-ball.xml");
    Command::cargo_bin("nephroid")
        .unwrap()
        .arg(command)
        .arg(scene)
        .args(["-D", "size=16"])
        .arg("--cache")
        .arg(cache)
        .args(more)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn all_tables_are_made_once_and_rendered_from() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("not/there/yet");
    let made = nephroid("tables", &cache, &SMALL);
    let (said, noted) = (text(&made.stdout), text(&made.stderr));
    assert!(made.status.success(), "{noted}");
    assert!(noted.contains("12 samples, 49152 photons"), "{noted}");
    assert!(said.starts_with("12 tables made and 0 read"), "{said}");
    let again = nephroid("tables", &cache, &SMALL);
    let said = text(&again.stdout);
    assert!(said.starts_with("0 tables made and 12 read"), "{said}");

    // A render from these tables has the numbers of one that makes its own.
    let image = |name: &str, cache: &Path| {
        let file = folder.path().join(name);
        let file = file.display().to_string();
        let more = [&SMALL[..], &["--method", "local-irradiance", "-o", &file]].concat();
        let rendered = nephroid("render", cache, &more);
        assert!(rendered.status.success(), "{}", text(&rendered.stderr));
        let image = exr::read(file.as_ref()).unwrap();
        image.channel("specular.G").unwrap().clone()
    };
    let elsewhere = folder.path().join("elsewhere");
    assert!(image("a.exr", &cache) == image("b.exr", &elsewhere));
    let tables = fs::read_dir(elsewhere.join("local-irradiance")).unwrap();
    assert_eq!(tables.count(), 1);
}

#[test]
fn exported_volumes_are_as_long_as_their_description_says() {
    let folder = tempfile::tempdir().unwrap();
    let cells = 16 * 16 * 16;
    let triangles = 6 * 20 * 16;
    for (set, kind, bytes) in [
        ("space=grid", "grid", 3 * cells),
        ("space=shells", "shells", 3 * triangles),
        ("space=multi-resolution", "shells", 3 * triangles),
    ] {
        let out = folder.path().join(set);
        let out = out.display().to_string();
        let level = ["--set", "shell-level=2", "--set", set, "--export", &out];
        let made = nephroid("tables", folder.path(), &[&SMALL[..], &level].concat());
        assert!(made.status.success(), "{}", text(&made.stderr));
        let json = fs::read_to_string(Path::new(&out).join("tables.json")).unwrap();
        let described: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(
            described["directions_to_light"].as_array().unwrap().len(),
            12
        );
        assert_eq!(described["numbers"]["type"], "u8");
        let object = &described["objects"][0];
        assert_eq!(object["layout"]["kind"], kind);
        let (radius, region) = (&object["radius"], &object["region_radius"]);
        assert_eq!(3.0 * radius.as_f64().unwrap(), region.as_f64().unwrap());
        let tables = object["tables"].as_array().unwrap();
        assert_eq!(tables.len(), 12);
        for table in tables {
            let file = Path::new(&out).join(table["file"].as_str().unwrap());
            let numbers = fs::read(file).unwrap();
            assert_eq!(numbers.len(), bytes, "{set}");
            assert!(numbers.iter().any(|number| *number > 0));
        }
    }
}

#[test]
fn settings_are_chosen_by_bytes_and_the_tables_made_take_no_more() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let photons = ["--set", "photons=2048", "--set", "frequency=1"];
    let made = nephroid(
        "tables",
        &cache,
        &[&photons[..], &["--bytes", "400kB"]].concat(),
    );
    let (said, noted) = (text(&made.stdout), text(&made.stderr));
    assert!(made.status.success(), "{noted}");
    let chosen: Vec<&str> = said.lines().filter(|line| line.starts_with('>')).collect();
    // 12 directions of 16³ cells in 4 bytes are 197 kB; twice the cells do not fit.
    assert_eq!(chosen.len(), 1, "{said}");
    assert!(chosen[0].contains("cells=16"), "{said}");
    assert!(said.contains("12 tables made and 0 read"), "{said}");
    let form = fs::read_dir(cache.join("local-irradiance")).unwrap().next();
    let files = fs::read_dir(form.unwrap().unwrap().path()).unwrap();
    let bytes: u64 = files
        .map(|file| file.unwrap().metadata().unwrap().len())
        .sum();
    // A file has 400 bytes around its numbers at most.
    assert!(bytes <= 400_000 + 12 * 400, "{bytes}");
    let refused = nephroid("tables", &cache, &["--bytes", "1kB"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("there are no tables of 1000 bytes"));
}

#[test]
fn tables_that_cannot_be_are_refused_before_any_photon() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    for (more, said) in [
        (
            &["--method", "caustic-map"][..],
            "makes no tables that outlive a frame",
        ),
        (
            &["--method", "beams"],
            "makes no tables that outlive a frame",
        ),
        (&["--set", "light=exact"], "those of one frame"),
        (
            &["--set", "frequency=64", "--memory", "100MB"],
            "what would fit: ",
        ),
    ] {
        let refused = nephroid("tables", &cache, more);
        assert_eq!(refused.status.code(), Some(2), "{more:?}");
        let noted = text(&refused.stderr);
        assert!(noted.contains(said), "{noted}");
        assert!(!cache.exists());
    }
}

#[test]
fn tables_that_find_no_folder_are_incomplete() {
    let folder = tempfile::tempdir().unwrap();
    let blocked = folder.path().join("file");
    fs::write(&blocked, "in the way").unwrap();
    let made = nephroid("tables", &blocked, &SMALL);
    assert_eq!(made.status.code(), Some(1));
    let noted = text(&made.stderr);
    assert!(noted.contains("12 table files are not written"), "{noted}");
}
