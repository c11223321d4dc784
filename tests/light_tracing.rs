//! Photons connected to a camera (light tracing): paths L S+ D E, by the photon loop that fills receivers.

use std::sync::OnceLock;

use glam::DVec2;

use nephroid::geometry::TraversalCounters;
use nephroid::mitsuba;
use nephroid::radiometry::Rgb;
use nephroid::reference::beams::{self, BeamBudget, BeamSettings};
use nephroid::reference::photons::run::Setup;
use nephroid::reference::photons::shard::Part;
use nephroid::reference::photons::{Budget, PhotonSettings, Shard};
use nephroid::reference::{Estimate, Layer, LayerName, Progress, Quantity};
use nephroid::scene::{Color, Material, Scene};
use nephroid::transport::camera::Camera;

mod support;

use support::comparison::Compared;
use support::seen::{FloorView, Map, sensor, with_films};
use support::student;

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
        photons: Some(count),
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
    let budget = BeamBudget {
        relative_error: Some(1e-3),
        ..BeamBudget::default()
    };
    let settings = BeamSettings {
        max_layers: 64,
        ..BeamSettings::default()
    };
    let sensor = sensor(scene, id);
    beams::run(scene, sensor, settings, &budget, &Progress::default())
        .unwrap()
        .0
}

/// Radiance of each pixel by flux that arrives at what its middle sees; zero where that is not the floor.
fn radiance_by_flux(scene: &Scene, camera: &Camera) -> Vec<f64> {
    let mut counters = TraversalCounters::default();
    let (width, height) = (camera.width(), camera.height());
    (0..width * height)
        .map(|pixel| {
            let corner = DVec2::new((pixel % width) as f64, (pixel / width) as f64);
            let view = camera.pixel_ray(corner + 0.5);
            let world = scene.world();
            let hit = world.closest_hit(&view.ray, view.reach, &mut counters);
            hit.and_then(|hit| {
                let point = world.surface_point(&view.ray, &hit);
                let direction = view.ray.direction;
                camera.connect(scene, hit.shape, &point, direction, &mut counters)
            })
            .map_or(0.0, |seen| seen.radiance_per_flux.mean())
        })
        .collect()
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
        let sum: Rgb = image.layers.iter().map(|it| it.irradiance[pixel]).sum();
        let total = image.total.irradiance[pixel].mean();
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
    let image = traced(&scene, settings(), 2 * PHOTONS);
    let beams = by_beams(&scene, "camera");
    let camera = Camera::new(&scene, sensor(&scene, "camera")).unwrap();
    let by_flux = radiance_by_flux(&scene, &camera);
    let replicates = f64::from(settings().replicates);
    let emitted = image.ledger.emitted.mean();
    let each = image.paths as f64 / replicates;
    let channel = |values: &[Rgb]| values.iter().map(|it| it.0[0]).collect::<Vec<_>>();
    let compared = |traced: &Layer, known: &Layer| {
        let bounds = known.interval.as_ref().unwrap();
        let (low, high) = (channel(&bounds.low), channel(&bounds.high));
        let error = channel(&traced.standard_error);
        // No photon brings more than its share of what was emitted.
        let expected = |pixel: usize| {
            let most = by_flux[pixel] * emitted / each;
            // Bounds as wide as the standard error would hide a deviation.
            let is_known = high[pixel] - low[pixel] <= 0.1 * error[pixel];
            if most > 0.0 && is_known {
                low[pixel] / most
            } else {
                0.0
            }
        };
        Compared {
            name: format!("light tracing {}", traced.name),
            photons: (0..low.len()).map(expected).collect(),
            estimate: channel(&traced.irradiance),
            error,
            low,
            high,
            freedom: settings().replicates - 1,
            replicates,
        }
    };
    let mut all = vec![compared(&image.total, &beams.total)];
    for name in ["LRD", "LTTD"] {
        let wanted = LayerName::Path(name.parse().unwrap());
        let of = |estimate: &Estimate| -> Layer {
            let found = estimate.layers.iter().find(|layer| layer.name == wanted);
            found.unwrap().clone()
        };
        all.push(compared(&of(&image), &of(&beams)));
    }
    let judged: usize = all.iter().map(|it| it.judged().count()).sum();
    for one in &all {
        println!("{}: {:?}", one.name, one.agreement());
        one.assert_every_texel_agrees(10, ALPHA, judged);
        one.assert_honest_errors(10, ALPHA, all.len());
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
        let traced = image.total.irradiance[pixel].mean();
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
    let values = layers.flat_map(|layer| layer.irradiance.iter().chain(&layer.standard_error));
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
    let parts = [1, 0].map(|index| {
        let shard = Shard { index, count: 2 };
        let part = setup.run_shard("camera", &photons(20_000), shard).unwrap();
        let mut bytes = Vec::new();
        part.unwrap().write_to(&mut bytes).unwrap();
        Part::read_from(&bytes[..]).unwrap()
    });
    assert!(bits(&setup.merge("camera", parts.into()).unwrap()) == alone);
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
    for value in &image.total.irradiance {
        let [red, green, blue] = value.0;
        assert!((red - 2.0 * green).abs() <= rounding && (red - 4.0 * blue).abs() <= rounding);
        lit += usize::from(red > 0.0);
    }
    assert!(lit > 1000, "{lit} pixels are lit");
    let beams = beams::run(
        &scene,
        sensor(&scene, "camera"),
        BeamSettings::default(),
        &BeamBudget {
            relative_error: Some(0.05),
            ..BeamBudget::default()
        },
        &Progress::default(),
    );
    let total = beams.unwrap().0.total;
    let sum: Rgb = total.irradiance.iter().copied().sum();
    // Quarters of one number, but for bounds cut off at zero.
    assert!((sum.0[0] / sum.0[2] - 4.0).abs() < 1e-3, "{sum:?}");
}
