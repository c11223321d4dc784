//! Files with a few bytes changed.

use std::cell::{Cell, RefCell};

use flate2::Compression;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::run::Budget;
use nephroid::internals::run::Progress;
use nephroid::internals::scene::Scene;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestCaseResult, TestRunner};
use tempfile::TempDir;

use super::honest::{KINDS, Kind, honest_peak};
use super::watch::{Outcome, TIMES_HONEST, alone, load, watched};
use crate::support::geometry::icosphere;
use crate::support::mutation::{
    Mutation, NUMBER, PACKINGS, film, mutate, mutations, one_or_more_mutations, serialized,
    serialized_contents,
};

/// A scene with a little of all that a scene file may say.
pub const SCENE: &str = r##"<?xml version="1.0"?>
<scene version="3.0.0"><default name="size" value="8"/>
<integrator type="path"><integer name="max_depth" value="$size"/></integrator>
<emitter type="point"><point name="position" x="0" y="0" z="4"/><rgb name="intensity" value="100, 90, 80"/></emitter>
<emitter type="directional"><vector name="direction" x="0" y="0.1" z="-1"/><rgb name="irradiance" value="1"/></emitter>
<bsdf type="dielectric" id="glass"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1.0"/></bsdf><alias id="glass" as="ice"/>
<shape type="sphere"><point name="center" x="0" y="0" z="1.4"/><float name="radius" value="0.5"/><ref id="ice"/></shape>
<shape type="cube"><transform name="to_world"><scale value="0.3"/><rotate x="1" angle="30"/><translate x="1" z="1"/></transform><ref id="glass"/></shape>
<shape type="cylinder"><point name="p0" x="-1" y="0" z="0.5"/><point name="p1" x="-1" y="1" z="1"/><float name="radius" value="0.2"/><bsdf type="conductor"><string name="material" value="Al"/></bsdf></shape>
<shape type="disk"><transform name="to_world"><translate x="-1" y="-1" z="1"/></transform><bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="twosided"><bsdf type="conductor"/></bsdf></bsdf></shape>
<shape type="shapegroup" id="group"><shape type="sphere"><ref id="glass"/></shape></shape>
<shape type="instance"><ref id="group"/><transform name="to_world"><matrix value="0.1 0 0 0 0 0.1 0 1 0 0 0.1 1 0 0 0 1"/></transform></shape>
<shape type="rectangle"><bsdf type="diffuse"><rgb name="reflectance" value="#ff8000"/></bsdf>
<sensor type="irradiancemeter"><film type="hdrfilm"><integer name="width" value="$size"/><integer name="height" value="$size"/><rfilter type="box"/></film></sensor></shape>
</scene>
"##;

/// Runs a test on 128 of the inputs.
fn for_changes<T: Strategy>(inputs: &T, test: impl Fn(T::Value) -> TestCaseResult) {
    let mut runner = TestRunner::new(ProptestConfig {
        cases: CASES,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    });
    if let Err(error) = runner.run(inputs, test) {
        panic!("{error}");
    }
}

const CASES: u32 = 128;

