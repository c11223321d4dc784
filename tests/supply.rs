//! What comes from outside: licences, sources, versions and the oldest compiler of all crates that are built.
//!
//! `cargo deny` would check the first three as well. It takes longer to compile than this program, which is
//! too long for every run of `.ci/run`; there it is asked for advisories if it is installed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Licences that let a program under MIT or Apache-2.0 be passed on with no more than a notice.
const LICENCES: [&str; 11] = [
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "CC0-1.0",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// Crates that are built in two versions, and why. An entry that is no duplicate any more fails the test.
const TWICE: [(&str, &str); 2] = [
    (
        "miniz_oxide",
        "png and exr ask for one version, flate2 for the next",
    ),
    (
        "syn",
        "derives are moving from version 2 to 3; no part of it is in the program",
    ),
];

/// What cargo says of the crates that this system builds, tests included, but nothing of the Python module.
///
/// Cargo would ask for the crates of all members of the workspace, and whoever builds the program alone has not fetched
/// those of Python. So it reads the manifest of this package in a folder where there is no workspace.
fn metadata() -> Value {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut manifest: toml::Table = fs::read_to_string(root.join("Cargo.toml"))
        .unwrap()
        .parse()
        .unwrap();
    for sources in ["workspace", "bin", "bench"] {
        manifest.remove(sources).unwrap();
    }
    let alone = tempfile::tempdir().unwrap();
    fs::create_dir(alone.path().join("src")).unwrap();
    fs::write(alone.path().join("src/lib.rs"), "").unwrap();
    fs::write(alone.path().join("Cargo.toml"), manifest.to_string()).unwrap();
    fs::copy(root.join("Cargo.lock"), alone.path().join("Cargo.lock")).unwrap();
    let rustc = Command::new("rustc").arg("-vV").output().unwrap();
    let rustc = String::from_utf8(rustc.stdout).unwrap();
    let host = rustc.lines().find_map(|line| line.strip_prefix("host: "));
    // Whoever builds this has all crates of this system; those of others would have to be fetched.
    let output = Command::new(std::env::var("CARGO").unwrap_or("cargo".to_owned()))
        .current_dir(alone.path())
        .args(["metadata", "--format-version", "1", "--offline"])
        .args(["--filter-platform", host.unwrap()])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    // The lock file lost Python's crates, and nothing else.
    let locked = locked();
    for package in built(&metadata) {
        let one = (text(package, "name"), text(package, "version"));
        assert!(
            locked.contains(&(one.0.to_owned(), one.1.to_owned())),
            "{one:?}"
        );
    }
    metadata
}

/// Names and versions of `Cargo.lock`.
fn locked() -> BTreeSet<(String, String)> {
    let lock = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.lock");
    let lock: toml::Table = fs::read_to_string(lock).unwrap().parse().unwrap();
    let packages = lock["package"].as_array().unwrap().iter();
    let all = packages.map(|package| {
        let [name, version] = ["name", "version"].map(|key| package[key].as_str().unwrap());
        (name.to_owned(), version.to_owned())
    });
    all.collect()
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_default()
}

/// The packages that are built, this one among them.
fn built(metadata: &Value) -> Vec<&Value> {
    let nodes = metadata["resolve"]["nodes"].as_array().unwrap();
    let ids: BTreeSet<&str> = nodes.iter().map(|node| text(node, "id")).collect();
    let packages = metadata["packages"].as_array().unwrap();
    let built: Vec<&Value> = packages
        .iter()
        .filter(|package| ids.contains(text(package, "id")))
        .collect();
    assert!(built.len() > 100, "{} packages", built.len());
    built
}

/// The package of this folder.
fn own(metadata: &Value) -> &Value {
    let root = text(&metadata["resolve"], "root");
    let packages = metadata["packages"].as_array().unwrap();
    let own = packages.iter().find(|package| text(package, "id") == root);
    own.unwrap()
}

/// True if an SPDX expression can be met by allowed licences alone. `AND` binds before `OR`; the old `/` is `OR`.
fn is_allowed(expression: &str) -> bool {
    let spaced = expression
        .replace('/', " OR ")
        .replace('(', " ( ")
        .replace(')', " ) ")
        .replace(" WITH ", "\u{1}");
    let words: Vec<String> = spaced
        .split_whitespace()
        .map(|word| word.replace('\u{1}', " WITH "))
        .collect();
    let mut at = 0;
    let is_allowed = either(&words, &mut at);
    is_allowed && at == words.len()
}

fn either(words: &[String], at: &mut usize) -> bool {
    let mut is_allowed = both(words, at);
    while words.get(*at).is_some_and(|word| word == "OR") {
        *at += 1;
        is_allowed |= both(words, at);
    }
    is_allowed
}

fn both(words: &[String], at: &mut usize) -> bool {
    let mut is_allowed = one(words, at);
    while words.get(*at).is_some_and(|word| word == "AND") {
        *at += 1;
        is_allowed &= one(words, at);
    }
    is_allowed
}

fn one(words: &[String], at: &mut usize) -> bool {
    let word = words.get(*at);
    // Beyond the end, too: an expression that stops short has not been read by then.
    *at += 1;
    let Some(word) = word else {
        return false;
    };
    if word != "(" {
        return LICENCES.contains(&word.as_str());
    }
    let is_allowed = either(words, at);
    let is_closed = words.get(*at).is_some_and(|word| word == ")");
    *at += 1;
    is_allowed && is_closed
}

#[test]
fn the_reader_of_licences_knows_their_grammar() {
    for good in [
        "MIT",
        "MIT/Apache-2.0",
        "GPL-3.0 OR MIT",
        "(GPL-3.0 OR MIT) AND Unicode-3.0",
        "Apache-2.0 WITH LLVM-exception OR GPL-2.0",
        "GPL-3.0 AND MIT OR Zlib",
    ] {
        assert!(is_allowed(good), "{good}");
    }
    for bad in [
        "",
        "GPL-3.0",
        "MIT AND GPL-3.0",
        "(GPL-3.0 OR LGPL-3.0) AND MIT",
        "MIT OR",
        "MIT Zlib",
        "(MIT",
        "Zlib WITH LLVM-exception",
    ] {
        assert!(!is_allowed(bad), "{bad}");
    }
}

#[test]
fn all_licences_let_the_program_be_passed_on() {
    let metadata = metadata();
    for package in built(&metadata) {
        let licence = text(package, "license");
        assert!(
            is_allowed(licence),
            "{} {} has the licence {licence:?}; allowed are {}",
            text(package, "name"),
            text(package, "version"),
            LICENCES.join(", ")
        );
    }
}

#[test]
fn all_crates_come_from_one_registry() {
    let metadata = metadata();
    for package in built(&metadata) {
        let source = text(package, "source");
        let is_own = text(package, "id") == text(&metadata["resolve"], "root");
        assert!(
            is_own || source == "registry+https://github.com/rust-lang/crates.io-index",
            "{} is from {source:?}",
            text(package, "name")
        );
    }
}

#[test]
fn no_crate_is_built_twice_without_a_reason() {
    let metadata = metadata();
    let mut versions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for package in built(&metadata) {
        let all = versions.entry(text(package, "name")).or_default();
        all.push(text(package, "version"));
    }
    versions.retain(|_, all| all.len() > 1);
    let twice: Vec<&str> = versions.keys().copied().collect();
    let allowed = TWICE.map(|(name, _)| name);
    assert_eq!(twice, allowed, "{versions:?}");
}

#[test]
fn no_crate_needs_a_newer_compiler_than_this_package_says() {
    let metadata = metadata();
    let version = |package: &Value| -> Vec<u32> {
        let parts = text(package, "rust_version").split('.');
        let mut parts: Vec<u32> = parts.filter_map(|part| part.parse().ok()).collect();
        parts.resize(3, 0);
        parts
    };
    let own = version(own(&metadata));
    assert!(own[1] > 0, "Cargo.toml has no rust-version");
    for package in built(&metadata) {
        let needed = version(package);
        assert!(
            needed <= own,
            "{} needs Rust {needed:?}",
            text(package, "name")
        );
    }
}

/// Each direct dependency is named once with its purpose, and nothing else is.
#[test]
fn the_map_says_why_each_dependency_is_there() {
    let map = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md"));
    let map = map.unwrap();
    let (_, section) = map.split_once("\n## Dependencies\n").unwrap();
    let section = section.split("\n## ").next().unwrap();
    let quoted = |text: &str| -> Vec<String> {
        let parts = text.split('`').skip(1).step_by(2);
        parts.map(str::to_owned).collect()
    };
    let (mut named, mut for_tests) = (BTreeSet::new(), BTreeSet::new());
    for line in section.lines() {
        let mut columns = line.trim_matches('|').split('|');
        if let (true, Some(names), Some(purpose)) =
            (line.starts_with("| `"), columns.next(), columns.next())
        {
            assert!(purpose.trim().len() > 5, "no purpose: {line}");
            // Rooms are in brackets.
            named.extend(quoted(names.split('[').next().unwrap()));
        }
    }
    if let Some((_, rest)) = section.split_once("For tests alone: ") {
        let sentence = rest.split("no dependencies").next().unwrap();
        for_tests.extend(quoted(sentence));
    }
    let metadata = metadata();
    let mut needed = BTreeSet::new();
    for dependency in own(&metadata)["dependencies"].as_array().unwrap() {
        let name = text(dependency, "name").to_owned();
        match text(dependency, "kind") {
            "dev" => assert!(
                for_tests.contains(&name) || named.contains(&name),
                "ARCHITECTURE.md does not say why {name} is there"
            ),
            _ => _ = needed.insert(name),
        }
    }
    assert_eq!(
        named, needed,
        "the table of ARCHITECTURE.md and Cargo.toml differ"
    );
}

/// The files that a package would have.
fn packaged() -> BTreeSet<String> {
    let output = Command::new(std::env::var("CARGO").unwrap_or("cargo".to_owned()))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["package", "--list", "--allow-dirty", "--offline"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let list = String::from_utf8(output.stdout).unwrap();
    list.lines().map(|line| line.replace('\\', "/")).collect()
}

/// All files below a folder.
fn below(folder: &str, files: &mut Vec<String>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for entry in fs::read_dir(root.join(folder)).unwrap() {
        let entry = entry.unwrap();
        let name = format!("{folder}/{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            below(&name, files);
        } else {
            files.push(name);
        }
    }
}

#[test]
fn a_package_has_all_that_builds_it_and_no_tests() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let packaged = packaged();
    let mut needed = Vec::new();
    below("src", &mut needed);
    for name in ["README.md", "build.rs", "Cargo.lock", "CITATION.cff"] {
        needed.push(name.to_owned());
    }
    // Files that the source includes, wherever they are.
    for file in needed.clone() {
        let Ok(source) = fs::read_to_string(root.join(&file)) else {
            continue;
        };
        for name in source.split("include_str!(\"").skip(1) {
            let name = name.split('"').next().unwrap();
            let path = root.join(&file).parent().unwrap().join(name);
            let path = path.canonicalize().unwrap();
            let name = path.strip_prefix(root.canonicalize().unwrap()).unwrap();
            needed.push(name.to_str().unwrap().replace('\\', "/"));
        }
    }
    let mut scenes = Vec::new();
    below("scenes", &mut scenes);
    needed.extend(scenes.into_iter().filter(|name| name.ends_with(".xml")));
    // What README shows.
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    for picture in readme.split("![").skip(1) {
        let (_, link) = picture.split_once("](").unwrap();
        needed.push(link.split(')').next().unwrap().to_owned());
    }
    assert!(needed.iter().any(|name| name == "docs/coffee-cup.png"));
    for name in &needed {
        assert!(packaged.contains(name), "the package lacks {name}");
    }
    let is_odd = |name: &&String| {
        let folders = ["tests/", "benches/", "fuzz/", "python/", "."];
        let is_below = folders.iter().any(|folder| name.starts_with(folder));
        (is_below && *name != ".cargo_vcs_info.json") || name.ends_with(".ply")
    };
    assert_eq!(packaged.iter().find(is_odd), None);
    let sizes = packaged.iter().map(|name| root.join(name).metadata());
    let bytes: u64 = sizes.filter_map(|one| Some(one.ok()?.len())).sum();
    assert!(bytes < 6_000_000, "{bytes} bytes");
}

/// Recipes that build the program elsewhere take a compiler that is new enough, and files that are there.
#[test]
fn recipes_name_what_there_is() {
    let read = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
        fs::read_to_string(path).unwrap()
    };
    let metadata = metadata();
    let version = text(own(&metadata), "rust_version");
    let container = read("Containerfile");
    assert!(
        container.contains(&format!("rust:{version}-")),
        "{container}"
    );
    // A folder that the build reads is left out of no container.
    let ignored = read(".dockerignore");
    for name in ["src", "scenes", "python", "build.rs", "README.md", ".git"] {
        assert!(!ignored.lines().any(|line| line == name), "{name}");
    }
    assert!(read("action.yml").contains(".github/validate.sh"));
    let citation = read("CITATION.cff");
    let version = format!("\nversion: {}\n", text(own(&metadata), "version"));
    assert!(citation.contains(&version), "{citation}");
    for manifest in ["Cargo.toml", "python/Cargo.toml"] {
        let version = version.replace(": ", " = \"").replacen('\n', "", 1);
        let version = format!("{}\"", version.trim_end());
        assert!(read(manifest).contains(&version), "{manifest}: {version}");
    }
}
