//! Tells the program which commit it is built from (`NEPHROID_COMMIT`): that of this repository, `-modified` appended where the
//! program's source differs from it; in a package that of which it was made; `unknown` elsewhere, as in an unpacked archive.
//!
//! The same source of the same commit gives the same text: nothing of the machine or the time is in it.

use std::process::Command;

/// What the program is made of: a change in other files leaves it what it is. A commit alone changes none of them, and so builds
/// nothing anew: the program names a commit (with what was modified then) that has its source, not always the last one.
const SOURCES: [&str; 4] = ["src", "build.rs", "Cargo.toml", "Cargo.lock"];

/// What `cargo package` writes into a package.
const PACKAGED: &str = ".cargo_vcs_info.json";

fn main() {
    for source in SOURCES {
        println!("cargo:rerun-if-changed={source}");
    }
    let commit = packaged().or_else(checked_out);
    println!(
        "cargo:rustc-env=NEPHROID_COMMIT={}",
        commit.as_deref().unwrap_or("unknown")
    );
}

/// The commit of a package: the text of its `sha1`.
fn packaged() -> Option<String> {
    let info = std::fs::read_to_string(PACKAGED).ok()?;
    let (_, rest) = info.split_once("\"sha1\"")?;
    let hash = rest.split('"').nth(1)?;
    let is_hash = !hash.is_empty() && hash.chars().all(|c| c.is_ascii_hexdigit());
    let modified = if info.contains("\"dirty\": true") {
        "-modified"
    } else {
        ""
    };
    is_hash.then(|| format!("{hash}{modified}"))
}

/// The commit of a repository that this file belongs to: not of one that an archive happens to be unpacked in.
fn checked_out() -> Option<String> {
    git(&["ls-files", "--error-unmatch", "build.rs"])?;
    let commit = git(&["rev-parse", "HEAD"])?;
    let status = [&["status", "--porcelain", "--"], &SOURCES[..]].concat();
    let is_modified = git(&status).is_some();
    let modified = if is_modified { "-modified" } else { "" };
    Some(format!("{commit}{modified}"))
}

/// What git says, if it is there, succeeds and says anything.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let said = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (output.status.success() && !said.is_empty()).then_some(said)
}
