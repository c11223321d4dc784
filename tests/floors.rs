//! The house has floors: a room imports only from its own folder or from lower floors.
//!
//! Also: the crates that only one room may know are named in no other; no file imports from one that
//! imports from it; and comments stay within their columns.

#[path = "support/house.rs"]
mod house;

use std::fs;
use std::path::{Path, PathBuf};

use house::circles;

/// The floor of each room (the first part of a module path).
const FLOORS: &[(&str, u32)] = &[
    ("numeric", 0),
    ("radiometry", 0),
    ("setting", 0),
    ("spectrum", 0),
    ("geometry", 1),
    ("optics", 1),
    ("film", 1),
    ("scene", 2),
    ("generate", 2),
    ("mitsuba", 3),
    ("transport", 4),
    ("metric", 2),
    ("run", 5),
    ("reference", 6),
    ("approximation", 6),
    ("method", 7),
    ("study", 8),
    ("cli", 9),
];

/// Crates that only some folders or files may name, with each of these.
const PRIVATE_CRATES: &[(&str, &str)] = &[
    ("arrayvec", "geometry/accel"),
    ("obvhs", "geometry/accel"),
    ("pulp", "numeric/fused.rs"),
    ("libm", "numeric/math.rs"),
    ("exr", "film"),
    ("image", "film"),
    ("roxmltree", "mitsuba"),
    ("half", "approximation"),
    ("kiddo", "reference/photon_map"),
    ("kiddo", "reference/beams/discovery/faces.rs"),
    ("tobj", "mitsuba"),
    ("toml", "study/file"),
    ("base64", "study/report"),
    ("strsim", "setting/error.rs"),
    ("clap", "cli"),
    ("indicatif", "cli"),
    ("anyhow", "cli"),
    ("ctrlc", "cli"),
];

/// Circles of files that are one thing, and why each is; paths below `src`, sorted.
///
/// An entry that is no circle any more fails the test, so that the list only holds what is there.
const ONE_THING: &[(&[&str], &str)] = &[];

