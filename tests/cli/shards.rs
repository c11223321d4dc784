//! `nephroid render --shard` and `nephroid merge`, of each method whose runs can be divided.

use std::path::Path;

use assert_cmd::Command;
use nephroid::internals::film::{Image, exr};

/// A glass ball behind a pane, over a floor.
const SCENE: &str = "glass-ball-behind-pane";

fn run(folder: &Path, arguments: &str) {
    let scene = crate::support::bundled_file(SCENE);
    let scene = scene.to_str().unwrap();
    let words = arguments.split(' ').filter(|word| !word.is_empty());
    let output = Command::cargo_bin("nephroid")
        .unwrap()
        .current_dir(folder)
        .args(words.map(|word| if word == "SCENE" { scene } else { word }))
        .args(["-D", "size=40"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments}: {said}");
}

/// An image but for what its run took.
fn image(folder: &Path, name: &str) -> Image {
    let mut image = exr::read(&folder.join(name)).unwrap();
    image.metadata.retain(|(key, _)| key != "timing");
    image
}

#[test]
fn shards_of_paths_and_photon_maps_merge_to_the_file_of_the_whole_run() {
    for (method, settings) in [
        ("path", "--spp 4 --replicates 2 --seed 3"),
        (
            "photon-map",
            "--sensor camera --photons 8192 --replicates 2 --map-photons 1024 --set seen=anyhow",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        run(
            folder,
            &format!("render SCENE --method {method} {settings} -o whole.exr"),
        );
        for part in 1..=3 {
            let shard = format!("--shard {part}/3 -o {part}.shard");
            run(
                folder,
                &format!("render SCENE --method {method} {settings} {shard}"),
            );
        }
        // The parts know the method, and how much work the run has.
        let settings = settings
            .replace("--spp 4 ", "")
            .replace("--photons 8192 ", "");
        run(
            folder,
            &format!("merge SCENE {settings} 2.shard 3.shard 1.shard -o merged.exr"),
        );
        let [whole, merged] = ["whole.exr", "merged.exr"].map(|name| image(folder, name));
        assert!(whole.channels.len() > 6, "{method}");
        assert!(whole == merged, "{method}");
    }
}
