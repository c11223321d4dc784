//! What the targets share: a scene file that names the bytes to be tried.
//!
//! `cargo +nightly fuzz run ply -- -max_len=65536 -timeout=10 -rss_limit_mb=1024`, in the folder above; `-timeout` and `-rss_limit_mb`
//! are the bars of time and memory that `tests/extremes_hostile.rs` derives.

use std::path::Path;
use std::sync::OnceLock;

use nephroid::mitsuba;
use tempfile::TempDir;

/// Writes `bytes` as the file `name` of a folder that lasts as long as the process, and loads the scene
/// file `scene.xml` of it. Errors are fine: that it returns is the claim.
pub fn load(name: &str, bytes: &[u8], scene: Option<&str>) {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| TempDir::new().expect("a temporary folder"));
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path().join(name), bytes).expect("a file in a temporary folder");
    };
    write(name, bytes);
    if let Some(scene) = scene {
        write("scene.xml", scene.as_bytes());
    }
    drop(mitsuba::load(Path::new(&folder.path().join("scene.xml")), &[]));
}

/// Loads `bytes` as a mesh by this plugin.
pub fn load_mesh(plugin: &str, bytes: &[u8]) {
    let scene = format!(
        "<scene version=\"3.0.0\"><shape type=\"{plugin}\"><string name=\"filename\" value=\"mesh\"/></shape></scene>"
    );
    load("mesh", bytes, Some(&scene));
}
