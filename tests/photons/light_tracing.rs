//! Photons connected to a camera (light tracing): paths L S+ D E, by the photon loop that fills receivers.

use std::sync::OnceLock;

use glam::DVec2;

use nephroid::internals::mitsuba;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::beams;
use nephroid::internals::reference::beams::BeamSettings;
use nephroid::internals::reference::parts::Divided;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::reference::shard::Shard;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, Layer, LayerName, Progress, Quantity};
use nephroid::internals::scene::{Color, Material, ReconstructionFilter, Scene};
use nephroid::internals::transport::camera::Camera;

use crate::support;
use crate::support::parts;
use crate::support::seen::{self, FloorView, Map, sensor, with_films};
use crate::support::student;

const WIDTH: usize = 80;
const HEIGHT: usize = 60;
const TEXELS: usize = 512;
const ALBEDO: f64 = 0.8;
const PHOTONS: u64 = 1 << 22;
/// The chance that a right program fails one of the statistical tests here.
const ALPHA: f64 = 1e-4;

/// glass-ball with a small camera and a fine floor.
fn scene() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    let file = support::bundled_file("glass-ball");
    SCENE.get_or_init(|| with_films(&file, [WIDTH, HEIGHT], TEXELS))
}

fn settings() -> PhotonSettings {
    PhotonSettings {
        max_layers: 64,
        ..PhotonSettings::default()
    }
}

fn photons(count: u64) -> Budget {
    Budget {
        work: Some(count),
        ..Budget::default()
    }
}

fn traced(scene: &Scene, settings: PhotonSettings, count: u64) -> Estimate {
    let progress = Progress::default();
    Setup::new(scene, sensor(scene, "camera"), settings, &progress)
        .and_then(|setup| setup.run(&photons(count)))
        .unwrap()
}

fn image() -> &'static Estimate {
    static IMAGE: OnceLock<Estimate> = OnceLock::new();
    IMAGE.get_or_init(|| traced(scene(), settings(), PHOTONS))
}

fn by_beams(scene: &Scene, id: &str) -> Estimate {
    // Fine enough that dim parts of the floor are known to a few per cent, too.
    seen::by_beams(scene, id, 1e-4).0
}

#[test]
fn a_camera_sees_radiance_and_no_direct_light() {
    let image = image();
    assert_eq!(image.quantity, Quantity::Radiance);
    assert_eq!([image.width, image.height], [WIDTH, HEIGHT]);
    let names: Vec<String> = image.layers.iter().map(|it| it.name.to_string()).collect();
    assert!(!names.contains(&"LD".to_owned()), "{names:?}");
    // After one reflection inside, light leaves upwards.
    for name in ["LRD", "LTTD", "LTRRTD"] {
        assert!(names.contains(&name.to_owned()), "{names:?}");
    }
    // The total is the sum of the layers, each of which is rounded once.
    for pixel in 0..WIDTH * HEIGHT {
        let sum: Rgb = image.layers.iter().map(|it| it.values[pixel]).sum();
        let total = image.total.values[pixel].mean();
        assert!((sum.mean() - total).abs() <= 1e-12 * total, "pixel {pixel}");
    }
}

#[test]
fn what_photons_leave_on_surfaces_the_ledger_calls_absorbed() {
    let ledger = &image().ledger;
    assert!(ledger.closure_error().unwrap() < 1e-10);
    assert!(ledger.sum().received.is_black() && ledger.sum().direct.is_black());
    assert!(ledger.sum().absorbed.mean() > 0.1 * ledger.emitted.mean());
}

#[test]
fn every_signature_agrees_with_beams_pixel_by_pixel() {
    // Pixels so large that each gets enough of the few photons that the ball mirrors onto the floor.
    let file = support::bundled_file("glass-ball");
    let scene = with_films(&file, [16, 12], 8);
    let image = traced(&scene, settings(), PHOTONS);
    let beams = by_beams(&scene, "camera");
    let named = |estimate: &Estimate, name: &str| -> Layer {
        let wanted = LayerName::Path(name.parse().unwrap());
        let found = estimate.layers.iter().find(|layer| layer.name == wanted);
        found.unwrap().clone()
    };
    // How much of the light the joint bars may come to, on the whole: photons of LRD are few.
    for (name, allowed) in [("total", 0.05), ("LTTD", 0.05), ("LRD", 0.4)] {
        let (traced, known) = match name {
            "total" => (image.total.clone(), beams.total.clone()),
            name => (named(&image, name), named(&beams, name)),
        };
        let bounds = known.interval.as_ref().unwrap();
        let at = |values: &[Rgb], pixel: usize| values[pixel].0[0];
        // A sum of few photons is not normal. With 32 replicates, whose scatter is 8 %, it nearly is.
        let judged: Vec<usize> = (0..16 * 12)
            .filter(|&pixel| {
                let error = at(&traced.standard_error, pixel);
                error > 0.0 && error <= 0.08 * at(&bounds.low, pixel)
            })
            .collect();
        assert!(judged.len() >= 10, "{name}: {} judged", judged.len());
        let count = 3.0 * judged.len() as f64;
        let limit = student::two_sided_quantile(ALPHA / count, settings().replicates - 1);
        let (mut light, mut bars, mut off) = (0.0, 0.0, 0.0);
        for &pixel in &judged {
            let [low, high] = [&bounds.low, &bounds.high].map(|it| at(it, pixel));
            let value = at(&traced.values, pixel);
            let random = limit * at(&traced.standard_error, pixel);
            assert!(
                (low - random..=high + random).contains(&value),
                "{name}: pixel {pixel} is {value} ± {random} traced, {low}..{high} by beams"
            );
            light += value;
            bars += random + 0.5 * (high - low);
            off += value - 0.5 * (low + high);
        }
        println!(
            "{name}: {} pixels, joint bars {:.2} %, in all {:+.3} %",
            judged.len(),
            100.0 * bars / light,
            100.0 * off / light
        );
        assert!(bars < allowed * light, "{name}: {}", bars / light);
    }
}

