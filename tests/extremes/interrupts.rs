//! A run that somebody ends says so, whatever limits it had, and delivers what it has until then.

use std::thread;
use std::time::{Duration, Instant};

use nephroid::internals::reference::beams;
use nephroid::internals::reference::beams::BeamSettings;
use nephroid::internals::reference::path;
use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::reference::photon_map;
use nephroid::internals::reference::photon_map::PhotonMapSettings;
use nephroid::internals::reference::photons;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, Progress};
use nephroid::internals::scene::Scene;

use crate::support::scenes::bundled_file;
use crate::support::seen::{sensor, with_films};

/// Ends a run as soon as it has come so far. A run that ends by itself before, does so in vain: all of these
/// would go on for a minute and more.
fn stopped(
    run: impl FnOnce(&Progress) -> Estimate,
    has_come: impl Fn(&Progress) -> bool + Sync,
) -> Estimate {
    let progress = Progress::default();
    thread::scope(|scope| {
        let watch = scope.spawn(|| {
            let start = Instant::now();
            while !has_come(&progress) {
                assert!(
                    start.elapsed() < Duration::from_secs(60),
                    "it does not come so far"
                );
                thread::sleep(Duration::from_millis(1));
            }
            progress.stop();
        });
        let estimate = run(&progress);
        watch.join().expect("it came so far");
        estimate
    })
}

/// Something is known, but it is not what was asked for.
fn assert_is_a_part(name: &str, estimate: &Estimate) {
    println!(
        "{name}: {} paths, relative error {:?}",
        estimate.paths, estimate.relative_error
    );
    assert!(estimate.incomplete, "{name}");
    assert!(!estimate.total.is_unknown(), "{name}");
    assert!(estimate.relative_error.is_some(), "{name}");
}

/// Limits under which a run goes on for long: a number, an error, a time.
const NUMBER: u64 = 1 << 34;
const ERROR: f64 = 1e-9;
const TIME: Duration = Duration::from_secs(3600);

/// The glass ball, with a small camera.
fn glass_ball(texels: usize) -> Scene {
    with_films(&bundled_file("glass-ball"), PIXELS, texels)
}

const PIXELS: [usize; 2] = [64, 48];

#[test]
fn photons_that_are_interrupted_say_so() {
    let scene = glass_ball(16);
    let run = |budget: Budget, each: u64| {
        let by = |progress: &Progress| {
            let settings = PhotonSettings::default();
            photons::run(&scene, sensor(&scene, "floor"), settings, &budget, progress).unwrap()
        };
        // Two replicates have an error bar.
        stopped(by, |progress| progress.done() > 3 * each)
    };
    let replicates = u64::from(PhotonSettings::default().replicates);
    // Each replicate of a second or less, all of them of many.
    let photons = replicates << 19;
    let budget = Budget {
        work: Some(photons),
        ..Budget::default()
    };
    let part = run(budget, photons / replicates);
    assert_is_a_part("photons, a number", &part);
    assert!(part.paths < photons, "{}", part.paths);
    // Rounds begin with 2^12 photons a replicate.
    for (name, budget) in [
        (
            "photons, an error",
            Budget {
                relative_error: Some(ERROR),
                ..Budget::default()
            },
        ),
        (
            "photons, a time",
            Budget {
                time: Some(TIME),
                ..Budget::default()
            },
        ),
        (
            "photons, a number and a time",
            Budget {
                work: Some(NUMBER),
                time: Some(TIME),
                ..Budget::default()
            },
        ),
    ] {
        assert_is_a_part(name, &run(budget, replicates << 12));
    }
}

#[test]
fn beams_that_are_interrupted_say_so() {
    let scene = glass_ball(128);
    // Without any limit they end at an error of 0.1 %, mostly after one pass.
    for (name, budget) in [
        (
            "beams, an error",
            Budget {
                relative_error: Some(ERROR),
                ..Budget::default()
            },
        ),
        (
            "beams, a time",
            Budget {
                time: Some(TIME),
                ..Budget::default()
            },
        ),
        (
            "beams, a number of rays",
            Budget {
                work: Some(NUMBER),
                ..Budget::default()
            },
        ),
    ] {
        let by = |progress: &Progress| {
            let settings = BeamSettings::default();
            let floor = sensor(&scene, "floor");
            beams::run(&scene, floor, settings, &budget, progress)
                .unwrap()
                .0
        };
        // One pass is done.
        let part = stopped(by, |progress| progress.pass().is_some_and(|pass| pass > 1));
        assert_is_a_part(name, &part);
    }
}

#[test]
fn paths_that_are_interrupted_say_so() {
    let scene = glass_ball(16);
    let camera = sensor(&scene, "camera");
    let pixels = PIXELS.iter().product::<usize>() as u64;
    let settings = PathSettings {
        replicates: 255,
        ..PathSettings::default()
    };
    let replicates = u64::from(settings.replicates);
    for (name, budget, each) in [
        (
            "paths, a number",
            Budget {
                work: Some(64 * replicates),
                ..Budget::default()
            },
            64,
        ),
        (
            "paths, an error",
            Budget {
                relative_error: Some(ERROR),
                ..Budget::default()
            },
            1,
        ),
        (
            "paths, a time",
            Budget {
                time: Some(TIME),
                ..Budget::default()
            },
            1,
        ),
    ] {
        let by = |progress: &Progress| {
            path::run(&scene, camera, settings, &budget, progress)
                .unwrap()
                .0
        };
        // A filter that reaches beyond the film makes it larger by some pixels.
        let part = stopped(by, |progress| progress.done() > 4 * each * pixels);
        assert_is_a_part(name, &part);
    }
}

#[test]
fn photon_maps_that_are_interrupted_say_so() {
    let scene = glass_ball(16);
    let settings = PhotonMapSettings::default();
    let first_round = u64::from(settings.photons.replicates) * settings.map_photons;
    for (name, budget) in [
        (
            "photon maps, a number",
            Budget {
                work: Some(NUMBER),
                ..Budget::default()
            },
        ),
        (
            "photon maps, an error",
            Budget {
                relative_error: Some(ERROR),
                ..Budget::default()
            },
        ),
        (
            "photon maps, a time",
            Budget {
                time: Some(TIME),
                ..Budget::default()
            },
        ),
    ] {
        let by = |progress: &Progress| {
            let camera = sensor(&scene, "camera");
            photon_map::run(&scene, camera, settings, &budget, progress)
                .unwrap()
                .0
        };
        let part = stopped(by, |progress| progress.done() > first_round);
        assert_is_a_part(name, &part);
    }
}

/// A time that is over is no interrupt: it was asked for.
#[test]
fn what_was_asked_for_is_whole() {
    let scene = glass_ball(16);
    let budget = Budget {
        time: Some(Duration::from_secs(3)),
        ..Budget::default()
    };
    let settings = PhotonSettings::default();
    let progress = Progress::default();
    let floor = sensor(&scene, "floor");
    let photons = photons::run(&scene, floor, settings, &budget, &progress).unwrap();
    assert!(!photons.incomplete && !photons.total.is_unknown());
}
