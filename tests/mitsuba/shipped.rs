//! The shipped scenes in both programs, and light that starts at emitters: Mitsuba's `path` and `ptracer`
//! against ours.
//!
//! `tests/mitsuba/parity/shipped` has Mitsuba's images with their standard errors; `shipped.py` there says
//! how they were made. `docs/mitsuba.md` has the figures.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use nephroid::internals::film::Image;
use nephroid::internals::metric::Verdict;
use nephroid::internals::mitsuba::load;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::path;
use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::reference::photons;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Layer, Progress};
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::transport::chain::ChainSettings;
use nephroid::internals::transport::path_class::{PathClass, PathClasses};
use nephroid::internals::transport::scatter::ShadingNormals;

use crate::support;
use crate::support::parity::{
    Outcome, REPLICATES, image_of, mitsuba_image, outcome, render, samples_of, scaled,
};

/// Legs of a path at most, as in `shipped.py`.
const DEPTH: u32 = 16;

/// Photons of each of our images: their own error is then the smaller one.
const PHOTONS: u64 = 1 << 21;

/// Where Mitsuba's `path` sees nothing: the floor is under water that a lamp without size shines on, or
/// turned away.
const BLACK: [&str; 3] = ["parabolic-mirror", "pool", "water"];

/// Scenes of some centimetres: Mitsuba's rays start 1e-4 m off a surface (docs/mitsuba.md), which is a part
/// of a pixel there that these images can tell. They are the same within 1 %, but other images.
const TINY: [&str; 2] = ["lens", "parabolic-mirror"];

/// Probability that a test of p-values fails though all is right.
const LEVEL: f64 = 1e-3;

fn folder() -> PathBuf {
    support::parity::folder().join("shipped")
}

/// The names of the images of a kind, and the files of their scenes.
fn references(kind: &str) -> Vec<(String, PathBuf)> {
    let mut names: Vec<String> = std::fs::read_dir(folder())
        .unwrap()
        .filter_map(|entry| {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let name = name.strip_prefix(kind)?.strip_suffix(".exr")?;
            Some(name.to_owned())
        })
        .collect();
    names.sort();
    assert!(!names.is_empty());
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let file = |name: &String| {
        let own = folder().join(format!("{name}.xml"));
        if own.is_file() {
            own
        } else {
            shipped.join(format!("{name}.xml"))
        }
    };
    names
        .into_iter()
        .map(|name| (name.clone(), file(&name)))
        .collect()
}

fn reference(kind: &str, name: &str) -> Image {
    mitsuba_image(&folder().join(format!("{kind}{name}.exr")))
}

/// The camera of a scene, or the first of several, with a film of an image's size.
fn camera(scene: &Scene, image: &Image) -> Sensor {
    let is_camera = |it: &&Sensor| it.plugin() != "irradiancemeter";
    let mut cameras = scene.sensors().iter().filter(is_camera);
    let found = cameras.clone().find(|it| it.id == "camera");
    let camera = found.or_else(|| cameras.next()).unwrap();
    scaled(camera, image.width, image.height)
}

/// The sum of two layers with independent errors.
fn sum(a: &Layer, b: &Layer) -> Layer {
    let zip = |x: &[Rgb], y: &[Rgb], of: fn(f64, f64) -> f64| -> Vec<Rgb> {
        let pairs = x.iter().zip(y);
        pairs
            .map(|(x, y)| Rgb(std::array::from_fn(|c| of(x.0[c], y.0[c]))))
            .collect()
    };
    Layer {
        values: zip(&a.values, &b.values, |x, y| x + y),
        standard_error: zip(&a.standard_error, &b.standard_error, f64::hypot),
        ..a.clone()
    }
}