/// The most columns of a comment's line.
const COLUMNS: usize = 110;

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
        if matches!(&*room, "lib" | "main" | "internals") {
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

/// All files, as paths below `src` and texts.
fn sources() -> Vec<(String, String)> {
    let source = source();
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    let read = |path: PathBuf| {
        let inside = path.strip_prefix(&source).unwrap();
        let words: Vec<_> = inside.iter().map(|word| word.to_string_lossy()).collect();
        (words.join("/"), fs::read_to_string(&path).unwrap())
    };
    files.into_iter().map(read).collect()
}

#[test]
fn no_file_imports_from_one_that_imports_from_it() {
    let circles = circles(&sources());
    let mut wrong = Vec::new();
    for circle in &circles {
        if !ONE_THING.iter().any(|(files, _)| circle.files == *files) {
            wrong.push(format!("a circle:\n  {}", circle.imports.join("\n  ")));
        }
    }
    for (files, _) in ONE_THING {
        if !circles.iter().any(|circle| circle.files == *files) {
            wrong.push(format!("stale, no such circle: {}", files.join(", ")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn comments_stay_within_their_columns() {
    let mut wrong = Vec::new();
    for (path, text) in sources() {
        for (number, line) in (1..).zip(text.lines()) {
            let columns = line.chars().count();
            if line.trim_start().starts_with("//") && columns > COLUMNS {
                wrong.push(format!("{path}:{number}: {columns} columns"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The circles of files made up for a test: path and text of each.
fn circles_of(files: &[(&str, &str)]) -> Vec<Vec<String>> {
    let owned = files
        .iter()
        .map(|(path, text)| ((*path).to_owned(), (*text).to_owned()));
    let circles = circles(&owned.collect::<Vec<_>>());
    circles.into_iter().map(|circle| circle.files).collect()
}

#[test]
fn the_checker_finds_a_circle_of_two() {
    let files = [
        ("lib.rs", "pub mod film; mod scene;"),
        (
            "film/mod.rs",
            "use crate::scene::{Scene, Shape as Form}; pub struct Film;",
        ),
        (
            "scene.rs",
            "fn at(film: &crate::film::Film) {} pub struct Scene;",
        ),
    ];
    assert_eq!(circles_of(&files), [["film/mod.rs", "scene.rs"]]);
    let by_module = ("scene.rs", "use super::film; fn at(film: film::Film) {}");
    assert_eq!(
        circles_of(&[files[0], files[1], by_module]),
        [["film/mod.rs", "scene.rs"]]
    );
    let by_child = [
        ("film/mod.rs", "mod grid; fn size() { grid::size() }"),
        ("film/grid.rs", "use super::size as outer;"),
    ];
    assert_eq!(circles_of(&by_child), [["film/grid.rs", "film/mod.rs"]]);
}

#[test]
fn the_checker_follows_re_exports_to_a_circle_of_three() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        (
            "a/mod.rs",
            "mod one; mod two;\npub(crate) use one::One; pub use two::{Two as Second};",
        ),
        ("a/one.rs", "use super::Second;"),
        ("a/two.rs", "fn two() { crate::b::third() }"),
        ("b.rs", "use crate::a::One;"),
    ];
    assert_eq!(circles_of(&files), [["a/one.rs", "a/two.rs", "b.rs"]]);
}

#[test]
fn the_checker_finds_no_circle_where_there_is_none() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        (
            "a/mod.rs",
            "mod one; mod two; pub use one::One; pub use two::Two;",
        ),
        (
            "a/one.rs",
            "use super::Two; // and not crate::b::third\nconst TEXT: &str = \"crate::b\";",
        ),
        (
            "a/two.rs",
            "pub struct Two;\n#[cfg(test)]\nmod tests { use super::super::One; }",
        ),
        (
            "b.rs",
            "use crate::a::One; use std::fs; fn open<'a>(x: &'a One) { fs::read('\"') }",
        ),
    ];
    assert_eq!(circles_of(&files), [[""; 0]; 0]);
}

/// Lines of code outside of a method's folder that name it: a new one touches no more.
const MOST_MENTIONS: usize = 3;

/// Lines of `src`, outside of `home`, that name one of `words`.
fn mentions(home: &str, words: &[&str]) -> Vec<String> {
    let source = source();
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    let mut found = Vec::new();
    for path in files {
        let inside = path.strip_prefix(&source).unwrap().to_owned();
        if inside.starts_with(home) {
            continue;
        }
        let text = code(&path);
        let lines = text.lines().filter(|line| {
            let names = line.split(|c: char| !c.is_alphanumeric() && !"_-".contains(c));
            words
                .iter()
                .any(|word| names.clone().any(|name| name == *word))
        });
        found.extend(lines.map(|line| format!("{}: {}", inside.display(), line.trim())));
    }
    found
}

#[test]
fn a_technique_is_its_folder_and_a_line_that_registers_it() {
    let folder = source().join("approximation");
    let mut techniques = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if !path.is_dir() {
            continue;
        }
        techniques += 1;
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let words: Vec<String> = name
            .split('_')
            .map(|word| word[..1].to_uppercase() + &word[1..])
            .collect();
        let words = [name.clone(), name.replace('_', "-"), words.concat()];
        let words = words.each_ref().map(String::as_str);
        let found = mentions(&format!("approximation/{name}"), &words);
        assert!(!found.is_empty(), "{name} is registered nowhere");
        assert!(found.len() <= MOST_MENTIONS, "{}", found.join("\n"));
    }
    assert!(techniques > 0, "no technique was found");
}

#[test]
fn above_their_floor_references_are_named_in_the_room_of_methods_only() {
    let source = source();
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    let upper = ["study", "cli"];
    let mut found = Vec::new();
    for path in files {
        let inside = path.strip_prefix(&source).unwrap().to_owned();
        if !upper.iter().any(|room| inside.starts_with(room)) {
            continue;
        }
        let text = code(&path);
        let names = ["beams", "path", "photon_map", "full", "closed_form"];
        let named = names.map(|name| format!("reference::{name}"));
        let lines = text
            .lines()
            .filter(|line| named.iter().any(|name| line.contains(name)));
        found.extend(lines.map(|line| format!("{}: {}", inside.display(), line.trim())));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_counter_of_mentions_finds_them() {
    assert!(!mentions("approximation", &["TECHNIQUES"]).is_empty());
    assert!(mentions("", &["no-method-has-this-name"]).is_empty());
}
