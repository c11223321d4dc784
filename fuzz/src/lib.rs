//! Shared parts of the targets: a file of the bytes to be tried, and a scene file that names it.
//!
//! `cargo +nightly fuzz run ply -- -max_len=65536 -timeout=10 -rss_limit_mb=1024`, in the folder above;
//! `-timeout` and `-rss_limit_mb` are the bars of time and memory that `tests/hostile/` derives.

use std::path::PathBuf;
use std::sync::OnceLock;

use nephroid::internals::mitsuba;
use tempfile::TempDir;

/// Writes `bytes` as the file `name` of a folder that lasts as long as the process; returns its path.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| TempDir::new().expect("a temporary folder"));
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a file in a temporary folder");
    path
}

/// Writes `bytes` as the file `name`, and loads a scene: the text `scene` as the file `scene.xml` beside it,
/// or the file itself if there is none. Errors are fine: the claim is that it returns.
pub fn load(name: &str, bytes: &[u8], scene: Option<&str>) {
    let written = file(name, bytes);
    let scene = scene.map_or(written, |text| file("scene.xml", text.as_bytes()));
    drop(mitsuba::load(&scene, &[]));
}

/// Loads `bytes` as a mesh by this plugin.
pub fn load_mesh(plugin: &str, bytes: &[u8]) {
    let scene = format!(
        "<scene version=\"3.0.0\"><shape type=\"{plugin}\"><string name=\"filename\" value=\"mesh\"/></shape></scene>"
    );
    load("mesh", bytes, Some(&scene));
}