#[test]
fn a_changed_mesh_or_image_takes_at_most_four_times_what_an_honest_one_takes() {
    let _alone = alone();
    // Every kind; what a serialized file holds, changed before it is packed: else its checksum tells; films
    // packed in every way.
    type Changed = Box<dyn Fn(&[Mutation]) -> Vec<u8>>;
    let mut files: Vec<(String, Kind, Changed)> = KINDS
        .map(|kind| -> (String, Kind, Changed) {
            let original = kind.honest(2);
            let changed = move |changes: &[Mutation]| mutate(&original, changes);
            (format!("{kind:?}"), kind, Box::new(changed))
        })
        .into();
    let contents = serialized_contents(&icosphere(2));
    files.push((
        "contents of Serialized".to_owned(),
        Kind::Serialized,
        Box::new(move |changes| serialized(&mutate(&contents, changes), Compression::none())),
    ));
    for packing in PACKINGS {
        let original = film(80, 4, packing, false);
        files.push((
            format!("Film by {packing:?}"),
            Kind::Film,
            Box::new(move |changes| mutate(&original, changes)),
        ));
    }
    let read = RefCell::new(vec![0; files.len()]);
    let most = RefCell::new(vec![0.0_f64; files.len()]);
    for_changes(&one_or_more_mutations(), |changes| {
        for (index, (name, kind, changed)) in files.iter().enumerate() {
            let changed = changed(&changes);
            let outcome = kind.load(&changed);
            let times = outcome.peak as f64 / kind.need(&changed).peak_of_any(changed.len());
            read.borrow_mut()[index] += u32::from(outcome.result.is_ok());
            let most = &mut most.borrow_mut()[index];
            *most = most.max(times);
            prop_assert!(
                times <= TIMES_HONEST,
                "{name}: {} bytes of heap for a file of {} bytes, {times} times what is honest",
                outcome.peak,
                changed.len()
            );
        }
        Ok(())
    });
    for (index, (name, ..)) in files.iter().enumerate() {
        let (read, most) = (read.borrow()[index], most.borrow()[index]);
        println!(
            "{name}: {read} of {CASES} are read; at most {most:.2} times the heap of an honest one"
        );
        // Neither are all refused at sight nor all too little changed to matter. But zlib's checksum tells
        // nearly every change.
        let has_checksum = ["Serialized", "Film by ZIP", "Film by PXR24"]
            .iter()
            .any(|start| name.starts_with(start));
        let least = if has_checksum { 0 } else { 3 };
        assert!((least..CASES).contains(&read), "{name}: {read} are read");
    }
}

#[test]
fn a_changed_scene_is_refused_or_runs() {
    let _alone = alone();
    // Few scenes survive any change; where numbers become others, many do.
    let numbers = mutations().prop_map(|mut changes| {
        changes.iter_mut().for_each(|(_, kind, _)| *kind = NUMBER);
        changes
    });
    let (read, most) = (Cell::new(0), Cell::new(0.0_f64));
    let honest = honest_peak(|| load_text(SCENE.as_bytes()).peak);
    for_changes(&prop_oneof![mutations(), numbers], |changes| {
        let changed = mutate(SCENE.as_bytes(), &changes);
        let outcome = load_text(&changed);
        let honest = honest * (changed.len() as f64 / SCENE.len() as f64).max(1.0);
        most.set(most.get().max(outcome.peak as f64 / honest));
        prop_assert!(
            outcome.peak as f64 <= TIMES_HONEST * honest,
            "{} bytes of heap, where an honest one takes {honest}",
            outcome.peak
        );
        if let Ok(scene) = outcome.result {
            read.set(read.get() + 1);
            let changed = String::from_utf8_lossy(&changed).into_owned();
            drop(watched(&changed, move || a_few_photons(&scene)));
        }
        Ok(())
    });
    println!(
        "{} of {CASES} changed scenes are read and run; at most {:.2} times the heap of an honest one",
        read.get(),
        most.get()
    );
    assert!(read.get() >= CASES / 10, "{} scenes are read", read.get());
}

pub fn load_text(text: &[u8]) -> Outcome<Scene> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, text).unwrap();
    load(&file)
}

/// Runs photons on all small films; what is refused is refused.
fn a_few_photons(scene: &Scene) -> Result<(), String> {
    for sensor in scene.sensors() {
        // Larger ones are honest, and the command line says what they take.
        if sensor.film.width.max(sensor.film.height) > 64 {
            continue;
        }
        let progress = Progress::default();
        let budget = Budget {
            work: Some(256),
            ..Budget::default()
        };
        let estimate = Setup::new(scene, sensor, PhotonSettings::default(), &progress)
            .and_then(|setup| setup.run(&budget))
            .map_err(|error| error.to_string())?;
        // A film's quantum is that of the brightest channel: what is dim beside it closes to as much less.
        let emitted = estimate.ledger.emitted;
        let dimmest = emitted
            .0
            .into_iter()
            .filter(|&flux| flux > 0.0)
            .fold(f64::INFINITY, f64::min);
        let allowed = 1e-12 * (emitted.max_channel() / dimmest).max(1.0);
        let closure = estimate.ledger.closure_error();
        assert!(
            closure.is_none_or(|error| error < allowed),
            "{closure:?}, {allowed:e} allowed"
        );
    }
    Ok(())
}
