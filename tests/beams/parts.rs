//! Beams in parts, as several machines would make them: the bits of a run in one piece.

use nephroid::internals::mitsuba;
use nephroid::internals::reference::beams::film::BeamFilm;
use nephroid::internals::reference::beams::inputs::BeamInputs;
use nephroid::internals::reference::beams::piece::Piece;
use nephroid::internals::reference::beams::run::Setup;
use nephroid::internals::reference::beams::traced::BatchSums;
use nephroid::internals::reference::beams::{BeamReport, BeamSettings, Chaotic, run};
use nephroid::internals::reference::parts::beams::{MOST_BYTES, next, run_part};
use nephroid::internals::reference::parts::{Gathered, Next, Part, Step, Wanted};
use nephroid::internals::reference::shard::Shard;
use nephroid::internals::run::{Budget, Estimate, Progress};
use nephroid::internals::scene::Scene;
use serde_json::Value;

use crate::support::bundled;
use crate::support::scenes::{below_bumps, meter};

/// All that a run finds, to the last bit.
fn all((estimate, report): &(Estimate, BeamReport)) -> String {
    format!("{estimate:?} {report:?}")
}

/// A run under way, in parts.
struct InParts<'a> {
    scene: &'a Scene,
    settings: BeamSettings,
    budget: Budget,
    layer_error: &'a [(&'a str, f64)],
    most_bytes: usize,
    gathered: Gathered,
}

impl<'a> InParts<'a> {
    fn new(scene: &'a Scene, settings: BeamSettings, budget: Budget) -> Self {
        Self {
            scene,
            settings,
            budget,
            layer_error: &[],
            most_bytes: MOST_BYTES,
            gathered: Gathered::default(),
        }
    }

    /// What the run needs next, or what it finds.
    fn next(&self) -> Next<(Estimate, BeamReport)> {
        let (sensor, progress) = (meter(self.scene), Progress::default());
        let mut setup = Setup::new(self.scene, sensor, self.settings, &progress).unwrap();
        setup.ask(self.layer_error).unwrap();
        let (budget, gathered) = (&self.budget, &self.gathered);
        next(&mut setup, &sensor.id, budget, gathered, self.most_bytes).unwrap()
    }

    /// The bytes of a part of a piece.
    fn part(&self, wanted: &Wanted, shard: Shard) -> Vec<u8> {
        let (sensor, progress) = (meter(self.scene), Progress::default());
        let Step::Piece(piece) = told(&wanted.step) else {
            panic!("{wanted:?}");
        };
        let inputs = BeamInputs::new(self.scene, sensor, self.settings).unwrap();
        let (settings, id) = (&self.settings, &sensor.id);
        let part = run_part(&inputs, settings, id, &piece, shard, &progress);
        let mut bytes = Vec::new();
        part.unwrap().unwrap().write_to(&mut bytes).unwrap();
        bytes
    }

    /// What the run finds whose pieces are made in so many parts, the last first; and their number.
    fn found(mut self, count: u32) -> ((Estimate, BeamReport), usize) {
        let mut keys = Vec::new();
        loop {
            let wanted = match self.next() {
                Next::Done(found) => return (*found, keys.len()),
                Next::Step(wanted) => *wanted,
            };
            assert!(!keys.contains(&wanted.key), "{wanted:?}");
            assert!(wanted.work > 0 && wanted.most_parts > 0, "{wanted:?}");
            for index in (0..count).rev() {
                let shard = Shard { index, count };
                let bytes = self.part(&wanted, shard);
                let part = Part::read_from(&bytes[..]).unwrap();
                self.gathered.add(&wanted, shard, part).unwrap();
            }
            keys.push(wanted.key);
        }
    }
}

/// A step as a worker is told of it.
fn told(step: &Step) -> Step {
    let text = serde_json::to_string(step).unwrap();
    let told = serde_json::from_str(&text).unwrap();
    assert_eq!(*step, told, "a number has lost bits: {text}");
    told
}

/// Returns the number of passes.
fn assert_parts_have_the_bits_of_the_whole(
    run_in_parts: impl Fn() -> InParts<'static>,
    name: &str,
    counts: &[u32],
) -> u32 {
    let whole = {
        let asked = run_in_parts();
        let (sensor, progress) = (meter(asked.scene), Progress::default());
        let mut setup = Setup::new(asked.scene, sensor, asked.settings, &progress).unwrap();
        setup.ask(asked.layer_error).unwrap();
        setup.run(&asked.budget).unwrap()
    };
    for count in counts.iter().copied() {
        let (found, pieces) = run_in_parts().found(count);
        assert!(all(&found) == all(&whole), "{name} in {count} parts");
        assert!(pieces as u32 >= whole.1.passes, "{name}: {pieces} pieces");
    }
    whole.1.passes
}

