//! Inputs from which fuzzing starts: small honest files of all formats.

use std::io::{Cursor, Read as _};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::bufread::GzDecoder;
use image::{DynamicImage, ImageFormat};
use nephroid::internals::method::Method;
use nephroid::internals::reference::parts::Divided;
use nephroid::internals::reference::shard::Shard;
use nephroid::internals::run::{Budget, Context};
use nephroid::internals::scene::Scene;
use nephroid::{Image, read_exr};

use super::changed::{SCENE, load_text};
use super::honest::{Kind, written};
use super::replay::{corpora, inputs, packed};
use crate::entries::{NEXT, PLAIN, TABLES, TARGETS, small_runs};
use crate::support::geometry::icosphere;
use crate::support::mutation::{PACKINGS, film, obj, ply, serialized, serialized_contents};
use crate::support::parts::parts_of;

/// A light, a ball and a floor of 4 x 4 texels.
const SMALL: &str = r#"<scene version="3.0.0">
<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/></emitter>
<shape type="sphere"><point name="center" x="0" y="0" z="1"/><float name="radius" value="0.5"/><bsdf type="dielectric"/></shape>
<shape type="rectangle"><sensor type="irradiancemeter"><film type="hdrfilm">
<integer name="width" value="4"/><integer name="height" value="4"/><rfilter type="box"/>
</film></sensor></shape></scene>"#;

const STUDIES: [&str; 3] = [
    "scene = \"a.xml\"\nsensor = \"floor\"\nseed = 3\nrepeats = 2\nmargin = \"1%\"\ntime = \"30s\"\n\
     [define]\nsize = 64\n[truth]\nmethod = \"beams\"\nerror = \"0.1%\"\n\
     [[method]]\nmethod = \"photons\"\nname = \"P\"\nphotons = { from = 1000, to = 64000, times = 4 }\n\
     [max-error]\nrmse = 0.1\n",
    "scene = 'a.xml'\nsensors = ['floor', \"camera\"]\nposes = [{ azimuth = [30, 60], lift = 1 }]\n\
     [truth.floor]\nmethod = \"closed-form\"\n[[method]]\nmethod = \"caustic-map\"\nphotons = [64, 128]\n\
     [[candidate]]\nname = \"mine\"\nsensor = \"floor\"\nfile = \"mine.exr\"\nseconds = 1.5\n",
    "scene = \"a.xml\"\n[poses]\nlift = { from = 0, to = 1, count = 30 }\nazimuth = { from = 0, to = 9, step = 3 }\n",
];

/// Honest files of a target.
fn seeds(target: &str) -> Vec<Vec<u8>> {
    match target {
        "xml" => [SCENE, SMALL].map(|text| text.as_bytes().to_vec()).into(),
        "obj" => vec![
            obj(&icosphere(0)),
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3 4\nf -1 -2 -3\n"
                .to_vec(),
        ],
        "ply" => ["ascii", "binary_little_endian", "binary_big_endian"]
            .map(|format| ply(&icosphere(0), format))
            .into(),
        "serialized" => [Compression::none(), Compression::best()]
            .map(|packing| serialized(&serialized_contents(&icosphere(0)), packing))
            .into(),
        "picture" => pictures(),
        "film" => films(),
        "study" => STUDIES.map(|text| text.as_bytes().to_vec()).into(),
        "shard" => shards(),
        _ => tables(),
    }
}

fn pictures() -> Vec<Vec<u8>> {
    let rgb = image::RgbImage::from_fn(5, 3, |x, y| image::Rgb([40 * x as u8, 90 * y as u8, 7]));
    let rgb = DynamicImage::ImageRgb8(rgb);
    let images = [
        rgb.clone(),
        DynamicImage::ImageLuma8(rgb.to_luma8()),
        DynamicImage::ImageRgba8(rgb.to_rgba8()),
        DynamicImage::ImageRgb16(rgb.to_rgb16()),
        DynamicImage::ImageRgb32F(rgb.to_rgb32f()),
    ];
    let formats = [
        ImageFormat::Png,
        ImageFormat::Jpeg,
        ImageFormat::Bmp,
        ImageFormat::Tga,
        ImageFormat::Hdr,
        ImageFormat::Pnm,
    ];
    let mut all: Vec<Vec<u8>> = Vec::new();
    for (image, format) in images
        .iter()
        .flat_map(|image| formats.map(|format| (image, format)))
    {
        let mut bytes = Cursor::new(Vec::new());
        // Not every format has all kinds of numbers.
        if image.write_to(&mut bytes, format).is_ok() {
            all.push(bytes.into_inner());
        }
    }
    for text in [
        "P1\n4 2\n0 1 0 1\n1 0 1 0\n",
        "P2 3 2 65535\n1 2 3 4 5 60000\n",
        "P3\n2 1\n255\n1 2 3 4 5 6\n",
        "P4\n9 2\nabcd",
        "P5 2 2 255\nabcd",
        "P6 2 1 255\nabcdef",
        "P7\nWIDTH 2\nHEIGHT 1\nDEPTH 3\nMAXVAL 255\nTUPLTYPE RGB\nENDHDR\nabcdef",
    ] {
        all.push(text.as_bytes().to_vec());
    }
    all.push(Kind::Exr.honest(0));
    all.extend(PACKINGS.map(|packing| film(6, 2, packing, false)));
    all
}

