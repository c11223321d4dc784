//! Candidates and rows that are wrong, are over a limit, or cannot be told from the truth.

use std::fs;
use std::path::Path;

use super::folder::{Folder, SIZE, kinds, light, row};

#[test]
fn the_truth_scaled_is_a_bias_and_not_a_mistake() {
    let folder = Folder::with_films();
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    let truth = folder.truth(&report);
    folder.candidate("mine.exr", &truth, |truth, x, y| {
        light(truth, x as isize, y as isize).map(|value| 1.02 * value)
    });
    let (report, code, said) = folder.validate(&[
        "a.toml",
        "-o",
        "r",
        "--candidate",
        "mine=mine.exr",
        "--max-error",
        "mine=50%",
    ]);
    assert_eq!(code, Some(0), "{said}");
    let mine = row(&report, "mine");
    // Each texel is rounded to f32, 6e-8 of it at most.
    let layers = mine["comparison"]["layers"].as_array().unwrap();
    let energy = layers[0]["fidelity"]["energy"]["value"].as_f64().unwrap();
    assert!((energy - 1.02).abs() < 1e-7, "{mine}");
    assert_eq!(kinds(mine), Vec::<&str>::new());
    assert_eq!(report["gates"][0]["verdict"], "kept");
    let summary = fs::read_to_string(folder.path("r/summary.md")).unwrap();
    assert!(summary.contains("| 102 % | 2.00 % |"), "{summary}");
}

/// The report of an earlier run stays true if a later one fails: its image is not that of another content.
#[test]
fn the_image_that_a_report_judged_stays_when_another_has_its_name() {
    let folder = Folder::with_films();
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    let truth = folder.truth(&report);
    let scaled = |name: &str, factor: f64| {
        folder.candidate(name, &truth, |truth, x, y| {
            light(truth, x as isize, y as isize).map(|value| factor * value)
        });
    };
    scaled("mine.exr", 1.02);
    let mine = ["a.toml", "-o", "r", "--candidate", "mine=mine.exr"];
    let (report, _, _) = folder.validate(&mine);
    let file = row(&report, "mine")["file"].as_str().unwrap().to_owned();
    let before = fs::read(folder.path("r").join(&file)).unwrap();
    scaled("mine.exr", 1.04);
    let output =
        folder.run(&[&["validate"], &mine[..], &["--candidate", "other=gone.exr"]].concat());
    assert_eq!(output.status.code(), Some(2));
    assert!(fs::read(folder.path("r").join(&file)).unwrap() == before);
}

#[test]
fn moved_turned_and_wrongly_scaled_candidates_are_flagged() {
    let folder = Folder::new();
    // Ripples have no symmetry that hides how an image lies.
    let water = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/water.xml");
    let water = water.display().to_string();
    let size = format!("size={SIZE}");
    let first = ["-D", size.as_str(), "-o", "r"];
    fs::write(
        folder.path("p.toml"),
        format!("scene = {water:?}\n[truth]\nmethod = \"beams\"\nerror = \"1%\"\n[[method]]\nmethod = \"beams\"\nerror = \"10%\"\n"),
    )
    .unwrap();
    let (report, _, _) = folder.validate(&[&["p.toml"], &first[..]].concat());
    let truth = folder.truth(&report);
    let last = SIZE as isize - 1;
    folder.candidate("moved.exr", &truth, |truth, x, y| {
        light(truth, x as isize - 1, y as isize)
    });
    folder.candidate("flipped.exr", &truth, |truth, x, y| {
        light(truth, x as isize, last - y as isize)
    });
    folder.candidate("swapped.exr", &truth, |truth, x, y| {
        light(truth, y as isize, x as isize)
    });
    folder.candidate("radiance.exr", &truth, |truth, x, y| {
        light(truth, x as isize, y as isize).map(|value| value / std::f64::consts::PI)
    });
    let names = ["moved", "flipped", "swapped", "radiance"];
    let given: Vec<String> = names
        .iter()
        .map(|name| format!("{name}={name}.exr"))
        .collect();
    let mut arguments = [&["p.toml"], &first[..]].concat();
    for one in &given {
        arguments.extend(["--candidate", one]);
    }
    let (report, _, said) = folder.validate(&arguments);
    let message = |name: &str, kind: &str| {
        let checks = row(&report, name)["checks"].as_array().unwrap();
        let found = checks.iter().find(|check| check["kind"] == kind);
        found.unwrap_or_else(|| panic!("{name}: {checks:?}\n{said}"))["message"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    assert!(message("moved", "shift").contains("(+1, +0)"));
    assert!(message("flipped", "orientation").contains("upside down"));
    assert!(message("swapped", "orientation").contains("transposed"));
    assert!(message("radiance", "units").contains("1/π"));
    assert!(said.contains("warning: moved: it looks shifted"), "{said}");
    // Ripples that are moved by a texel are displaced by less than that: most of the light is even.
    for (limit, code, verdict) in [
        ("moved:displaced=1texel", 0, "kept"),
        ("moved:displaced=0.0001mm", 1, "exceeded"),
        ("moved:energy=50%", 0, "kept"),
        ("radiance:energy=50%", 1, "exceeded"),
    ] {
        let arguments = [&arguments[..], &["--max-error", limit]].concat();
        let (report, found, said) = folder.validate(&arguments);
        assert_eq!(report["gates"][0]["verdict"], verdict, "{limit}: {said}");
        assert_eq!(found, Some(code), "{limit}: {said}");
    }
}

#[test]
fn a_limit_that_is_exceeded_ends_with_1_and_one_that_is_kept_with_0() {
    let folder = Folder::with_films();
    let (report, _, _) = folder.validate(&["a.toml", "-o", "r"]);
    let rows = report["rows"].as_array().unwrap();
    let errors = rows.iter().filter(|row| row["name"] == "photons");
    let best = errors
        .map(|row| row["error"].as_f64().unwrap())
        .fold(f64::INFINITY, f64::min);
    for (factor, code, verdict) in [
        (1.5, 0, "kept"),
        (0.5, 1, "exceeded"),
        (1.0, 1, "undecided"),
    ] {
        let limit = format!("photons={}", factor * best);
        let (report, found, said) = folder.validate(&["a.toml", "-o", "r", "--max-error", &limit]);
        assert_eq!(report["gates"][0]["verdict"], verdict, "{said}");
        assert_eq!(found, Some(code), "{said}");
    }
}

#[test]
fn a_row_that_the_truth_cannot_resolve_is_said_to_be_so() {
    let folder = Folder::new();
    // The same beams as the truth's: no difference to resolve.
    folder.study(
        "same.toml",
        "[truth]\nmethod = \"beams\"\nerror = \"5%\"\n[[method]]\nmethod = \"beams\"\nerror = [\"5%\", \"1%\"]\n[[method]]\nmethod = \"photons\"\nphotons = 64\n",
    );
    let (report, _, _) = folder.validate(&["same.toml", "-o", "r"]);
    for row in report["rows"].as_array().unwrap() {
        let [error, truth] = ["error", "truth_error"].map(|key| row[key].as_f64().unwrap());
        assert_eq!(
            row["resolved"],
            error > 0.0 && truth <= 0.1 * error,
            "{row}"
        );
    }
    assert_eq!(report["rows"][0]["resolved"], false);
    assert_eq!(report["rows"][2]["resolved"], true);
    let summary = fs::read_to_string(folder.path("r/summary.md")).unwrap();
    assert!(summary.contains("not resolved"), "{summary}");
}