fn held(scene: Scene) -> &'static Scene {
    Box::leak(Box::new(scene))
}

#[test]
fn parts_have_the_bits_of_the_whole_run() {
    // Smooth cells of one channel, of three, in front of a camera; flat facets, whose polygons several
    // signatures share; and above hills, whose light one thread leaves to others.
    let mut passes = Vec::new();
    for (name, error) in [
        ("glass-ball", 1e-4),
        ("cornell-caustics", 0.02),
        ("turntable-ball", 0.02),
        ("diamond", 0.01),
        ("cube", 0.01),
        ("turntable-terrain", 0.1),
    ] {
        let scene = held(bundled(name, 24));
        let asked = || InParts::new(scene, BeamSettings::default(), Budget::error(error));
        passes.push(assert_parts_have_the_bits_of_the_whole(
            asked,
            name,
            &[1, 3, 7],
        ));
    }
    // The tolerances of a second pass come from the sums of the first.
    assert!(passes.iter().any(|passes| *passes > 1), "{passes:?}");
}

#[test]
fn parts_have_the_bits_of_the_whole_if_films_of_a_pass_do_not_fit_together() {
    let scene = held(bundled("glass-ball", 24));
    let asked = || InParts {
        // One batch a piece.
        most_bytes: 1,
        ..InParts::new(scene, BeamSettings::default(), Budget::error(0.01))
    };
    let passes = assert_parts_have_the_bits_of_the_whole(asked, "one batch a piece", &[2]);
    assert!(asked().found(1).1 as u32 > passes);
}

