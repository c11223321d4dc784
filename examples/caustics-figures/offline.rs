//! The paper's Fig. 3: its best settings beside a path tracer's picture.

use std::time::Instant;

use nephroid::internals::method::Method;
use nephroid::internals::metric::{Figure, LayerComparison};
use nephroid::internals::mitsuba;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::{Budget, Context, Estimate};
use nephroid::internals::scene::{Scene, Sensor};

use crate::judge::{Judge, OBJECTS, Object, likely_l1, sum, values};
use crate::support::figures::{compared, shown, table};
use crate::support::light_volume::sensor;
use crate::support::scenes::bundled_file;

/// Pixels a row of the camera, and rows.
const PIXELS: usize = 32;

/// Rows at the top that are left out: one of them has the lamp, of 30,000 W/m²/sr on a twentieth of a pixel. Its
/// noise would be nearly all of an image's error.
const LAMP_ROWS: u32 = 8;

/// Samples a pixel of the paper's references.
const SAMPLES: u64 = 2000;

/// Radius of the lamp [m].
const LAMP: f64 = 0.02;

/// Samples a pixel, and photons, of the truth that the path tracer is held against.
const TRUTH: u64 = 256;

fn shown_to_eyes(found: &LayerComparison) -> [String; 2] {
    [
        found
            .similarity
            .map_or("-".into(), |it| three_digits(it.ssim)),
        found.flip.map_or("-".into(), |it| three_digits(it.mean)),
    ]
}

/// The scene with a disc in the place of its lamp, of the same intensity downwards.
fn with_lamp(object: &Object) -> Scene {
    let shipped = bundled_file("cornell-caustics");
    let text = std::fs::read_to_string(&shipped).unwrap();
    let (before, rest) = text
        .split_once(r#"<emitter type="spot" id="lamp">"#)
        .unwrap();
    let (_, after) = rest.split_once("</emitter>").unwrap();
    let radiance = 38.025 / (std::f64::consts::PI * LAMP * LAMP);
    let lamp = format!(
        r#"<shape type="disk"><transform name="to_world"><scale value="{LAMP}"/><rotate x="1" angle="180"/>
            <translate z="1.95"/></transform><emitter type="area"><rgb name="radiance"
            value="{radiance}, {radiance}, {radiance}"/></emitter></shape>"#
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, [before, &lamp, after].concat()).unwrap();
    // What it includes is beside it.
    for entry in std::fs::read_dir(shipped.parent().unwrap()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name.starts_with("cornell-caustics-") {
            std::fs::copy(&path, folder.path().join(name)).unwrap();
        }
    }
    let side = PIXELS.to_string();
    let parameters = [("object", object.name), ("width", &side), ("height", &side)]
        .map(|(key, value)| (key.to_owned(), value.to_owned()));
    mitsuba::load(&file, &parameters).unwrap()
}

/// The camera, without the rows of the lamp.
fn below_lamp(scene: &Scene) -> Sensor {
    let mut sensor = sensor(scene, "view").clone();
    sensor.film.crop.offset_y += LAMP_ROWS;
    sensor.film.crop.height -= LAMP_ROWS;
    sensor
}

fn of_view(name: &str, scene: &Scene, sensor: &Sensor, samples: u64) -> Estimate {
    let clock = Instant::now();
    let mut method = Method::new(name, &std::collections::BTreeMap::new()).unwrap();
    method = method.with("max-depth", "12").unwrap();
    let budget = Budget::work(samples);
    let found = method.run(scene, sensor, &budget, &Context::default());
    let seconds = clock.elapsed().as_secs_f64();
    eprintln!("{name}, {samples} samples a pixel: {seconds:.1} s");
    found.expect("a camera").estimate
}

/// Floors with our caustic in the truth's place.
pub fn offline(judge: &mut Judge) -> Vec<String> {
    let mut floors = Vec::new();
    for object in &OBJECTS {
        let case = judge.floor(object);
        let all = sum(&case.direct, &case.truth.modelled);
        let mut cells = vec![object.row()];
        for settings in [vec![], vec![("emission", "exact"), ("interface", "exact")]] {
            let ours = values(&object.volume(&settings), &case.scene, "floor");
            let found = compared(&case.scene, case.sensor(), &all, &sum(&case.direct, &ours));
            cells.extend(shown_to_eyes(&found));
            cells.push(shown(&case.seen(&ours).fidelity, Figure::Displaced));
        }
        let without = compared(&case.scene, case.sensor(), &all, &case.direct);
        cells.extend(shown_to_eyes(&without));
        floors.push(cells);
    }
    vec![table(
        &[
            "scene",
            ">SSIM",
            ">FLIP",
            ">displaced [texels]",
            ">light right: SSIM",
            ">FLIP",
            ">displaced",
            ">no caustic: SSIM",
            ">FLIP",
        ],
        &floors,
    )]
}

/// A path tracer's error on the camera. It takes five minutes on two cores, most of it for truths.
pub fn paths() -> Vec<String> {
    let mut lines = Vec::new();
    for object in &OBJECTS {
        eprintln!("{}", object.row());
        let scene = with_lamp(object);
        let sensor = below_lamp(&scene);
        let truth = of_view("full", &scene, &sensor, TRUTH);
        let own = likely_l1(&truth.total.values, &truth.total.standard_error);
        let mut cells = vec![object.row(), three_digits(100.0 * own)];
        for samples in [SAMPLES / 8, SAMPLES] {
            let found = of_view("path", &scene, &sensor, samples).total.values;
            let found = compared(&scene, &sensor, &truth.total.values, &found);
            cells.extend(shown_to_eyes(&found));
            cells.push(shown(&found.fidelity, Figure::L1));
        }
        lines.push(cells);
    }
    vec![table(
        &[
            "scene",
            ">the truth's own likely L1, %",
            ">`path`, 250 spp: SSIM",
            ">FLIP",
            ">L1, %",
            ">2,000 spp: SSIM",
            ">FLIP",
            ">L1, %",
        ],
        &lines,
    )]
}
