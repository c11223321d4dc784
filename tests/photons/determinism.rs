//! The same scene, method, seed and settings give the same bits, however the work is divided.

use std::path::{Path, PathBuf};
use std::process::Command;

use nephroid::internals::film::{Image, exr};
use nephroid::internals::mitsuba;
use nephroid::internals::numeric::StreamKind;
use nephroid::internals::reference::parts::{Divided, Gathered, Next, Part, Wanted};
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::reference::photons::{PhotonSettings, run};
use nephroid::internals::reference::shard::{Round, Shard};
use nephroid::internals::run::Budget;
use nephroid::internals::run::Estimate;
use nephroid::internals::run::Progress;
use nephroid::internals::scene::Scene;

use crate::support::parts;
use crate::support::scenes::meter;

fn scene_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name)
}

fn load(name: &str) -> Scene {
    // Small grids: what is tested does not depend on their size.
    mitsuba::load(&scene_path(name), &[("size".into(), "48".into())]).unwrap()
}

/// Every bit of an estimate that a user can see.
fn bits(estimate: &Estimate) -> Vec<u64> {
    let mut bits = vec![estimate.paths];
    let layers = std::iter::once(&estimate.total).chain(&estimate.layers);
    for layer in layers {
        for value in layer.values.iter().chain(&layer.standard_error) {
            bits.extend(value.0.map(f64::to_bits));
        }
        let sampling = layer.sampling.as_ref().expect("photons have bounds");
        for bound in sampling.low.iter().chain(&sampling.high) {
            bits.extend(bound.0.map(f64::to_bits));
        }
    }
    bits.extend(&estimate.counts);
    let ledger = &estimate.ledger;
    for row in ledger.rows.values().chain([&ledger.other]) {
        for flux in [
            row.received,
            row.direct,
            row.escaped,
            row.absorbed,
            row.cut_off,
        ] {
            bits.extend(flux.0.map(f64::to_bits));
        }
    }
    bits.extend(ledger.emitted.0.map(f64::to_bits));
    bits.extend([estimate.counters.rays, estimate.counters.primitive_tests]);
    bits.push(estimate.relative_error.map_or(0, f64::to_bits));
    bits
}

fn settings(stream: StreamKind) -> PhotonSettings {
    PhotonSettings {
        stream,
        replicates: 5,
        seed: 11,
        ..PhotonSettings::default()
    }
}

fn photons(count: u64) -> Budget {
    Budget {
        work: Some(count),
        ..Budget::default()
    }
}

fn estimate_on(
    threads: usize,
    scene: &Scene,
    settings: PhotonSettings,
    budget: &Budget,
) -> Estimate {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
        .install(|| run(scene, meter(scene), settings, budget, &Progress::default()).unwrap())
}

#[test]
fn one_two_three_and_eight_threads_give_the_same_bits() {
    // A ball, interpolated normals, mirrors, and an area light with four dimensions.
    for (name, stream) in [
        ("glass-ball.xml", StreamKind::Sobol),
        ("glass-ball-mesh.xml", StreamKind::Random),
        ("coffee-cup.xml", StreamKind::Sobol),
        ("cornell-glass.xml", StreamKind::Sobol),
    ] {
        let scene = load(name);
        let budget = photons(20_000);
        let alone = bits(&estimate_on(1, &scene, settings(stream), &budget));
        for threads in [2, 3, 8] {
            let together = bits(&estimate_on(threads, &scene, settings(stream), &budget));
            assert!(alone == together, "{name} differs on {threads} threads");
        }
    }
}

#[test]
fn another_seed_gives_other_bits() {
    let scene = load("glass-ball.xml");
    let one = settings(StreamKind::Sobol);
    let other = PhotonSettings { seed: 12, ..one };
    let budget = photons(5_000);
    assert!(
        bits(&estimate_on(2, &scene, one, &budget))
            != bits(&estimate_on(2, &scene, other, &budget))
    );
}

#[test]
fn shards_merge_to_the_bits_of_the_whole_run() {
    for name in ["glass-ball.xml", "cornell-glass.xml"] {
        let scene = load(name);
        let sensor = meter(&scene);
        let settings = settings(StreamKind::Sobol);
        let budget = photons(20_000);
        let progress = Progress::default();
        let setup = Setup::new(&scene, sensor, settings, &progress).unwrap();
        let whole = bits(&setup.run(&budget).unwrap());
        for count in [1, 3, 7] {
            let merged = bits(&parts::merged(&setup, &sensor.id, &budget, count));
            assert!(whole == merged, "{name} in {count} parts");
        }
    }
}

