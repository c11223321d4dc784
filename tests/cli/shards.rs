//! `nephroid render --shard` and `nephroid merge`, of each method whose runs can be divided.

use std::path::Path;
use std::process::Output;

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

fn output(folder: &Path, arguments: &str) -> Output {
    let words = arguments.split(' ').filter(|word| !word.is_empty());
    let mut program = Command::cargo_bin("nephroid").unwrap();
    program.current_dir(folder).args(words).output().unwrap()
}

fn run(folder: &Path, arguments: &str) {
    let output = output(folder, arguments);
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

#[test]
fn a_merge_that_cannot_be_says_of_which_file_and_why_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("scene.xml"), SCENE).unwrap();
    for (method, name) in [
        ("path --spp 2", "path"),
        ("photon-map --sensor eye --photons 64", "map"),
    ] {
        for part in [1, 2] {
            let file = format!("--shard {part}/2 -o {name}{part}.shard");
            run(
                folder,
                &format!("render scene.xml --method {method} --replicates 2 {file}"),
            );
        }
    }
    let whole = std::fs::read(folder.join("path2.shard")).unwrap();
    std::fs::write(folder.join("cut.shard"), &whole[..whole.len() / 2]).unwrap();
    for (arguments, words) in [
        ("path1.shard nothing.shard", &["nothing.shard"][..]),
        (
            "path1.shard scene.xml",
            &["scene.xml", "its first line is not"],
        ),
        ("path1.shard cut.shard", &["cut.shard"]),
        (
            "path1.shard map2.shard",
            &["map2.shard", "the method is path here and photon-map there"],
        ),
        ("path1.shard", &["given were [1]"]),
        ("path1.shard path1.shard", &["given were [1, 1]"]),
        (
            "path1.shard path2.shard --seed 9",
            &["the list of settings"],
        ),
        (
            "path1.shard path2.shard --map-photons 64",
            &["--map-photons", "photon-map"],
        ),
        (
            "path1.shard path2.shard --sensor floor",
            &["paths start at cameras"],
        ),
        (
            "path1.shard path2.shard --filter box",
            &["the sensor is eye"],
        ),
    ] {
        let output = output(
            folder,
            &format!("merge scene.xml --replicates 2 {arguments} -o out.exr"),
        );
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
        for word in words {
            assert!(said.contains(word), "{arguments}: {said}");
        }
        assert!(!folder.join("out.exr").exists(), "{arguments}");
    }
}
