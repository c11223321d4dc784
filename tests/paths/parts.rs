//! Paths of parts of an image, and the image that they make together: the bits of the image in one piece.

use nephroid::internals::reference::parts::{Divided, Part};
use nephroid::internals::reference::path::run::Setup;
use nephroid::internals::reference::path::{PathReport, PathSettings};
use nephroid::internals::reference::shard::Shard;
use nephroid::internals::run::{Budget, Estimate, Progress};
use nephroid::internals::scene::{ReconstructionFilter, Scene};

use crate::support::parts::{gathered, merged, opened};
use crate::support::paths::{BOX, bits, camera, film, scene};

/// A glass ball under a lamp, beside a smaller one made of faces, of which most of the image's upper part is dark: some parts of it lack some classes.
fn room([width, height]: [u32; 2], filter: &str) -> Scene {
    let film = film(width, height, filter);
    scene(&format!(
        "{}<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/><translate z=\"-1\"/></transform>\
         <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.7, 0.5, 0.3\"/></bsdf></shape>\
         <shape type=\"sphere\"><point name=\"center\" value=\"0, 0, -0.4\"/><float name=\"radius\" value=\"0.5\"/>\
         <bsdf type=\"dielectric\"/></shape>\
         <shape type=\"ply\"><string name=\"filename\" value=\"{}/scenes/glass-ball-mesh.ply\"/>\
         <transform name=\"to_world\"><scale value=\"0.3\"/><translate x=\"-0.5\" z=\"-0.6\"/></transform>\
         <bsdf type=\"dielectric\"/></shape>\
         <shape type=\"sphere\"><point name=\"center\" value=\"0, 1, 2\"/><float name=\"radius\" value=\"0.3\"/>\
         <emitter type=\"area\"><rgb name=\"radiance\" value=\"2, 3, 4\"/></emitter></shape>",
        camera(25.0, &film),
        env!("CARGO_MANIFEST_DIR")
    ))
}

const GAUSSIAN: &str = "<rfilter type=\"gaussian\"/>";

fn settings() -> PathSettings {
    PathSettings {
        replicates: 4,
        ..PathSettings::default()
    }
}

/// All that a run tells, bit by bit.
fn all_bits((estimate, report): &(Estimate, PathReport)) -> Vec<u64> {
    let counters = estimate.counters;
    let error = estimate.relative_error.map_or(0, f64::to_bits);
    let mut all = bits(estimate);
    all.extend([counters.node_visits, counters.primitive_tests, error]);
    all.extend([report.samples, report.cut_off, estimate.incomplete.into()]);
    all
}

/// Films, and numbers of parts of each. Filters stay within pixels, reach their neighbours and rows beyond those, have
/// weights of both signs, and reach beyond a whole band. Bands have one tile or, in the last, two.
const FILMS: [([u32; 2], &str, &[u32]); 6] = [
    ([20, 100], BOX, &[1, 3, 7, 9]),
    ([20, 100], GAUSSIAN, &[1, 3, 7, 9]),
    (
        [20, 100],
        "<boolean name=\"sample_border\" value=\"true\"/><rfilter type=\"lanczos\"/>",
        &[1, 3, 7],
    ),
    (
        [9, 60],
        "<rfilter type=\"gaussian\"><float name=\"stddev\" value=\"6\"/></rfilter>",
        &[2, 4],
    ),
    ([30, 1], GAUSSIAN, &[1, 2]),
    ([5, 300], GAUSSIAN, &[2]),
];

#[test]
fn images_in_parts_have_the_bits_of_the_whole_run() {
    for (size, filter, counts) in FILMS {
        let scene = room(size, filter);
        let camera = &scene.sensors()[0];
        let progress = Progress::default();
        let setup = Setup::new(&scene, camera, settings(), &progress).unwrap();
        let budget = Budget::work(16);
        let whole = setup.run(&budget).unwrap();
        assert!(size[1] == 1 || whole.0.layers.len() > 2);
        for &count in counts {
            let found = merged(&setup, &camera.id, &budget, count);
            assert!(
                all_bits(&found) == all_bits(&whole),
                "{filter}, {count} shards"
            );
        }
        let budget = Budget::error(0.8 * whole.0.relative_error.unwrap());
        let whole = setup.run(&budget).unwrap();
        let (found, rounds) = gathered(&setup, &camera.id, &budget, 3);
        assert!(all_bits(&found) == all_bits(&whole), "{filter}, rounds");
        assert!((2..12).contains(&rounds.len()), "{rounds:?}");
    }
}