#[test]
fn the_image_is_the_floors_irradiance_times_albedo_by_pi() {
    let image = image();
    let floor = Map::of(&by_beams(scene(), "floor"));
    let camera = Camera::new(scene(), sensor(scene(), "camera")).unwrap();
    let view = FloorView {
        scene: scene(),
        camera: &camera,
        floor: "floor-surface",
        half_side: 2.0,
        map: &floor,
    };
    let factor = ALBEDO / std::f64::consts::PI;
    let seen: Vec<(usize, f64, f64)> = (0..WIDTH * HEIGHT)
        .filter_map(|pixel| {
            let corner = DVec2::new((pixel % WIDTH) as f64, (pixel / WIDTH) as f64);
            let (value, error) = view.average(corner)?;
            Some((pixel, factor * value, factor * error))
        })
        .collect();
    assert!(seen.len() > 500, "{} pixels compared", seen.len());
    let limit = student::two_sided_quantile(ALPHA / seen.len() as f64, settings().replicates - 1);
    let (mut light, mut tolerances) = (0.0, 0.0);
    for (pixel, value, error) in seen {
        let traced = image.total.values[pixel].mean();
        let tolerance = error + limit * image.total.standard_error[pixel].mean();
        assert!(
            (traced - value).abs() <= tolerance,
            "pixel {pixel}: {traced} traced, {value} seen, allowed {tolerance}"
        );
        light += value;
        tolerances += tolerance;
    }
    println!("within a mean tolerance of {:.2e}", tolerances / light);
    assert!(tolerances < 0.2 * light, "{:e}", tolerances / light);
}

/// Every number of an image.
fn bits(estimate: &Estimate) -> Vec<u64> {
    let layers = std::iter::once(&estimate.total).chain(&estimate.layers);
    let values = layers.flat_map(|layer| layer.values.iter().chain(&layer.standard_error));
    values
        .flat_map(|value| value.0.map(f64::to_bits))
        .chain(estimate.counts.iter().copied())
        .chain(estimate.ledger.emitted.0.map(f64::to_bits))
        .collect()
}

#[test]
fn threads_and_shards_do_not_change_a_bit() {
    let settings = PhotonSettings {
        replicates: 5,
        ..settings()
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| bits(&traced(scene(), settings, 20_000)))
    };
    let alone = on(1);
    assert!([2, 3].iter().all(|&threads| on(threads) == alone));
    let progress = Progress::default();
    let camera = sensor(scene(), "camera");
    let setup = Setup::new(scene(), camera, settings, &progress).unwrap();
    let merged = parts::merged(&setup, "camera", &photons(20_000), 2);
    assert!(bits(&merged) == alone);
}

#[test]
fn shards_traced_with_one_filter_are_no_part_of_a_run_with_another() {
    let progress = Progress::default();
    let plain = sensor(scene(), "camera");
    let mut wide = plain.clone();
    wide.film.filter = ReconstructionFilter::Tent { radius: 1.0 };
    let setup = |sensor| Setup::new(scene(), sensor, settings(), &progress).unwrap();
    let file = setup(&wide).run_shard("camera", &photons(20_000), Shard::WHOLE);
    let mut shards = parts::opened([&file.unwrap().unwrap()[..]]).unwrap();
    let error = setup(plain)
        .merge("camera", &mut shards)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("the sensor") && error.contains("Tent"),
        "{error}"
    );
}

#[test]
fn a_coloured_floor_colours_the_image_and_not_the_flux() {
    let mut parts = mitsuba::load_parts(&support::bundled_file("glass-ball"), &[]).unwrap();
    let albedo = [0.5, 0.25, 0.125];
    for material in &mut parts.materials {
        if let Material::Diffuse { reflectance } = material {
            *reflectance = Color::Constant(Rgb(albedo));
        }
    }
    for sensor in &mut parts.sensors {
        sensor.film = self::sensor(scene(), &sensor.id).film.clone();
    }
    let scene = Scene::new(parts).unwrap();
    let image = traced(&scene, settings(), 20_000);
    let mut lit = 0;
    // The same photons, times numbers whose products are exact; each deposit is rounded to 2⁻⁴⁵ of all flux
    // or less: some ten in a replicate's pixel, of which the brightest has more than 10⁻⁵ of the flux.
    let brightest = image.total.range().max;
    let rounding = 10.0 * 2f64.powi(-45) / 1e-5 * brightest;
    for value in &image.total.values {
        let [red, green, blue] = value.0;
        assert!((red - 2.0 * green).abs() <= rounding && (red - 4.0 * blue).abs() <= rounding);
        lit += usize::from(red > 0.0);
    }
    assert!(lit > 300, "{lit} pixels are lit");
    let beams = beams::run(
        &scene,
        sensor(&scene, "camera"),
        BeamSettings::default(),
        &Budget {
            relative_error: Some(0.05),
            ..Budget::default()
        },
        &Progress::default(),
    );
    let total = beams.unwrap().0.total;
    let sum: Rgb = total.values.iter().copied().sum();
    // Quarters of one number, but for bounds cut off at zero.
    assert!((sum.0[0] / sum.0[2] - 4.0).abs() < 1e-3, "{sum:?}");
}