fn films() -> Vec<Vec<u8>> {
    let scene = load_text(SMALL.as_bytes()).result.unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut all: Vec<Vec<u8>> = Vec::new();
    for (method, key, value) in [
        ("photons", "photons", "4096"),
        ("beams", "error", "5%"),
        ("caustic-map", "photons", "64"),
    ] {
        let path = folder.path().join(format!("{method}.exr"));
        let method = Method::new(method, &[(key.to_owned(), value.to_owned())].into()).unwrap();
        let rendering = method
            .run(
                &scene,
                &scene.sensors()[0],
                &Budget::default(),
                &Context::default(),
            )
            .unwrap();
        rendering.write_exr(&scene, &path).unwrap();
        all.push(std::fs::read(&path).unwrap());
        let mut image: Image = read_exr(&path).unwrap();
        image
            .channels
            .retain(|channel| !channel.name.ends_with(".G"));
        all.push(written(&image));
    }
    all.extend(PACKINGS.map(|packing| film(3, 3, packing, false)));
    all
}

/// Shards of each method as they are written, and with plain sums; without the hash at the end of their parts.
fn shards() -> Vec<Vec<u8>> {
    let (photons, maps, paths) = small_runs();
    let [photons, maps, paths] = [
        photons.run_shard("meter", &Budget::work(64), Shard::WHOLE),
        // Rounds of one, two and one map.
        maps.run_shard("camera", &Budget::work(4 * 2 * 16), Shard::WHOLE),
        paths.run_shard("camera", &Budget::work(4), Shard::WHOLE),
    ]
    .map(|file| without_hashes(&file.unwrap().unwrap()));
    let all = |parts: &[Vec<u8>]| parts.join(NEXT);
    let plain: Vec<Vec<u8>> = maps.iter().map(|part| plain_sums(part)).collect();
    let photons_plain = plain_sums(&photons[0]);
    vec![
        all(&photons),
        photons_plain,
        all(&maps),
        all(&plain),
        all(&paths),
    ]
}

/// The parts of a shard without their hashes.
fn without_hashes(file: &[u8]) -> Vec<Vec<u8>> {
    let parts = parts_of(file).into_iter();
    parts.map(|part| part[..part.len() - 32].to_vec()).collect()
}

/// The same with sums that are not deflated.
fn plain_sums(whole: &[u8]) -> Vec<u8> {
    let at = whole.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
    let lines = at.map(|(at, _)| at + 1).nth(1).unwrap();
    let mut plain = [PLAIN, &whole[..lines]].concat();
    let mut rest = &whole[lines..];
    while !rest.is_empty() {
        let mut sums = Vec::new();
        let mut decoder = GzDecoder::new(&rest[8..]);
        decoder.read_to_end(&mut sums).unwrap();
        plain.extend((sums.len() as u16).to_le_bytes());
        plain.extend(sums);
        rest = decoder.into_inner();
    }
    plain
}

/// The contents of tables of all kinds, and of the borders of shells.
fn tables() -> Vec<Vec<u8>> {
    let scene = load_text(SMALL.as_bytes()).result.unwrap();
    let mut all = Vec::new();
    for (kind, given) in (0..).zip(TABLES) {
        let folder = tempfile::tempdir().unwrap();
        run_with_tables(&scene, given, folder.path());
        for name in ["0.table", "harmonics.table", "shells.table"] {
            for form in std::fs::read_dir(folder.path().join("local-irradiance")).unwrap() {
                let Ok(bytes) = std::fs::read(form.unwrap().path().join(name)) else {
                    continue;
                };
                // The header has 92 bytes, the checksum 32.
                all.push([&[kind], &bytes[92..bytes.len() - 32]].concat());
                all.push([&[kind | 8], &bytes[..]].concat());
            }
        }
    }
    all
}

fn run_with_tables(scene: &Scene, given: &[(&str, &str)], cache: &Path) {
    let more = [("photons", "256"), ("frequency", "1"), ("tables", "all")];
    let given = given.iter().chain(&more);
    let given = given.map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
    let method = Method::new("local-irradiance", &given.collect()).unwrap();
    let context = Context {
        cache: Some(cache.to_owned()),
        ..Context::default()
    };
    method
        .run(scene, &scene.sensors()[0], &Budget::default(), &context)
        .unwrap();
}

/// Where fuzzing is to start, or has ended: a folder with one of each target.
fn fuzzed() -> PathBuf {
    let folder = std::env::var_os("NEPHROID_FUZZ");
    folder.expect("NEPHROID_FUZZ, a folder").into()
}

#[test]
#[ignore = "writes inputs to start from: NEPHROID_FUZZ=fuzz/corpus cargo test --release --test hostile seeds_ -- --ignored"]
fn seeds_and_kept_inputs_are_written() {
    for target in TARGETS {
        let folder = fuzzed().join(target);
        std::fs::create_dir_all(&folder).unwrap();
        let kept = inputs(target).into_iter().map(|(_, input)| input);
        for seed in seeds(target).into_iter().chain(kept) {
            let name = blake3::hash(&seed).to_hex()[..16].to_owned();
            std::fs::write(folder.join(name), seed).unwrap();
        }
    }
}

#[test]
#[ignore = "replaces corpora by minimised ones: NEPHROID_FUZZ=fuzz/min cargo test --release --test hostile packs_ -- --ignored"]
fn packs_of_minimised_inputs_are_written() {
    for target in TARGETS {
        let Ok(folder) = std::fs::read_dir(fuzzed().join(target)) else {
            continue;
        };
        let inputs = folder.map(|entry| std::fs::read(entry.unwrap().path()).unwrap());
        std::fs::write(corpora().join(target), packed(inputs.collect())).unwrap();
    }
}