/// All light L S* D on a sensor. On a meter photons know all of it; a camera sees what comes straight from
/// the emitters by paths of two legs.
fn one_scattering(scene: &Scene, sensor: &Sensor, shading_normals: ShadingNormals) -> Image {
    let settings = PhotonSettings {
        replicates: REPLICATES,
        chains: ChainSettings {
            // Two legs are to the first surface and to the camera.
            max_depth: DEPTH - 2,
            shading_normals,
            ..ChainSettings::default()
        },
        ..PhotonSettings::default()
    };
    let budget = Budget {
        work: Some(PHOTONS),
        ..Budget::default()
    };
    let traced = photons::run(scene, sensor, settings, &budget, &Progress::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let total = if sensor.plugin() == "irradiancemeter" {
        traced.total
    } else {
        let direct = PathSettings {
            replicates: REPLICATES,
            max_depth: Some(2),
            // `shipped.py` hides lamps, which it cannot dim.
            classes: PathClasses::NONE.with(PathClass::Direct),
            ..PathSettings::default()
        };
        let samples = Budget {
            work: Some(64 * u64::from(REPLICATES)),
            ..Budget::default()
        };
        let direct = path::run(scene, sensor, direct, &samples, &Progress::default());
        sum(&traced.total, &direct.unwrap().0.total)
    };
    image_of(&total, traced.width, traced.height)
}

/// Prints the outcomes and asserts that each is the same within 1 %.
fn assert_equivalent(outcomes: &[Outcome]) {
    for outcome in outcomes {
        println!("{outcome}");
    }
    for outcome in outcomes {
        assert_eq!(outcome.verdict, Verdict::Equivalent, "{outcome}");
    }
}

/// Asserts that no p-value of all is too small (Šidák).
fn assert_no_structure(outcomes: &[Outcome]) {
    let p_values: Vec<f64> = (outcomes.iter())
        .filter(|it| !TINY.contains(&it.name.as_str()))
        .flat_map(|it| it.uniformity.into_iter().chain([it.extreme]))
        .collect();
    let threshold = 1.0 - (1.0 - LEVEL).powf(1.0 / p_values.len() as f64);
    let least = p_values.iter().copied().fold(1.0, f64::min);
    assert!(least >= threshold, "p {least} is below {threshold}");
}

/// p-values are not judged: a pixel that one or two of 2048 samples decide, at the edge of a shadow or where
/// light by way of glass is found by chance, has no normal error. `parity.rs` has scenes where all pixels do.
#[test]
fn every_shipped_scene_makes_mitsubas_image_by_paths() {
    let mut outcomes = Vec::new();
    for (name, file) in references("path-") {
        let mitsuba = reference("path-", &name);
        let scene = load(&file, &[]).unwrap();
        let sensor = camera(&scene, &mitsuba);
        let settings = PathSettings {
            max_depth: Some(DEPTH),
            replicates: 32,
            ..PathSettings::default()
        };
        // As many as in `parity.rs`.
        let ours = render(&scene, &sensor, settings, samples_of(&mitsuba) / 4);
        if BLACK.contains(&name.as_str()) {
            for image in [&ours, &mitsuba] {
                let is_black = |samples: &[f32]| samples.iter().all(|it| *it == 0.0);
                assert!(
                    image.channels.iter().all(|it| is_black(&it.samples)),
                    "{name}"
                );
            }
        } else {
            outcomes.push(outcome(&name, &ours, &mitsuba, sensor.film.filter.radius()));
        }
    }
    assert_eq!(outcomes.len(), 16);
    assert_equivalent(&outcomes);
}

#[test]
fn light_from_emitters_makes_the_image_of_mitsubas_ptracer() {
    let mut outcomes = Vec::new();
    for (name, file) in references("ptracer-") {
        let mitsuba = reference("ptracer-", &name);
        let scene = load(&file, &[]).unwrap();
        let sensor = camera(&scene, &mitsuba);
        let ours = one_scattering(&scene, &sensor, ShadingNormals::Adjoint);
        outcomes.push(outcome(&name, &ours, &mitsuba, sensor.film.filter.radius()));
    }
    assert_eq!(outcomes.len(), 21);
    assert_equivalent(&outcomes);
    assert_no_structure(&outcomes);
}

/// Mitsuba's meter is blind to lamps without size, and its `ptracer` to meters. A camera that looks at a matt
/// floor sees its irradiance: E = π L / ρ.
///
/// p-values of smooth glass are not judged: in the ball's shadow a texel has a few of Mitsuba's photons, and no
/// normal error.
#[test]
fn an_irradiancemeters_map_is_what_mitsubas_camera_sees_of_the_floor() {
    const ALBEDO: f64 = 0.8;
    let mut outcomes = Vec::new();
    for (name, file) in references("floor-") {
        let mut mitsuba = reference("floor-", &name);
        for samples in mitsuba.channels.iter_mut().map(|it| &mut it.samples) {
            for value in samples {
                *value = (f64::from(*value) * PI / ALBEDO) as f32;
            }
        }
        let size = ("size".to_owned(), mitsuba.width.to_string());
        let scene = load(&file, &[size]).unwrap();
        let meter = scene.sensors().iter().find(|it| it.id == "floor").unwrap();
        let ours = one_scattering(&scene, meter, ShadingNormals::Adjoint);
        outcomes.push(outcome(&name, &ours, &mitsuba, meter.film.filter.radius()));
    }
    assert_eq!(outcomes.len(), 9);
    assert_equivalent(&outcomes);
    // Rough glass and metal spread light, so that texels have enough of it.
    outcomes.retain(|it| it.name.starts_with("rough-"));
    assert_no_structure(&outcomes);
}

#[test]
fn photons_without_the_adjoint_of_shading_normals_are_another_image() {
    let (name, file) = ("pebble", folder().join("pebble.xml"));
    let mitsuba = reference("ptracer-", name);
    let scene = load(&file, &[]).unwrap();
    let sensor = camera(&scene, &mitsuba);
    let flux = one_scattering(&scene, &sensor, ShadingNormals::Flux);
    let found = outcome(name, &flux, &mitsuba, sensor.film.filter.radius());
    println!("{found}");
    // In the mean over the image little is gained or lost: it is where light falls that differs.
    let p = found.uniformity.unwrap().min(found.extreme);
    assert!(found.verdict == Verdict::Different || p < 1e-4, "{found}");
}

#[test]
fn references_were_rendered_from_the_scenes_as_they_are() {
    for kind in ["path-", "ptracer-", "floor-"] {
        for (name, file) in references(kind) {
            let mut crc = flate2::Crc::new();
            crc.update(&std::fs::read(file).unwrap());
            assert_eq!(
                reference(kind, &name).metadata("scene-crc32"),
                Some(format!("{:08x}", crc.sum()).as_str()),
                "run tests/mitsuba/parity/shipped/shipped.py {kind}{name}"
            );
        }
    }
}