#[test]
fn parts_have_the_bits_of_the_whole_if_there_are_several_lights() {
    // Smooth cells and flat facets, of two lights and of a third with a cone.
    let lamp = |x: f64| {
        format!(r#"<emitter type="point"><point name="position" value="{x}, 0.3, 3"/></emitter>"#)
    };
    let text = format!(
        r#"<scene version="3.0.0">
            <shape type="rectangle">
                <transform name="to_world"><scale value="2"/><translate z="-0.6"/></transform>
                <sensor type="irradiancemeter" id="floor"><film type="hdrfilm">
                    <integer name="width" value="24"/><integer name="height" value="24"/>
                </film></sensor>
            </shape>
            <shape type="sphere"><float name="radius" value="0.4"/><bsdf type="dielectric"/></shape>
            <shape type="cube">
                <transform name="to_world"><scale value="0.3"/><rotate y="1" angle="20"/><translate x="1"/></transform>
                <bsdf type="dielectric"/>
            </shape>
            {}{}
            <emitter type="spot">
                <float name="cutoff_angle" value="20"/>
                <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
            </emitter>
        </scene>"#,
        lamp(0.2),
        lamp(-0.7)
    );
    let path = std::path::absolute("lights.xml").unwrap();
    let file = [(path.clone(), text.into_bytes())];
    let (scene, _) = mitsuba::load_held(&path, &[], &file, false).unwrap();
    let scene = held(scene);
    let asked = || InParts::new(scene, BeamSettings::default(), Budget::error(0.02));
    assert_parts_have_the_bits_of_the_whole(asked, "three lights", &[3]);
}

#[test]
fn parts_have_the_bits_of_the_whole_if_layers_have_errors_of_their_own() {
    let scene = held(bundled("glass-ball", 24));
    let asked = || InParts {
        layer_error: &[("LTRRTD", 0.01)],
        ..InParts::new(scene, BeamSettings::default(), Budget::error(0.03))
    };
    assert_parts_have_the_bits_of_the_whole(asked, "a layer's error", &[3]);
}

#[test]
fn parts_have_the_bits_of_the_whole_if_photons_measure_some_light() {
    let scene = held(below_bumps(16, true, [0.0, 0.0, 4.0], 24));
    let settings = BeamSettings {
        max_layers: 6,
        ..BeamSettings::default()
    };
    let budget = Budget::error(0.05);
    let progress = Progress::default();
    let (_, report) = run(scene, meter(scene), settings, &budget, &progress).unwrap();
    assert!(report.by_photons.is_some(), "no light is for photons");
    let asked = || InParts::new(scene, settings, budget);
    assert_parts_have_the_bits_of_the_whole(asked, "chaotic light", &[3]);
}

#[test]
fn a_dark_scene_needs_no_part() {
    let scene = held(bundled("glass-ball", 8));
    let settings = BeamSettings {
        max_depth: 0,
        ..BeamSettings::default()
    };
    let asked = || InParts::new(scene, settings, Budget::error(0.1));
    assert_parts_have_the_bits_of_the_whole(asked, "dark", &[2]);
    assert_eq!(asked().found(2).1, 0);
}

/// The first piece of the glass ball, and a run that needs it.
fn begun() -> (InParts<'static>, Wanted) {
    let scene = held(bundled("glass-ball", 16));
    let asked = InParts::new(scene, BeamSettings::default(), Budget::error(0.05));
    let Next::Step(wanted) = asked.next() else {
        panic!("nothing to do");
    };
    (asked, *wanted)
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let (mut asked, wanted) = begun();
    let (first, second) = (Shard { index: 0, count: 2 }, Shard { index: 1, count: 2 });
    let bytes = asked.part(&wanted, first);
    // Each cut, in the header, the films and the balances, is an error.
    for part in [1, 40, 90, 99] {
        let cut = &bytes[..bytes.len() * part / 100];
        assert!(Part::read_from(cut).is_err(), "{part} %");
    }
    let mut add = |shard, bytes: &[u8]| {
        let part = Part::read_from(bytes).unwrap();
        let added = asked.gathered.add(&wanted, shard, part);
        added.map_err(|error| error.to_string())
    };
    assert!(add(second, &bytes).unwrap_err().contains("the shard"));
    add(first, &bytes).unwrap();
    assert!(
        add(first, &bytes)
            .unwrap_err()
            .contains("each of them once")
    );
    // A part of the same piece at another tolerance.
    let other = InParts {
        budget: Budget::error(0.01),
        ..begun().0
    };
    let Next::Step(finer) = other.next() else {
        panic!("nothing to do");
    };
    let error = add(second, &other.part(&finer, second)).unwrap_err();
    assert!(error.contains("the list of settings"), "{error}");
}

#[test]
fn a_piece_ends_once_its_work_is_far_beyond_the_forecast() {
    let (asked, wanted) = begun();
    let scene = asked.scene;
    let progress = Progress::default();
    let inputs = BeamInputs::new(scene, meter(scene), asked.settings).unwrap();
    let Step::Piece(piece) = wanted.step else {
        panic!("no piece");
    };
    let trace = |most: Option<u64>, shard: Shard| {
        let mut text = serde_json::to_value(&piece).unwrap();
        text["most_work"] = most.into();
        let piece: Piece = serde_json::from_value(text).unwrap();
        piece.trace(&inputs, shard, &progress).unwrap().unwrap()
    };
    let work = |sums: &[BatchSums]| sums.iter().map(BatchSums::work).sum::<u64>();
    let is_beyond = |sums: &[BatchSums]| {
        sums.iter()
            .any(|one| matches!(one, BatchSums::Beyond { .. }))
    };
    let all = trace(Some(u64::MAX), Shard::WHOLE);
    assert!(!is_beyond(&all) && work(&all) > 1000);
    // All of it fits, and one less does not.
    assert!(!is_beyond(&trace(Some(work(&all)), Shard::WHOLE)));
    assert!(is_beyond(&trace(Some(work(&all) - 1), Shard::WHOLE)));
    // Each half fits, and both together have as much work as the whole.
    let mut halves = [0, 1].map(|index| trace(Some(work(&all) - 1), Shard { index, count: 2 }));
    assert!(halves.iter().all(|half| !is_beyond(half)));
    assert_eq!(work(&halves[0]) + work(&halves[1]), work(&all));
    // What one part has given up is given up.
    let beyond = trace(Some(1), Shard { index: 0, count: 2 });
    for (sums, other) in halves[1].iter_mut().zip(beyond) {
        let both = sums.work() + other.work();
        sums.merge(other).unwrap();
        assert!(matches!(sums, BatchSums::Beyond { work } if *work == both));
    }
}

#[test]
fn a_run_that_is_divided_has_an_error_for_a_limit() {
    let scene = bundled("glass-ball", 8);
    let (sensor, progress) = (meter(&scene), Progress::default());
    let settings = BeamSettings {
        chaotic: Chaotic::Beams,
        ..BeamSettings::default()
    };
    let mut setup = Setup::new(&scene, sensor, settings, &progress).unwrap();
    for budget in [
        Budget::work(1000),
        Budget::time(std::time::Duration::from_secs(1)),
    ] {
        let gathered = Gathered::default();
        let found = next(&mut setup, &sensor.id, &budget, &gathered, MOST_BYTES);
        let error = found.unwrap_err().to_string();
        assert!(error.contains("neither --time nor --rays"), "{error}");
    }
}

/// The run's result if the only part of its first piece is made of these bytes, with a hash that fits.
fn next_with(asked: &InParts, wanted: &Wanted, forged: &[u8]) -> Result<(), String> {
    let sealed = [forged, blake3::hash(forged).as_bytes()].concat();
    let mut gathered = Gathered::default();
    let part = Part::read_from(&sealed[..]).map_err(|error| error.to_string())?;
    let added = gathered.add(wanted, Shard::WHOLE, part);
    added.map_err(|error| error.to_string())?;
    let (sensor, progress) = (meter(asked.scene), Progress::default());
    let mut setup = Setup::new(asked.scene, sensor, asked.settings, &progress).unwrap();
    let (budget, id) = (&asked.budget, &sensor.id);
    let found = next(&mut setup, id, budget, &gathered, MOST_BYTES);
    found.map(drop).map_err(|error| error.to_string())
}

/// Number of films and of tasks of each batch that a header tells.
fn extents(header: &Value) -> Vec<[usize; 2]> {
    match header {
        Value::Object(fields) if fields.contains_key("films") => {
            vec![["films", "tasks"].map(|key| fields[key].as_u64().unwrap() as usize)]
        }
        Value::Object(fields) => fields.values().flat_map(extents).collect(),
        Value::Array(all) => all.iter().flat_map(extents).collect(),
        _ => Vec::new(),
    }
}

/// Twice the quantum makes twice the light, and three channels are dark.
#[test]
fn parts_with_films_of_another_scale_or_of_other_channels_are_refused() {
    let (asked, wanted) = begun();
    let bytes = asked.part(&wanted, Shard::WHOLE);
    let contents = &bytes[..bytes.len() - blake3::OUT_LEN];
    assert_eq!(next_with(&asked, &wanted, contents), Ok(()));
    let mut lines = contents.splitn(3, |byte| *byte == b'\n');
    let [magic, header, body] = [(); 3].map(|()| lines.next().unwrap());
    let header = std::str::from_utf8(header).unwrap();
    let refused = |header: &str, body: &[u8]| {
        let forged = [magic, header.as_bytes(), body].join(&b'\n');
        next_with(&asked, &wanted, &forged).unwrap_err()
    };
    let at = header.find("\"exponent\":").unwrap() + "\"exponent\":".len();
    let end = at + header[at..].find([',', '}']).unwrap();
    let exponent: i32 = header[at..end].parse().unwrap();
    let doubled = format!("{}{}{}", &header[..at], exponent + 1, &header[end..]);
    let error = refused(&doubled, body);
    assert!(error.contains("of other tasks"), "{error}");
    // Whole, but dark: each task has a number, and nothing to tell of any signature.
    let mut dark = Vec::new();
    for [films, tasks] in extents(&serde_json::from_str(header).unwrap()) {
        dark.resize(dark.len() + films * BeamFilm::<3>::numbers([16, 16]), 0);
        dark.extend((0..tasks as u64).flat_map(|number| [number, 0]));
    }
    let dark: Vec<u8> = dark.into_iter().flat_map(u64::to_le_bytes).collect();
    let error = refused(&header.replace("\"grey\"", "\"colours\""), &dark);
    assert!(error.contains("of other tasks"), "{error}");
}

#[test]
fn forged_parts_are_refused_or_make_some_film() {
    let (asked, wanted) = begun();
    let bytes = asked.part(&wanted, Shard::WHOLE);
    let contents = &bytes[..bytes.len() - blake3::OUT_LEN];
    let mut refused = 0;
    let mut enter = |forged: &[u8]| {
        refused += usize::from(next_with(&asked, &wanted, forged).is_err());
    };
    let lines: Vec<usize> = contents
        .iter()
        .enumerate()
        .filter(|(_, byte)| **byte == b'\n')
        .map(|(at, _)| at)
        .take(2)
        .collect();
    // Each number of the header's sums, once very large and once nothing; then words of films and of balances.
    let header = std::str::from_utf8(&contents[lines[0]..lines[1]]).unwrap();
    let sums = lines[0] + header.rfind("\"sums\"").unwrap();
    let mut numbers = 0;
    for at in sums..lines[1] {
        if contents[at].is_ascii_digit() && !contents[at - 1].is_ascii_digit() {
            let end = (at..).find(|at| !contents[*at].is_ascii_digit()).unwrap();
            for number in ["0", "18446744073709551615", "999999999999"] {
                enter(&[&contents[..at], number.as_bytes(), &contents[end..]].concat());
            }
            numbers += 1;
        }
    }
    assert!(numbers > 6);
    let body = lines[1] + 1;
    let words = (contents.len() - body) / 8;
    for word in (0..words).step_by(words / 24).chain(words - 24..words) {
        let at = body + 8 * word;
        for forged in [i64::MAX.to_le_bytes(), f64::NAN.to_le_bytes()] {
            enter(&[&contents[..at], &forged, &contents[at + 8..]].concat());
        }
    }
    assert!(refused > numbers);
}
