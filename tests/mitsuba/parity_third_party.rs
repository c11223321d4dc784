//! Third-party scenes make the same image in both programs. On demand: neither the scenes nor their images
//! are part of this repository, and `tests/mitsuba/parity/third_party.py` says how to make the images.

use std::path::Path;

use nephroid::internals::metric::Verdict;
use nephroid::internals::mitsuba::load;
use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::scene::ReconstructionFilter;

use crate::support::parity::{Outcome, mitsuba_image, outcome, render, samples_of, scaled};

/// The scenes, in the first column.
const LIST: &str = include_str!("third_party_quick.txt");

/// As in `third_party.py`.
const DEPTH: u32 = 8;

/// Our samples a pixel and replicate for one of Mitsuba's and seed: see `parity.rs`.
const SHARE: u64 = 4;

/// Number of scenes that must be shown to be the same within 1 %, mean and pixels.
const MUST_AGREE: usize = 10;

#[test]
#[ignore = "needs the scenes beside this repository, and NEPHROID_PARITY_DIR: see tests/mitsuba/parity/third_party.py"]
fn third_party_scenes_make_mitsubas_image() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    let Ok(images) = std::env::var("NEPHROID_PARITY_DIR") else {
        println!("skipped: NEPHROID_PARITY_DIR is not set");
        return;
    };
    if !scenes.is_dir() {
        println!("skipped: there is no folder {}", scenes.display());
        return;
    }
    let files = LIST
        .lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split(" | ").next());
    let mut outcomes = Vec::new();
    for file in files {
        let image = Path::new(&images).join(format!("{}.exr", file.replace('/', "__")));
        if !image.is_file() {
            println!("{file}: no image, Mitsuba did not render it");
            continue;
        }
        let found = compare(&scenes, file, &image);
        println!("{found}");
        outcomes.push(found);
    }
    let is = |verdict| move |it: &&Outcome| it.verdict == verdict;
    let count = |verdict| outcomes.iter().filter(is(verdict)).count();
    println!(
        "{} equivalent, {} undecided, {} different",
        count(Verdict::Equivalent),
        count(Verdict::Undecided),
        count(Verdict::Different)
    );
    assert!(count(Verdict::Equivalent) >= MUST_AGREE);
}

fn compare(scenes: &Path, file: &str, image: &Path) -> Outcome {
    let mitsuba = mitsuba_image(image);
    let scene = load(&scenes.join(file), &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut sensor = scaled(&scene.sensors()[0], mitsuba.width, mitsuba.height);
    // As in `third_party.py`: pixels are independent.
    sensor.film.filter = ReconstructionFilter::Box;
    let settings = PathSettings {
        max_depth: Some(DEPTH),
        replicates: 32,
        ..PathSettings::default()
    };
    let ours = render(&scene, &sensor, settings, samples_of(&mitsuba) / SHARE);
    outcome(file, &ours, &mitsuba, sensor.film.filter.radius())
}
