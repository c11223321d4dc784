//! Tells the program what it is built from.
//!
//! - `NEPHROID_COMMIT`: the commit of this repository, with `-modified` appended if the program's source differs from
//!   it; in a package the commit from which the package was made; `unknown` elsewhere, as in an unpacked archive.
//! - `NEPHROID_SOURCE_HASH`: a hash of everything that can change a computed number. Films of a study are found again
//!   by it.
//!
//! The same source of the same commit gives the same texts: they hold nothing of the machine, the folder or the time.

use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The program's source. A change in other files leaves the program as it is. A commit alone changes none of these
/// files and builds nothing anew: the program names a commit that has its source, not always the last one.
const SOURCES: [&str; 4] = ["src", "build.rs", "Cargo.toml", "Cargo.lock"];

/// The file in which `cargo package` notes the commit.
const PACKAGED: &str = ".cargo_vcs_info.json";

fn main() -> io::Result<()> {
    // Cargo takes a named file that is missing for a change at every build, and a package may have no lock file.
    for source in SOURCES.iter().filter(|source| Path::new(source).exists()) {
        println!("cargo:rerun-if-changed={source}");
    }
    let commit = packaged().or_else(checked_out);
    println!(
        "cargo:rustc-env=NEPHROID_COMMIT={}",
        commit.as_deref().unwrap_or("unknown")
    );
    println!("cargo:rustc-env=NEPHROID_SOURCE_HASH={}", source_hash()?);
    Ok(())
}

/// A hash of the sources, the dependencies' versions (of `Cargo.lock`, or of the manifest alone in a package without
/// it) and the target.
///
/// The profile and the enabled features are left out: Rust's arithmetic gives the same bits at every level of
/// optimization, and no feature changes what is computed.
fn source_hash() -> io::Result<String> {
    let mut files = Vec::new();
    collect(Path::new("src"), &mut files)?;
    let manifests = ["Cargo.toml", "Cargo.lock"].map(PathBuf::from);
    files.extend(manifests.into_iter().filter(|path| path.exists()));
    // By text with one kind of slash: paths order alike on all systems.
    let mut files: Vec<(String, PathBuf)> = files
        .into_iter()
        .map(|path| (path.to_string_lossy().replace('\\', "/"), path))
        .collect();
    files.sort();
    let mut hasher = blake3::Hasher::new();
    // Each text with its length: no two lists of texts are the same bytes.
    let mut add = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    add(std::env::var("TARGET").unwrap_or_default().as_bytes());
    for (name, path) in files {
        add(name.as_bytes());
        add(&std::fs::read(path)?);
    }
    Ok(hasher.finalize().to_hex().to_string())
}

/// Adds all files in a folder and in the folders below it.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
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

/// The commit of the repository that this file belongs to, not of one in which an archive happens to be unpacked.
fn checked_out() -> Option<String> {
    git(&["ls-files", "--error-unmatch", "build.rs"])?;
    let commit = git(&["rev-parse", "HEAD"])?;
    let status = [&["status", "--porcelain", "--"], &SOURCES[..]].concat();
    let is_modified = git(&status).is_some();
    let modified = if is_modified { "-modified" } else { "" };
    Some(format!("{commit}{modified}"))
}

/// The output of git; `None` if git is missing, fails or prints nothing.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let said = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (output.status.success() && !said.is_empty()).then_some(said)
}