#[test]
fn shards_of_different_runs_do_not_merge() {
    let scene = load("glass-ball.xml");
    let sensor = meter(&scene);
    let progress = Progress::default();
    let shard = |seed: u64, index: u32, budget: &Budget| {
        let settings = PhotonSettings {
            seed,
            ..settings(StreamKind::Sobol)
        };
        Setup::new(&scene, sensor, settings, &progress)
            .unwrap()
            .run_shard(&sensor.id, budget, Shard { index, count: 2 })
            .unwrap()
            .unwrap()
    };
    let setup = Setup::new(&scene, sensor, settings(StreamKind::Sobol), &progress).unwrap();
    let few = photons(1_000);
    let cases = [
        (vec![shard(11, 0, &few), shard(12, 1, &few)], "settings"),
        (
            vec![shard(11, 0, &few), shard(11, 1, &photons(2_000))],
            "photons",
        ),
        (vec![shard(11, 1, &few)], "given were [2]"),
        (
            vec![shard(11, 0, &few), shard(11, 0, &few)],
            "needs each of them once",
        ),
        (Vec::new(), "needs each of them once"),
    ];
    for (files, reason) in cases {
        let error = match parts::opened(files.iter().map(Vec::as_slice)) {
            Ok(mut shards) => setup
                .merge(&sensor.id, &mut shards)
                .unwrap_err()
                .to_string(),
            Err(error) => error.to_string(),
        };
        assert!(error.contains(reason), "{error}");
    }
    // A part of a round that somebody asked for is no shard: nobody knows what is to follow.
    let Ok(Next::Step(wanted)) = setup.next(&sensor.id, &few, &Gathered::default()) else {
        panic!("no round");
    };
    let part = setup.run_part(&sensor.id, parts::round_of(&wanted), Shard::WHOLE);
    let mut bytes = Vec::new();
    part.unwrap().unwrap().write_to(&mut bytes).unwrap();
    let error = parts::opened([&bytes[..]]).err().unwrap().to_string();
    assert!(error.contains("no shard"), "{error}");
    // A part behind those of the run is of another.
    let file = setup.run_shard(&sensor.id, &few, Shard::WHOLE);
    let file = [file.unwrap().unwrap(), shard(11, 1, &few)].concat();
    let mut shards = parts::opened([&file[..]]).unwrap();
    let error = setup
        .merge(&sensor.id, &mut shards)
        .unwrap_err()
        .to_string();
    assert!(error.contains("a file: it has more rounds"), "{error}");
}

#[test]
fn rounds_in_parts_have_the_bits_of_the_whole_run() {
    for (name, budget, expected) in [
        ("glass-ball.xml", Budget::error(0.02), 2..8),
        ("cornell-glass.xml", Budget::error(0.2), 2..8),
        ("glass-ball.xml", photons(20_000), 1..2),
        // The error is reached by neither of its rounds, the second of which is cut short.
        (
            "glass-ball.xml",
            Budget {
                relative_error: Some(1e-6),
                ..photons(5 * (4096 + 5000))
            },
            2..3,
        ),
    ] {
        let scene = load(name);
        let sensor = &meter(&scene).id;
        let progress = Progress::default();
        let settings = settings(StreamKind::Sobol);
        let setup = Setup::new(&scene, meter(&scene), settings, &progress).unwrap();
        let whole = setup.run(&budget).unwrap();
        for count in [1, 3, 40] {
            let (found, rounds) = parts::gathered(&setup, sensor, &budget, count);
            assert!(bits(&whole) == bits(&found), "{name} in {count} parts");
            assert_eq!(whole.incomplete, found.incomplete);
            assert!(expected.contains(&rounds.len()), "{name}: {rounds:?}");
        }
    }
}

