//! What is made of a study by itself, on any machine.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use nephroid::internals::mitsuba;
use nephroid::internals::study::StudyFile;
use nephroid::internals::study::file::StudyWishes;
use nephroid::internals::study::validation::{
    News, Report, Unit, Watcher, units, validate_scene, validate_unit,
};
use nephroid::{Context, Scene};

use super::folder::Folder;

/// Files by their names.
type Files = BTreeMap<String, Vec<u8>>;

struct Deaf;

impl Watcher for Deaf {
    fn hear(&mut self, _news: News) {}
}

fn files(folder: &Path) -> Files {
    let files = std::fs::read_dir(folder).unwrap();
    let files = files.map(|file| file.unwrap());
    files
        .map(|file| {
            let name = file.file_name().into_string().unwrap();
            (name, std::fs::read(file.path()).unwrap())
        })
        .collect()
}

/// A study of a caustic map, which is attributed, and of photons.
fn study(folder: &Folder, truth: &str) -> (Arc<Scene>, StudyFile) {
    let rest = "[[method]]\nmethod = \"caustic-map\"\nphotons = 32\nmap = 32\n\
        [[method]]\nmethod = \"photons\"\nphotons = 1024\n";
    folder.study("s.toml", &format!("[truth]\n{truth}\n{rest}"));
    let file = StudyFile::wanted(&folder.path("s.toml"), &StudyWishes::default()).unwrap();
    let scene = mitsuba::load(&file.scene, &file.define).unwrap();
    (Arc::new(scene), file)
}

/// Makes a unit in a folder that has what it needs alone. Returns what is new there.
fn made(scene: &Arc<Scene>, file: &StudyFile, unit: &Unit, given: &Files) -> Files {
    let folder = tempfile::tempdir().unwrap();
    let runs = folder.path().join("runs");
    std::fs::create_dir(&runs).unwrap();
    for (name, contents) in given {
        std::fs::write(runs.join(name), contents).unwrap();
    }
    let (scene, context) = (Arc::clone(scene), Context::default());
    let is_made = validate_unit(scene, file, &unit.key, folder.path(), &context, &mut Deaf);
    assert!(is_made.unwrap());
    let mut found = files(&runs);
    for (name, contents) in given {
        assert_eq!(found.remove(name).as_ref(), Some(contents), "{name}");
    }
    found
}

/// Makes all units, each in a folder of its own, and then the report of their files.
fn report(scene: &Arc<Scene>, file: &StudyFile, of_unit: impl Fn(&Unit, &Files)) -> Report {
    let folder = tempfile::tempdir().unwrap();
    let all = units(scene, file, folder.path()).unwrap();
    let mut by_key: BTreeMap<&str, Files> = BTreeMap::new();
    for unit in &all {
        assert!(!unit.is_kept);
        let needed = unit
            .needs
            .iter()
            .flat_map(|key| by_key[key.as_str()].clone());
        let new = made(scene, file, unit, &needed.collect());
        of_unit(unit, &new);
        for (name, contents) in &new {
            std::fs::write(folder.path().join("runs").join(name), contents).unwrap();
        }
        by_key.insert(&unit.key, new);
    }
    let urgent: Vec<usize> = all.iter().map(|unit| unit.urgency).collect();
    let needs: Vec<usize> = all.iter().map(|unit| unit.needs.len()).collect();
    let others = all.len() - 4;
    // The truth, on which the first run waits, on which its other parts do; and two runs.
    assert_eq!(urgent, [&[3, 2][..], &vec![1; others], &[0, 0]].concat());
    assert_eq!(needs, [&[0, 1][..], &vec![2; others], &[0, 0]].concat());
    let (scene, context) = (Arc::clone(scene), Context::default());
    let found = validate_scene(scene, file, folder.path(), &context, &mut Deaf).unwrap();
    found.report.unwrap()
}

fn text(report: &Report) -> String {
    match report {
        Report::One(found) => serde_json::to_string(&found.0).unwrap(),
        Report::Poses(_) => panic!("a study without poses has one report"),
    }
}

#[test]
fn a_unit_makes_its_own_files_alone_from_those_that_it_needs() {
    let folder = Folder::new();
    let (scene, file) = study(&folder, "method = \"beams\"\nerror = \"3%\"");
    let found = report(&scene, &file, |unit, new| {
        assert!(
            new.keys().eq(&sorted(&unit.files)),
            "{unit:?}: {:?}",
            new.keys()
        );
    });
    let to = folder.path("whole");
    let context = Context::default();
    let whole = validate_scene(scene, &file, &to, &context, &mut Deaf).unwrap();
    let whole = text(&whole.report.unwrap());
    assert_eq!(text(&found), whole);
    assert!(whole.contains("residual"), "it is attributed");
}

fn sorted(names: &[String]) -> Vec<String> {
    let mut names = names.to_vec();
    names.sort();
    names
}

/// Photons without layers know no light by its path.
#[test]
fn a_reason_why_nothing_is_attributed_is_all_that_its_parts_make() {
    let folder = Folder::new();
    let (scene, file) = study(&folder, "method = \"photons\"\nphotons = 4096\nlayers = 0");
    let found = report(&scene, &file, |unit, new| {
        let is_other_part = unit.urgency == 1;
        assert_eq!(new.is_empty(), is_other_part, "{unit:?}");
    });
    let found = text(&found);
    assert!(found.contains("no error of stages: "), "{found}");
    assert!(found.contains("has no layer LTTD"), "{found}");
}
