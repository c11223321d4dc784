//! The report: its figures, its commands, its page, and the record beside it.

use std::fs;

use assert_cmd::Command;
use nephroid::internals::film::exr;
use serde_json::Value;

use super::folder::{Folder, light, row};

#[test]
fn figures_are_those_of_compare_to_the_last_digit() {
    let folder = Folder::with_films();
    let (report, code, said) = folder.validate(&["a.toml", "-o", "r"]);
    assert_eq!(code, Some(0), "{said}");
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let command = row["compare"].as_str().unwrap();
        let words: Vec<&str> = command.split(' ').skip(1).chain(["--json"]).collect();
        let mut compare = Command::cargo_bin("nephroid").unwrap();
        let output = compare
            .current_dir(folder.path("r"))
            .args(words)
            .output()
            .unwrap();
        let compared: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(row["comparison"]["layers"], compared["layers"], "{command}");
        assert_eq!(row["comparison"]["notes"], compared["notes"]);
        let total = &compared["layers"][0];
        assert_eq!(row["error"], total["fidelity"]["l1"]["value"]);
        assert_eq!(row["picture"]["flip"], total["flip"]["mean"]);
    }
}

#[test]
fn a_rows_command_makes_its_film() {
    let folder = Folder::with_films();
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    for name in ["beams", "photons"] {
        let row = row(&report, name);
        let command = row["command"].as_str().unwrap();
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        assert!(folder.run(&words).status.success(), "{command}");
        let kept = exr::read(&folder.path("r").join(row["file"].as_str().unwrap())).unwrap();
        let made = exr::read(&folder.path(words.last().unwrap())).unwrap();
        for channel in &kept.channels {
            let other = made.channel(&channel.name).unwrap();
            let bits = |samples: &[f32]| samples.iter().map(|it| it.to_bits()).collect::<Vec<_>>();
            assert_eq!(
                bits(&channel.samples),
                bits(&other.samples),
                "{} of {command}",
                channel.name
            );
        }
    }
}

#[test]
fn the_page_needs_nothing_else_and_no_text_in_it_ends_its_script() {
    let folder = Folder::with_films();
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    let truth = folder.truth(&report);
    folder.candidate("mine.exr", &truth, |truth, x, y| {
        light(truth, x as isize, y as isize)
    });
    let name = "</script><script>alert(1)</script>=mine.exr";
    let (_, code, said) = folder.validate(&["a.toml", "-o", "r", "--candidate", name]);
    assert_eq!(code, Some(0), "{said}");
    let page = fs::read_to_string(folder.path("r/index.html")).unwrap();
    assert_eq!(page.matches("</script>").count(), 2);
    assert!(!page.contains("alert(1)</script>"));
    for outside in ["src=\"http", "href=\"http", "@import", "url(http", "fetch("] {
        assert!(!page.contains(outside), "{outside}");
    }
    for left in ["{{title}}", "{{data}}", "/*style*/", "/*script*/"] {
        assert!(!page.contains(left), "{left}");
    }
    let csv = fs::read_to_string(folder.path("r/report.csv")).unwrap();
    assert_eq!(csv.lines().count(), 6);
}

/// In a package or an archive without its repository it is unknown; here it is a hash, or that.
#[test]
fn the_record_names_the_commit_and_the_report_does_not() {
    let folder = Folder::with_films();
    let (_, _, said) = folder.validate(&["a.toml", "-o", "r"]);
    let timings = fs::read(folder.path("r/timings.json")).unwrap();
    let timings: Value = serde_json::from_slice(&timings).unwrap();
    let commit = timings["commit"].as_str().unwrap();
    let hash = commit.trim_end_matches("-modified");
    let is_hash = hash.len() >= 40 && hash.chars().all(|c| c.is_ascii_hexdigit());
    assert!(is_hash || commit == "unknown", "{commit}");
    assert!(!folder.report(&said).to_string().contains(commit));
}

#[test]
fn a_report_of_two_machines_tells_them_by_run_and_fits_no_order_to_their_seconds() {
    let folder = Folder::with_films();
    let timings = || -> Value {
        serde_json::from_slice(&fs::read(folder.path("r/timings.json")).unwrap()).unwrap()
    };
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    let curves = report["curves"].as_array().unwrap();
    let photons = curves.iter().position(|curve| curve["name"] == "photons");
    let before = timings();
    let sensor = &before["sensors"][0];
    assert!(sensor["orders"][photons.unwrap()].is_object(), "{sensor}");
    assert_eq!(sensor["notes"].as_array().unwrap().len(), 0);
    let host = &sensor["truth"]["machine"]["host"];
    assert!(before.get("machine").is_none());
    for row in sensor["rows"].as_array().unwrap() {
        assert_eq!(row["machine"]["host"], *host);
        assert!(row["machine"]["processor"].is_string() && row["threads"].is_u64());
    }
    // One run, as if it had been made elsewhere and its folder copied.
    let film = row(&report, "photons")["file"].as_str().unwrap().to_owned();
    let time = folder.path("r").join(film.replace(".exr", ".time.json"));
    let mut elsewhere: Value = serde_json::from_slice(&fs::read(&time).unwrap()).unwrap();
    elsewhere["machine"]["host"] = "elsewhere".into();
    fs::write(&time, elsewhere.to_string()).unwrap();
    let (again, code, said) = folder.validate(&["a.toml", "-o", "r"]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(again, report);
    let after = timings();
    let sensor = &after["sensors"][0];
    assert!(sensor["orders"][photons.unwrap()].is_null(), "{sensor}");
    let note = sensor["notes"][0].as_str().unwrap();
    assert!(note.starts_with("photons: no order in seconds"), "{note}");
    let summary = fs::read_to_string(folder.path("r/summary.md")).unwrap();
    assert!(summary.contains("on elsewhere, "), "{summary}");
    assert!(summary.contains(note), "{summary}");
}