#[test]
fn parts_that_are_doubled_missing_or_of_another_run_are_not_gathered() {
    let scene = load("glass-ball.xml");
    let sensor = &meter(&scene).id;
    let progress = Progress::default();
    let of_seed = |seed: u64| {
        let settings = PhotonSettings {
            seed,
            ..settings(StreamKind::Sobol)
        };
        Setup::new(&scene, meter(&scene), settings, &progress).unwrap()
    };
    let (setup, other) = (of_seed(11), of_seed(12));
    let budget = photons(1_000);
    let empty = Gathered::default();
    let of_round = |setup: &Setup, budget: &Budget| -> Box<Wanted> {
        match setup.next(sensor, budget, &empty) {
            Ok(Next::Step(wanted)) => wanted,
            other => panic!("{other:?}"),
        }
    };
    let wanted = of_round(&setup, &budget);
    let round = parts::round_of(&wanted);
    assert_ne!(wanted.key, of_round(&other, &budget).key);
    assert_ne!(wanted.key, of_round(&setup, &photons(2_000)).key);
    let part = |setup: &Setup, round, index, count| {
        let shard = Shard { index, count };
        setup.run_part(sensor, round, shard).unwrap().unwrap()
    };
    let [first, second] = [0, 1].map(|index| Shard { index, count: 2 });
    let mut gathered = Gathered::default();
    // Nor are they the first of their round.
    let longer = Round {
        each: 2 * round.each,
        ..round
    };
    for (wrong, reason) in [
        (part(&setup, round, 0, 2), "the shard is 2 here and 1 there"),
        (part(&setup, round, 1, 3), "the number of shards"),
        (part(&other, round, 1, 2), "the list of settings"),
        (part(&setup, longer, 1, 2), "the number of photons"),
    ] {
        let error = gathered
            .add(&wanted, second, wrong)
            .unwrap_err()
            .to_string();
        assert!(error.contains(reason), "{error}");
    }
    gathered
        .add(&wanted, second, part(&setup, round, 1, 2))
        .unwrap();
    let missing = setup.next(sensor, &budget, &gathered).unwrap_err();
    assert!(missing.to_string().contains("given were [2]"), "{missing}");
    for (shard, wrong, reason) in [
        (second, part(&setup, round, 1, 2), "needs each of them once"),
        (
            Shard { index: 0, count: 3 },
            part(&setup, round, 0, 3),
            "the number of shards is 2 here and 3 there",
        ),
        (first, part(&other, round, 0, 2), "the list of settings"),
    ] {
        let error = gathered.add(&wanted, shard, wrong).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
    // What was refused is not in it.
    gathered
        .add(&wanted, first, part(&setup, round, 0, 2))
        .unwrap();
    let Ok(Next::Done(estimate)) = setup.next(sensor, &budget, &gathered) else {
        panic!("not done");
    };
    assert!(bits(&estimate) == bits(&setup.run(&budget).unwrap()));
    // Of a run that means another round the rest is refused, too.
    let error = setup.next(sensor, &photons(2_000), &gathered).unwrap_err();
    assert!(error.to_string().contains("photons"), "{error}");
    let timed = Budget {
        time: Some(std::time::Duration::from_secs(1)),
        ..budget
    };
    let error = setup.next(sensor, &timed, &empty).unwrap_err();
    assert!(error.to_string().contains("not time"), "{error}");
}

#[test]
fn a_damaged_shard_is_refused_and_never_a_panic() {
    let scene = load("glass-ball.xml");
    let sensor = meter(&scene);
    let progress = Progress::default();
    let setup = Setup::new(&scene, sensor, settings(StreamKind::Sobol), &progress).unwrap();
    let file = setup.run_shard(&sensor.id, &photons(500), Shard::WHOLE);
    let bytes = file.unwrap().unwrap();
    for length in [0, 1, 16, 17, 100, 1_000, bytes.len() / 2, bytes.len() - 1] {
        assert!(Part::read_from(&bytes[..length]).is_err(), "{length}");
    }
    // A digit of a number in the header still spells a header.
    let [first, second] = line_ends(&bytes);
    let digits = (first..second).filter(|&place| bytes[place].is_ascii_digit());
    let somewhere = (0..bytes.len()).step_by(bytes.len() / 64);
    let places: Vec<usize> = digits.chain(somewhere).collect();
    assert!(places.len() > 200, "{}", places.len());
    for place in places {
        let mut damaged = bytes.clone();
        damaged[place] ^= 1;
        assert!(Part::read_from(&damaged[..]).is_err(), "{place}");
    }
    assert!(Part::read_from(&[&bytes[..], b"\n"].concat()[..]).is_err());
    let old = [b"nephroid shard 3", &bytes[first..]].concat();
    let error = Part::read_from(&old[..]).unwrap_err().to_string();
    assert!(error.contains("make it again"), "{error}");
}

/// The places at which the first two lines end.
fn line_ends(bytes: &[u8]) -> [usize; 2] {
    let mut ends = (0..bytes.len()).filter(|&at| bytes[at] == b'\n');
    [ends.next().unwrap(), ends.next().unwrap()]
}

/// Whoever merges sums takes them at their header's word: numbers that contradict them are refused.
#[test]
fn a_shard_whose_header_contradicts_its_sums_is_refused() {
    let scene = load("glass-ball.xml");
    let sensor = meter(&scene);
    let progress = Progress::default();
    let setup = Setup::new(&scene, sensor, settings(StreamKind::Sobol), &progress).unwrap();
    let shard = Shard { index: 1, count: 3 };
    let file = setup.run_shard(&sensor.id, &photons(500), shard);
    let bytes = file.unwrap().unwrap();
    let ends = line_ends(&bytes);
    let header = std::str::from_utf8(&bytes[ends[0] + 1..ends[1]]).unwrap();
    let replicates = settings(StreamKind::Sobol).replicates;
    for (old, new, says) in [
        (
            format!("\"replicates\":{replicates},\"each\""),
            "\"replicates\":99,\"each\"",
            "its sums have",
        ),
        (
            "\"index\":1".to_owned(),
            "\"index\":3",
            "allowed are 0 to 2",
        ),
        ("\"count\":3".to_owned(), "\"count\":0", "part 1 of 0"),
        ("\"size\":[48,48]".to_owned(), "\"size\":[48,7]", "texels"),
        ("[48,48]".to_owned(), "[48,2000000]", "allowed are up to"),
        (
            "\"method\":\"photons\"".to_owned(),
            "\"method\":\"path\"",
            "not of its method",
        ),
        (
            "\"each\":100".to_owned(),
            "\"each\":18446744073709551615",
            "2^64",
        ),
        (
            "{\"largest\"".to_owned(),
            "{\"largest\":[0,0,0],\"contributions\":0},{\"largest\"",
            "layers",
        ),
    ] {
        assert!(header.contains(&old), "{old} in {header}");
        let header = header.replacen(&old, new, 1);
        let rest = &bytes[ends[1]..bytes.len() - 32];
        let mut changed = [&bytes[..=ends[0]], header.as_bytes(), rest].concat();
        changed.extend(blake3::hash(&changed).as_bytes());
        let error = Part::read_from(&changed[..]).unwrap_err().to_string();
        assert!(error.contains(says), "{new}: {error}");
    }
    assert!(Part::read_from(&bytes[..]).is_ok());
}

#[test]
fn files_are_the_same_but_for_their_timing() {
    let folder = tempfile::tempdir().unwrap();
    let render = |arguments: &[&str], output: &Path| {
        let status = Command::new(env!("CARGO_BIN_EXE_nephroid"))
            .args(arguments)
            .args(["-o", output.to_str().unwrap()])
            .stdout(std::process::Stdio::null())
            .status()
            .unwrap();
        assert!(status.success());
    };
    let scene = scene_path("glass-ball.xml");
    let scene = scene.to_str().unwrap();
    let common = ["--photons", "6400"];
    let image = |path: &Path| -> Image {
        let mut image = exr::read(path).unwrap();
        image.metadata.retain(|(key, _)| key != "timing");
        image
    };
    let whole = folder.path().join("whole.exr");
    render(
        &[&["render", scene, "--threads", "1"], &common[..]].concat(),
        &whole,
    );
    let expected = image(&whole);
    assert!(expected.channel("LTTD.R").is_some());
    assert!(expected.channel("E.stderr.B").is_some());
    for threads in ["2", "3", "8"] {
        let path = folder.path().join(format!("{threads}.exr"));
        render(
            &[&["render", scene, "--threads", threads], &common[..]].concat(),
            &path,
        );
        assert!(image(&path) == expected, "{threads} threads");
        // The picture has no timing at all.
        let picture = |path: &Path| std::fs::read(path.with_extension("png")).unwrap();
        assert!(picture(&path) == picture(&whole));
    }
    let shards: Vec<PathBuf> = (1..=3)
        .map(|k| {
            let path = folder.path().join(format!("{k}.shard"));
            let shard = format!("{k}/3");
            render(
                &[&["render", scene, "--shard", &shard], &common[..]].concat(),
                &path,
            );
            path
        })
        .collect();
    let merged = folder.path().join("merged.exr");
    let mut arguments = vec!["merge", scene];
    arguments.extend(shards.iter().map(|path| path.to_str().unwrap()));
    render(&arguments, &merged);
    assert!(image(&merged) == expected, "merged shards");
}