#[test]
fn work_of_all_parts_is_that_of_the_image() {
    let scene = room([20, 100], GAUSSIAN);
    let camera = &scene.sensors()[0];
    let done = |count: u32| -> u64 {
        let of_part = |index| {
            let progress = Progress::default();
            let setup = Setup::new(&scene, camera, settings(), &progress).unwrap();
            let shard = Shard { index, count };
            setup
                .run_shard(&camera.id, &Budget::work(4), shard)
                .unwrap();
            assert_eq!(progress.expected().unwrap_or(0), progress.done());
            progress.done()
        };
        (0..count).map(of_part).sum()
    };
    assert_eq!([1, 3, 7].map(done), [20 * 100 * 4; 3]);
}

#[test]
fn a_part_that_is_stopped_is_none() {
    let scene = room([20, 100], BOX);
    let camera = &scene.sensors()[0];
    let progress = Progress::default();
    let setup = Setup::new(&scene, camera, settings(), &progress).unwrap();
    progress.stop();
    let shard = Shard { index: 0, count: 2 };
    let parts = setup.run_shard(&camera.id, &Budget::work(4), shard);
    assert!(parts.unwrap().is_none());
}

#[test]
fn parts_that_are_damaged_or_of_another_run_are_refused() {
    let scene = room([20, 100], BOX);
    let camera = &scene.sensors()[0];
    let progress = Progress::default();
    let setup = Setup::new(&scene, camera, settings(), &progress).unwrap();
    let budget = Budget::work(4);
    let shard = |setup: &Setup, index| {
        let shard = Shard { index, count: 2 };
        setup.run_shard("eye", &budget, shard).unwrap().unwrap()
    };
    let [bytes, second] = [0, 1].map(|index| shard(&setup, index));
    let line = |number: usize| {
        let ends = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
        ends.map(|(at, _)| at + 1).nth(number).unwrap()
    };
    let body = line(1);
    // Anything in it that is changed, missing or too much.
    for place in [0, line(0) + 40, body, body + 1000, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[place] ^= 1;
        assert!(Part::read_from(&damaged[..]).is_err(), "{place}");
        assert!(Part::read_from(&bytes[..place]).is_err(), "{place}");
    }
    assert!(Part::read_from(&[&bytes[..], b"\n"].concat()[..]).is_err());
    // Whoever changes the hash, too, has sums that no part can have.
    let header = std::str::from_utf8(&bytes[line(0)..body]).unwrap();
    for (old, new, says) in [
        (
            "\"size\":[20,100]",
            "\"size\":[20,1000]",
            "fewer than its header says",
        ),
        ("\"lit\":[", "\"lit\":[9,", "its list of layers"),
        (
            "\"method\":\"path\"",
            "\"method\":\"photons\"",
            "not of its method",
        ),
    ] {
        let changed = header.replace(old, new);
        assert!(changed != header, "{old} in {header}");
        let mut file = [
            &bytes[..line(0)],
            changed.as_bytes(),
            &bytes[body..bytes.len() - 32],
        ]
        .concat();
        file.extend(blake3::hash(&file).as_bytes());
        let error = Part::read_from(&file[..]).unwrap_err().to_string();
        assert!(error.contains(says), "{new}: {error}");
    }
    // Missing and doubled ones, and those of another seed or filter.
    let refused = |files: &[&[u8]], says: &str| {
        let error = match opened(files.iter().copied()) {
            Ok(mut shards) => setup.merge("eye", &mut shards).unwrap_err().to_string(),
            Err(error) => error.to_string(),
        };
        assert!(error.contains(says), "{says}: {error}");
    };
    refused(&[], "needs each of them once");
    refused(&[&second], "given were [2]");
    refused(&[&second, &bytes, &second], "given were [1, 2, 2]");
    let seeded = PathSettings {
        seed: 1,
        ..settings()
    };
    let other = Setup::new(&scene, camera, seeded, &progress).unwrap();
    refused(&[&bytes, &shard(&other, 1)], "the list of settings");
    let wide = room([20, 100], GAUSSIAN);
    let other = Setup::new(&wide, &wide.sensors()[0], settings(), &progress).unwrap();
    refused(
        &[&shard(&other, 0), &shard(&other, 1)],
        "the hash of the scene",
    );
    let mut boxed = wide.sensors()[0].clone();
    boxed.film.filter = ReconstructionFilter::Box;
    let boxed = Setup::new(&wide, &boxed, settings(), &progress).unwrap();
    let files = [shard(&boxed, 0), shard(&boxed, 1)];
    let mut shards = opened(files.iter().map(Vec::as_slice)).unwrap();
    let error = other.merge("eye", &mut shards).unwrap_err().to_string();
    assert!(error.contains("the sensor"), "{error}");
    // Other work, which only parts of the same would tell.
    let less = setup.run_shard("eye", &Budget::work(3), Shard { index: 1, count: 2 });
    refused(&[&bytes, &less.unwrap().unwrap()], "the number of");
}
