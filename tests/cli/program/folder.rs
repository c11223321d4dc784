//! Runs of the program in a folder of their own.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;

pub fn nephroid(arguments: &[&str]) -> Output {
    Command::cargo_bin("nephroid")
        .unwrap()
        .args(arguments)
        .output()
        .unwrap()
}

pub fn scene(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name)
        .display()
        .to_string()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

pub struct Folder(pub tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, content: &str) -> String {
        let path = self.path(name);
        std::fs::write(&path, content).unwrap();
        path.display().to_string()
    }
}
