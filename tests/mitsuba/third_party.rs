//! Third-party scene files: each loads, or fails with an error that names a place and a reason.
//!
//! The files lie beside this repository, in `../shared/scenes`, and are not part of it; where the
//! folder is absent, the test says so and does nothing.

use std::fs;
use std::path::{Path, PathBuf};

use nephroid::internals::mitsuba::{LoadError, load};

/// Path below the folder, and what becomes of the file.
const OUTCOMES: &str = include_str!("third_party.txt");

/// Least number of the files that must load.
const MUST_LOAD: usize = 59;

#[test]
fn every_third_party_scene_does_what_the_table_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    if !folder.is_dir() {
        println!("skipped: there is no folder {}", folder.display());
        return;
    }
    let mut files = Vec::new();
    collect(&folder, &mut files);
    files.sort();
    let mut loaded = 0;
    let mut found = String::new();
    for file in &files {
        let outcome = match load(file, &[]) {
            Ok(scene) => {
                // Files without shapes are parts to be included by others.
                loaded += usize::from(!scene.objects().is_empty());
                format!(
                    "loads: {} shapes, {} emitters, {} sensors",
                    scene.objects().len(),
                    scene.emitters().len(),
                    scene.sensors().len()
                )
            }
            Err(error) => essence(&error, &folder),
        };
        found += &format!("{}: {outcome}\n", below(file, &folder));
    }
    println!("{loaded} of {} files load with shapes", files.len());
    let changed: Vec<&str> = found
        .lines()
        .filter(|line| !OUTCOMES.lines().any(|known| known == *line))
        .collect();
    assert!(
        changed.is_empty() && found.lines().count() == OUTCOMES.lines().count(),
        "changed outcomes:\n{}",
        changed.join("\n")
    );
    assert!(loaded >= MUST_LOAD);
}

/// Scenes for comparisons with Mitsuba at low resolution.
const QUICK: &str = include_str!("third_party_quick.txt");

#[test]
fn every_scene_chosen_for_comparisons_loads() {
    let files = QUICK
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(" | ").next().unwrap_or_default());
    let mut count = 0;
    for file in files {
        let loads = format!("{file}: loads: ");
        assert!(
            OUTCOMES.lines().any(|line| line.starts_with(&loads)),
            "{file}"
        );
        count += 1;
    }
    assert!(count >= 15, "{count}");
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "xml") {
            files.push(path);
        }
    }
}

fn below(path: &Path, folder: &Path) -> String {
    path.strip_prefix(folder)
        .unwrap_or(path)
        .display()
        .to_string()
}

/// Place, plugin and parameter; not the lists of what is allowed. Panics without a place.
fn essence(error: &LoadError, folder: &Path) -> String {
    assert!(error.at.line > 0 && error.at.column > 0, "{error}");
    let message = error.message.replace(&format!("{}/", folder.display()), "");
    let end = [";", " (", ": give"]
        .iter()
        .filter_map(|mark| message.find(mark))
        .min();
    let brief = &message[..end.unwrap_or(message.len())];
    format!(
        "{}:{}:{}: {}",
        below(&error.at.file, folder),
        error.at.line,
        error.at.column,
        brief.trim_end()
    )
}
