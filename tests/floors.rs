//! The house has floors: a room imports only from its own folder or from lower floors.
//!
//! Also: the crates that only one room may know are named in no other.

use std::fs;
use std::path::{Path, PathBuf};

/// The floor of each room (the first part of a module path).
const FLOORS: &[(&str, u32)] = &[
    ("numeric", 0),
    ("radiometry", 0),
    ("setting", 0),
    ("geometry", 1),
    ("optics", 1),
    ("film", 1),
    ("scene", 2),
    ("generate", 2),
    ("mitsuba", 3),
    ("transport", 4),
    ("reference", 5),
    ("approximation", 5),
    ("metric", 6),
    ("study", 7),
    ("cli", 8),
];

/// Crates that only some folders or files may name, with each of these.
const PRIVATE_CRATES: &[(&str, &str)] = &[
    ("obvhs", "geometry/accel"),
    ("pulp", "numeric/fused.rs"),
    ("exr", "film"),
    ("image", "film"),
    ("roxmltree", "mitsuba"),
    ("half", "approximation"),
    ("kiddo", "reference/photon_map"),
    ("kiddo", "reference/beams/discovery/faces.rs"),
    ("tobj", "mitsuba"),
    ("toml", "study/file"),
    ("base64", "study/report"),
    ("strsim", "setting.rs"),
    ("clap", "cli"),
    ("indicatif", "cli"),
    ("anyhow", "cli"),
    ("ctrlc", "cli"),
];

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

fn rust_files(folder: &Path, into: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            rust_files(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

/// The code of a file: comments, and all from its tests on, left out.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]").next().unwrap_or_default();
    text.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n")
}

/// The rooms named after `crate::` or in `crate::{...}`.
fn imported_rooms(code: &str) -> Vec<String> {
    let mut rooms = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        if let Some(group) = rest.strip_prefix('{') {
            let mut depth = 0;
            let mut word = String::new();
            for letter in group.chars() {
                match letter {
                    '{' => depth += 1,
                    '}' if depth == 0 => break,
                    '}' => depth -= 1,
                    ',' if depth == 0 => word.clear(),
                    _ if depth > 0 => {}
                    letter if letter.is_alphanumeric() || letter == '_' => word.push(letter),
                    ':' if !word.is_empty() => rooms.push(std::mem::take(&mut word)),
                    _ => {}
                }
            }
        } else {
            let name: String = rest
                .chars()
                .take_while(|letter| letter.is_alphanumeric() || *letter == '_')
                .collect();
            rooms.push(name);
        }
    }
    rooms
}

fn floor(room: &str) -> Option<u32> {
    FLOORS
        .iter()
        .find(|(name, _)| *name == room)
        .map(|(_, floor)| *floor)
}

/// Reference and approximation stand on one floor and must not know each other; so must other
/// rooms of one floor, except that all of floor 0 may use its neighbours.
fn may_import(from: &str, to: &str) -> bool {
    let (Some(own), Some(other)) = (floor(from), floor(to)) else {
        return false;
    };
    from == to || other < own || own == 0 && other == 0
}

#[test]
fn no_floor_imports_upward() {
    let source = source();
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    assert!(files.len() > 50, "only {} files found", files.len());
    let mut wrong = Vec::new();
    let mut imports = 0;
    for path in files {
        let inside = path.strip_prefix(&source).unwrap().to_owned();
        let first = inside.iter().next().unwrap().to_string_lossy().into_owned();
        let room = first.trim_end_matches(".rs").to_owned();
        if room == "lib" || room == "main" {
            continue;
        }
        assert!(floor(&room).is_some(), "{} has no floor", inside.display());
        for to in imported_rooms(&code(&path)) {
            imports += 1;
            if !may_import(&room, &to) {
                wrong.push(format!("{} imports {to}", inside.display()));
            }
        }
    }
    assert!(imports > 100, "only {imports} imports found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn crates_stay_in_their_rooms() {
    let source = source();
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    let mut wrong = Vec::new();
    for path in files {
        let inside = path.strip_prefix(&source).unwrap().to_owned();
        let code = code(&path);
        for (name, _) in PRIVATE_CRATES {
            let named = code.contains(&format!("use {name}::"))
                || code.contains(&format!("use ::{name}::"))
                || code.contains(&format!(" {name}::")) && *name != "image" && *name != "exr";
            let is_home = |(one, home): &(&str, &str)| one == name && inside.starts_with(home);
            if named && !PRIVATE_CRATES.iter().any(is_home) {
                wrong.push(format!("{} names the crate {name}", inside.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_checker_finds_imports_in_every_form() {
    assert_eq!(imported_rooms("use crate::scene::Scene;"), ["scene"]);
    assert_eq!(
        imported_rooms("use crate::{film::{Grid, exr::write}, cli::args};"),
        ["film", "cli"]
    );
    assert_eq!(imported_rooms("let x = crate::study::run();"), ["study"]);
    assert!(!may_import("geometry", "scene"));
    assert!(!may_import("reference", "approximation"));
    assert!(!may_import("optics", "geometry"));
    assert!(may_import("transport", "geometry"));
}
