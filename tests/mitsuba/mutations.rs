//! No bytes make a reader panic: files of scenes, meshes, films and images, cut, spliced and overwritten at
//! random.

use std::cell::RefCell;

use flate2::Compression;
use glam::DVec3;
use nephroid::internals::film::bitmap::{Bitmap, BitmapEncoding};
use nephroid::internals::film::exr;
use nephroid::internals::geometry::MeshParts;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};

use crate::support;
use crate::support::mutation::{
    PACKINGS, film, mutate, mutations, one_or_more_mutations, serialized_contents,
};
use crate::support::scene_files::Folder;

/// Loading the result may fail or not; that it returns is the test.
const CASES: u32 = 400;

const SCENE: &str = r##"<?xml version="1.0"?>
<!-- everything the reader knows --><scene version="0.6.0"><default name="n" value="2"/>
<integrator type="path"><integer name="maxDepth" value="$n"/></integrator>
<sensor type="perspective"><float name="fov" value="40"/><transform name="toWorld"><lookat origin="0,0,5" target="0 0 0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="16"/><rfilter type="box"/></film><sampler type="independent"/></sensor>
<bsdf type="twosided" id="m"><bsdf type="conductor"><string name="material" value="Al"/></bsdf></bsdf><alias id="m" as="mirror"/>
<shape type="cube"><ref id="mirror"/><transform name="toWorld"><scale value="2"/><rotate x="1" angle="30"/><translate z="1"/>
<matrix value="1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"/></transform></shape>
<shape type="sphere"><bsdf type="dielectric"><string name="intIOR" value="water"/><rgb name="specularReflectance" value="#ff8000"/></bsdf></shape>
<shape type="rectangle"><emitter type="area"><spectrum name="radiance" value="400:1, 700:2"/></emitter><sensor type="irradiancemeter"/></shape>
<shape type="shapegroup" id="g"><shape type="disk"/></shape><shape type="instance"><ref id="g"/></shape>
<emitter type="spot"><rgb name="intensity" value="1"/></emitter>
<emitter type="directional"><vector name="direction" x="0" y="-1" z="0"/></emitter></scene>
"##;

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\ng a\nf 1/1/1 2/2/1 3/1/1 4//1\nf -4 -3 -2\n";

const ASCII_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    property float nx\nproperty float ny\nproperty float nz\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n4 0 1 2 3\n";

fn binary_ply() -> Vec<u8> {
    let header = ASCII_PLY
        .split_inclusive("end_header\n")
        .next()
        .unwrap_or_default();
    let mut bytes = header.replace("ascii", "binary_little_endian").into_bytes();
    for corner in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]] {
        for number in [corner[0], corner[1], 0.0, 0.0, 0.0, 1.0] {
            bytes.extend(number.to_le_bytes());
        }
    }
    bytes.push(4);
    (0..4_i32).for_each(|index| bytes.extend(index.to_le_bytes()));
    bytes
}

/// One mesh of a triangle; `stored` without compression, so that a changed byte reaches the reader.
fn serialized() -> Vec<u8> {
    let triangle = MeshParts {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2]],
        ..MeshParts::default()
    };
    support::mutation::serialized(&serialized_contents(&triangle), Compression::none())
}

fn load_mesh(plugin: &str, bytes: &[u8]) -> Result<(), String> {
    let folder = Folder::new();
    folder.write("mesh", bytes);
    let text = format!(
        "<scene version=\"3.0.0\"><shape type=\"{plugin}\"><string name=\"filename\" value=\"mesh\"/></shape></scene>"
    );
    folder.write("scene.xml", text);
    folder.load("scene.xml", &[]).map(|_| ())
}

#[test]
fn the_files_load_before_they_are_changed() {
    let folder = Folder::new();
    folder.write("scene.xml", SCENE);
    folder.load("scene.xml", &[]).unwrap();
    load_mesh("obj", OBJ.as_bytes()).unwrap();
    load_mesh("ply", ASCII_PLY.as_bytes()).unwrap();
    load_mesh("ply", &binary_ply()).unwrap();
    load_mesh("serialized", &serialized()).unwrap();
}

/// A range from 1 to the length of what follows is none where nothing does.
#[test]
fn a_dollar_that_no_name_follows_is_refused() {
    for value in ["$", "2$", "$n$", "\\$$"] {
        let folder = Folder::new();
        let text = SCENE.replacen("value=\"$n\"", &format!("value=\"{value}\""), 1);
        assert_ne!(text, SCENE);
        folder.write("scene.xml", text);
        let error = folder.load("scene.xml", &[]).unwrap_err();
        assert!(error.contains("parameter $ has no value"), "{error}");
    }
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: CASES,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    }
}

/// Both readers of images, films packed in every way that there is.
#[test]
fn no_film_makes_the_readers_panic() {
    let folder = Folder::new();
    let films = PACKINGS.map(|packing| (packing, film(37, 41, packing, false)));
    for (packing, bytes) in &films {
        let path = folder.write("film.exr", bytes);
        let film = exr::read(&path).unwrap_or_else(|error| panic!("{packing:?}: {error}"));
        assert_eq!((film.width, film.height, film.channels.len()), (37, 41, 3));
        Bitmap::read(bytes, BitmapEncoding::Color).unwrap();
    }
    let counts = RefCell::new([[0_u32; 2]; PACKINGS.len()]);
    let outcome = TestRunner::new(config()).run(&one_or_more_mutations(), |mutations| {
        for ((_, original), [read, unpacked]) in films.iter().zip(counts.borrow_mut().iter_mut()) {
            let changed = mutate(original, &mutations);
            drop(Bitmap::read(&changed, BitmapEncoding::Color));
            let path = folder.write("film.exr", &changed);
            match exr::read(&path) {
                Ok(film) => {
                    *read += 1;
                    let texels = film.width * film.height;
                    prop_assert!(film.channels.iter().all(|c| c.samples.len() == texels));
                }
                Err(error) => {
                    let error = error.to_string();
                    prop_assert!(error.contains("film.exr: "), "{}", error);
                    *unpacked += u32::from(error.contains("compressed"));
                }
            }
        }
        Ok(())
    });
    if let Err(error) = outcome {
        panic!("{error}");
    }
    for ((packing, _), [read, unpacked]) in films.iter().zip(counts.into_inner()) {
        println!(
            "{packing:?}: of {CASES} changed films {read} are read, {unpacked} cannot be unpacked"
        );
        // Far from all are refused by their headers.
        assert!(
            read < CASES && read + unpacked > CASES / 10,
            "{packing:?}: {read} and {unpacked}"
        );
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn no_scene_file_makes_the_reader_panic(mutations in mutations()) {
        let folder = Folder::new();
        folder.write("scene.xml", mutate(SCENE.as_bytes(), &mutations));
        if let Err(error) = folder.load("scene.xml", &[]) {
            prop_assert!(error.starts_with("scene.xml"), "{}", error);
        }
    }

    #[test]
    fn no_mesh_file_makes_the_reader_panic(mutations in mutations()) {
        let files = [
            ("obj", OBJ.as_bytes().to_vec()),
            ("ply", ASCII_PLY.as_bytes().to_vec()),
            ("ply", binary_ply()),
            ("serialized", serialized()),
        ];
        for (plugin, original) in files {
            if let Err(error) = load_mesh(plugin, &mutate(&original, &mutations)) {
                prop_assert!(error.starts_with("scene.xml:1:24: shape"), "{}", error);
            }
        }
    }
}
