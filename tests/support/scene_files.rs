//! Scene files in a temporary folder.

use std::fs;
use std::path::{Path, PathBuf};

use nephroid::internals::mitsuba::{LoadError, load_parts};
use nephroid::internals::scene::SceneParts;
use tempfile::TempDir;

/// A folder that is gone when the test is over.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file, with the folders it needs.
    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, contents).unwrap();
        path
    }

    /// Loads a file; errors without the folder's path.
    pub fn load(&self, name: &str, parameters: &[(&str, &str)]) -> Result<SceneParts, String> {
        let parameters: Vec<_> = parameters
            .iter()
            .map(|(a, b)| ((*a).to_owned(), (*b).to_owned()))
            .collect();
        load_parts(&self.path().join(name), &parameters).map_err(|error| self.strip(&error))
    }

    fn strip(&self, error: &LoadError) -> String {
        let folder = format!("{}/", self.path().display());
        error.to_string().replace(&folder, "")
    }
}

/// Loads a scene of version 3 with these elements, each in its own line from line 2 on.
pub fn scene(elements: &str) -> Result<SceneParts, String> {
    scene_of_version("3.0.0", elements)
}

/// Loads a scene with these elements, each in its own line from line 2 on.
pub fn scene_of_version(version: &str, elements: &str) -> Result<SceneParts, String> {
    let folder = Folder::new();
    folder.write(
        "scene.xml",
        format!("<scene version=\"{version}\">\n{elements}\n</scene>\n"),
    );
    folder.load("scene.xml", &[])
}

/// The error of a scene that must not load.
pub fn error(elements: &str) -> String {
    scene(elements).expect_err("the scene loads")
}

/// Half a unit in the sixth digit, for numbers that Mitsuba prints so.
pub fn assert_close(found: f64, mitsuba: f64) {
    assert!(
        (found - mitsuba).abs() <= 5e-6 * mitsuba.abs(),
        "{found} is not {mitsuba}"
    );
}
