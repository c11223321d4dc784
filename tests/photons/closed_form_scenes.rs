//! The bundled scenes' files are what the generator makes.

use std::fs;
use std::path::Path;

use nephroid::internals::generate::{GenerateOptions, SCENES, generate, scene_names};

#[test]
fn every_bundled_file_is_reproduced_byte_for_byte() {
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let folder = tempfile::tempdir().unwrap();
    let mut generated = Vec::new();
    for name in scene_names() {
        for written in generate(name, folder.path(), GenerateOptions::default()).unwrap() {
            let file = written.file_name().unwrap().to_owned();
            let expected = fs::read(bundled.join(&file)).unwrap();
            assert!(
                expected == fs::read(&written).unwrap(),
                "{} differs",
                file.display()
            );
            generated.push(file);
        }
    }
    // And nothing else lies in the folder that a scene could use.
    for entry in fs::read_dir(bundled).unwrap() {
        let file = entry.unwrap().file_name();
        let known = generated.contains(&file) || file == "README.md";
        assert!(known, "{} is made by no generator", file.display());
    }
}

#[test]
fn all_bundled_meshes_together_take_less_than_6_megabytes() {
    let sizes = SCENES
        .iter()
        .flat_map(|scene| scene.contents(1))
        .filter(|(name, _)| name.ends_with(".ply"))
        .map(|(_, bytes)| bytes.len());
    assert!(sizes.sum::<usize>() < 6_000_000);
}
