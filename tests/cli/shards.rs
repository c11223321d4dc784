//! `nephroid render --shard` and `nephroid merge`, of each method whose runs can be divided.

use std::path::Path;

use assert_cmd::Command;
use nephroid::internals::film::{Image, exr};

/// A glass ball between a point light and a floor, and a camera of three bands of rows.
const SCENE: &str = "<scene version=\"3.0.0\"><sensor type=\"perspective\" id=\"eye\"><float name=\"fov\" value=\"40\"/>\
    <transform name=\"to_world\"><lookat origin=\"0, -3, 1\" target=\"0, 0, 0\" up=\"0, 0, 1\"/></transform>\
    <film type=\"hdrfilm\"><integer name=\"width\" value=\"20\"/><integer name=\"height\" value=\"40\"/></film></sensor>\
    <shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/><translate z=\"-0.5\"/></transform>\
    <sensor type=\"irradiancemeter\" id=\"floor\"/></shape>\
    <shape type=\"sphere\"><float name=\"radius\" value=\"0.4\"/><bsdf type=\"dielectric\"/></shape>\
    <emitter type=\"point\"><point name=\"position\" value=\"0, 0, 3\"/></emitter></scene>";

fn run(folder: &Path, arguments: &str) {
    let words = arguments.split(' ').filter(|word| !word.is_empty());
    let output = Command::cargo_bin("nephroid")
        .unwrap()
        .current_dir(folder)
        .args(words)
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
            "--sensor eye --photons 8192 --replicates 2 --map-photons 1024 --set seen=anyhow",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        std::fs::write(folder.join("scene.xml"), SCENE).unwrap();
        run(
            folder,
            &format!("render scene.xml --method {method} {settings} -o whole.exr"),
        );
        for part in 1..=3 {
            let shard = format!("--shard {part}/3 -o {part}.shard");
            run(
                folder,
                &format!("render scene.xml --method {method} {settings} {shard}"),
            );
        }
        // The parts know the method, and how much work the run has.
        let settings = settings
            .replace("--spp 4 ", "")
            .replace("--photons 8192 ", "");
        run(
            folder,
            &format!("merge scene.xml {settings} 2.shard 3.shard 1.shard -o merged.exr"),
        );
        let [whole, merged] = ["whole.exr", "merged.exr"].map(|name| image(folder, name));
        assert!(whole.channels.len() > 6, "{method}");
        assert!(whole == merged, "{method}");
    }
}
