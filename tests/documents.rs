//! The documents say what the program does: tables of settings, and links.

use std::fs;
use std::path::{Path, PathBuf};

use nephroid::Method;
use nephroid::internals::method::table::markdown;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn the_manual_has_each_methods_settings_as_the_program_knows_them() {
    let manual = read(&root().join("docs/methods.md"));
    for name in Method::names() {
        let begin = format!("<!-- settings: {name} -->\n\n");
        let block = manual.split_once(&begin).map(|(_, rest)| rest);
        let block = block.and_then(|rest| rest.split_once("\n<!-- end -->"));
        let table = block.map_or("", |(table, _)| table);
        assert_eq!(
            table,
            markdown(name),
            "docs/methods.md is not up to date with the settings of {name}: cargo run --example documents"
        );
    }
}

/// README.md, the map, the changes, and all manuals.
fn documents() -> Vec<PathBuf> {
    let mut paths = ["README.md", "ARCHITECTURE.md", "scenes/README.md"]
        .map(|name| root().join(name))
        .to_vec();
    for entry in fs::read_dir(root().join("docs")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "md") {
            paths.push(path);
        }
    }
    paths.sort();
    paths
}

/// The lines of a document outside its blocks of code.
fn prose(text: &str) -> Vec<&str> {
    let mut is_code = false;
    let lines = text.lines().filter(|line| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    });
    lines.collect()
}

/// A heading's anchor, as GitHub makes it.
fn anchor(heading: &str) -> String {
    let letters = heading.trim_start_matches('#').trim().to_lowercase();
    letters
        .chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

#[test]
fn every_link_of_the_documents_leads_to_a_file_and_a_heading_of_it() {
    let mut links = 0;
    for document in documents() {
        let text = read(&document);
        let prose = prose(&text).join(" ");
        for link in prose.split("](").skip(1) {
            let link = link.split(')').next().unwrap().trim();
            if link.contains("://") {
                continue;
            }
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = match file {
                "" => document.clone(),
                file => document.parent().unwrap().join(file),
            };
            let place = format!("{}: {link}", document.display());
            assert!(target.exists(), "{place}: no such file");
            if !heading.is_empty() {
                let there = read(&target);
                let lines = self::prose(&there).into_iter();
                let mut headings = lines.filter(|line| line.starts_with('#'));
                assert!(
                    headings.any(|line| anchor(line) == heading),
                    "{place}: no such heading"
                );
            }
            links += 1;
        }
    }
    assert!(links > 40, "{links} links were found");
}

#[test]
fn every_mutation_finds_its_text_once_and_changes_it() {
    let list: toml::Table = read(&root().join("tests/mutations/mutations.toml"))
        .parse()
        .unwrap();
    let mutations = list["mutation"].as_array().unwrap();
    assert!(!mutations.is_empty());
    for mutation in mutations {
        let text = |key: &str| mutation[key].as_str().unwrap();
        let found = read(&root().join(text("file")))
            .matches(text("old"))
            .count();
        assert_eq!(
            found,
            1,
            "{}: {:?} in {}",
            text("name"),
            text("old"),
            text("file")
        );
        assert_ne!(text("old"), text("new"), "{}", text("name"));
    }
}
