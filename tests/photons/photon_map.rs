//! Progressive photon mapping: what is seen through glass is the receiver's map, within the stated bias and
//! error.

use std::f64::consts::SQRT_2;
use std::sync::OnceLock;

use glam::{DVec2, DVec3};

use nephroid::internals::numeric::SampleMoments;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::parts::{Divided, Part};
use nephroid::internals::reference::photon_map;
use nephroid::internals::reference::photon_map::finish::CONFIDENCE;
use nephroid::internals::reference::photon_map::setup::Setup;
use nephroid::internals::reference::photon_map::{PhotonMapReport, PhotonMapSettings, Seen};
use nephroid::internals::reference::photons;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::shard::{Round, Shard};
use nephroid::internals::run::Budget;
use nephroid::internals::run::Error;
use nephroid::internals::run::{CombineError, Estimate, Layer, LayerName, Progress, Quantity};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::camera::Camera;

use crate::support;
use crate::support::parts;
use crate::support::seen::{self, FloorView, Map, sensor, with_films};

const WIDTH: usize = 80;
const HEIGHT: usize = 60;
const TEXELS: usize = 512;
const ALBEDO: f64 = 0.8;
/// Of the pane, towards the camera.
const PANE_NORMAL: DVec3 = DVec3::new(0.846, -0.533, 0.0);

/// The shipped scene, with a small camera and a fine floor.
fn behind_pane() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    let file = support::bundled_file("glass-ball-behind-pane");
    SCENE.get_or_init(|| with_films(&file, [WIDTH, HEIGHT], TEXELS))
}

/// The same without the pane.
fn in_the_open() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    let file = support::bundled_file("glass-ball");
    SCENE.get_or_init(|| with_films(&file, [WIDTH, HEIGHT], TEXELS))
}

/// 12 replicates of 2¹⁵ photons a map.
fn settings(seen: Seen) -> PhotonMapSettings {
    PhotonMapSettings {
        photons: PhotonSettings {
            replicates: 12,
            ..PhotonSettings::default()
        },
        map_photons: 1 << 15,
        seen,
        ..PhotonMapSettings::default()
    }
}

fn mapped(scene: &Scene, settings: PhotonMapSettings, passes: u64) -> (Estimate, PhotonMapReport) {
    let budget = Budget {
        work: Some(passes * settings.map_photons * u64::from(settings.photons.replicates)),
        ..Budget::default()
    };
    let camera = sensor(scene, "camera");
    photon_map::run(scene, camera, settings, &budget, &Progress::default()).unwrap()
}

fn by_beams(scene: &Scene, id: &str) -> Estimate {
    // Fine enough that dim parts of the floor are known to a few per cent, too.
    seen::by_beams(scene, id, 5e-5).0
}

/// Radiance of the floor [W/m²/sr] that a pixel sees through the pane, and the most that it may be off.
struct Truth {
    pixel: usize,
    value: f64,
    error: f64,
}

/// Of the pixels that see nothing but the floor, where its map is smooth enough to be interpolated.
fn truths() -> &'static [Truth] {
    static TRUTHS: OnceLock<Vec<Truth>> = OnceLock::new();
    TRUTHS.get_or_init(|| {
        let floor = Map::of(&by_beams(behind_pane(), "floor"));
        let camera = Camera::new(in_the_open(), sensor(in_the_open(), "camera")).unwrap();
        let view = FloorView {
            // A thin pane bends nothing.
            scene: in_the_open(),
            camera: &camera,
            floor: "floor-surface",
            half_side: 2.0,
            map: &floor,
        };
        let factor = |at: DVec2| {
            let cosine = -camera
                .pixel_ray(at)
                .ray
                .direction
                .dot(PANE_NORMAL.normalize());
            let face = dielectric_reflectance(cosine, 1.5);
            ALBEDO / std::f64::consts::PI * (1.0 - 2.0 * face / (1.0 + face))
        };
        (0..WIDTH * HEIGHT)
            .filter_map(|pixel| {
                let corner = DVec2::new((pixel % WIDTH) as f64, (pixel / WIDTH) as f64);
                let (value, error) = view.average_of(corner, factor)?;
                Some(Truth {
                    pixel,
                    value,
                    error,
                })
            })
            .collect()
    })
}

#[test]
fn a_caustic_behind_a_pane_is_the_receivers_map_times_the_panes_transmittance() {
    let (image, report) = mapped(behind_pane(), settings(Seen::BySpecular), 16);
    assert_eq!(image.quantity, Quantity::Radiance);
    let bounds = image.total.interval.as_ref().unwrap();
    let truths = truths();
    assert!(truths.len() > 500, "{} pixels compared", truths.len());
    let (mut missed, mut light, mut off, mut bars) = (0, 0.0, 0.0, 0.0);
    for truth in truths {
        let [value, low, high] =
            [&image.total.values, &bounds.low, &bounds.high].map(|it| it[truth.pixel].mean());
        missed += usize::from(truth.value < low - truth.error || truth.value > high + truth.error);
        light += truth.value;
        off += (value - truth.value).abs();
        bars += 0.5 * (high - low);
    }
    println!(
        "{} of {} pixels out of bounds; mean error {:.2} %, mean bar {:.2} %; {report:?}",
        missed,
        truths.len(),
        100.0 * off / light,
        100.0 * bars / light,
        report = (report.passes, report.radius, report.relative_bias)
    );
    // Bounds are to hold for 999 of 1000 where biases grow with the radius or faster; pixels share photons,
    // so that their misses come together.
    assert!(missed * 200 <= truths.len(), "{missed} of {}", truths.len());
    // Bounds that hold everything would say nothing.
    assert!(bars < 0.5 * light, "{}", bars / light);
    // And of the light as a whole no more is missing or too much than the stated bias explains, with standard
    // errors that add up at worst.
    let sum = |values: &[Rgb]| -> f64 { truths.iter().map(|it| values[it.pixel].mean()).sum() };
    let excess = sum(&image.total.values) - light;
    let bias = sum(&report.bias);
    let known = sum(&image.total.standard_error) + truths.iter().map(|it| it.error).sum::<f64>();
    println!(
        "in all {:+.2} %, stated bias {:+.2} %, known to {:.2} %",
        100.0 * excess / light,
        100.0 * bias / light,
        100.0 * known / light
    );
    assert!(
        (excess - bias).abs() <= known + SQRT_2 * bias.abs(),
        "{excess} {bias} {known}"
    );
}

#[test]
fn the_stated_bias_is_the_true_one() {
    // Lookups so wide that the blur is more than noise.
    let run = |seed: u64| {
        let mut settings = settings(Seen::BySpecular);
        settings.radius = 2.0;
        settings.photons.seed = seed;
        mapped(behind_pane(), settings, 8)
    };
    let ((value, _), (_, report)) = (run(1), run(2));
    // Errors of the value and of the bias are independent: least squares by the other run's bias, less its
    // noise.
    let (mut products, mut squares, mut noise, mut variance) = (0.0, 0.0, 0.0, 0.0);
    for truth in truths() {
        let stated = report.bias[truth.pixel].mean();
        let uncertain = report.bias_standard_error[truth.pixel].mean();
        let error = value.total.standard_error[truth.pixel].mean() + truth.error;
        products += stated * (value.total.values[truth.pixel].mean() - truth.value);
        squares += stated * stated;
        noise += uncertain * uncertain;
        variance += stated * stated * error * error;
    }
    let slope = products / (squares - noise);
    let error = variance.sqrt() / (squares - noise);
    println!(
        "true bias by stated bias: {slope:.3} ± {error:.3}; noise {:.3}",
        noise / squares
    );
    // Most of the squares are bias.
    assert!(noise < 0.5 * squares, "{noise} of {squares}");
    // Where light is smooth it is 1; where it jumps, 1/(√2 − 1) = 2.41. Smooth pixels are compared, but
    // the disc reaches two pixels further, to where they are not.
    let most = SQRT_2 + 1.0;
    assert!(
        slope > 1.0 - 4.0 * error && slope < most,
        "{slope} ± {error}"
    );
}

#[test]
fn seeds_agree_within_their_standard_errors() {
    let run = |seed: u64| {
        let mut settings = settings(Seen::BySpecular);
        settings.photons.seed = seed;
        mapped(behind_pane(), settings, 2).0.total
    };
    let (a, b) = (run(3), run(4));
    let mut scores = SampleMoments::new();
    for pixel in 0..WIDTH * HEIGHT {
        let (x, y) = (a.values[pixel].mean(), b.values[pixel].mean());
        let error = a.standard_error[pixel]
            .mean()
            .hypot(b.standard_error[pixel].mean());
        // Dimmer pixels have few photons, whose sums are not normal.
        if x + y > 0.0 && error < 0.1 * (x + y) {
            scores.add((x - y) / error);
        }
    }
    let (mean, variance) = (scores.mean().unwrap(), scores.variance().unwrap());
    println!(
        "{} z-scores: mean {mean:.3}, variance {variance:.3}",
        scores.count()
    );
    assert!(scores.count() > 300, "{}", scores.count());
    // Welch's z of two times 12 replicates has about 22 degrees of freedom: a variance of 22/20. Neighbours
    // share photons, some ten pixels a disc: a tenth of the scores are independent. So the mean is known to
    // √(1/m) and the variance to √(2/m), m of them; four of each.
    let independent = scores.count() as f64 / 10.0;
    assert!(
        (variance - 1.1).abs() < 4.0 * (2.0 / independent).sqrt(),
        "{variance}"
    );
    assert!(mean.abs() < 4.0 / independent.sqrt(), "{mean}");
}

#[test]
fn a_caustic_in_the_open_is_that_of_beams_within_bounds() {
    let (image, _) = mapped(in_the_open(), settings(Seen::Directly), 8);
    let beams = by_beams(in_the_open(), "camera");
    let mut compared = 0;
    let mut missed = 0;
    for name in ["LRD", "LTTD"] {
        let wanted = LayerName::Path(name.parse().unwrap());
        let of = |estimate: &Estimate| -> Layer {
            let found = estimate.layers.iter().find(|layer| layer.name == wanted);
            found.unwrap().clone()
        };
        let (mapped, known) = (of(&image), of(&beams));
        let (ours, theirs) = (mapped.interval.unwrap(), known.interval.unwrap());
        for truth in truths() {
            // Places, not values: pixels of the floor alone, where its light is smooth.
            let at = truth.pixel;
            // Where no photon fell, the map's scatter tells nothing.
            if known.values[at].mean() > 0.0 && mapped.values[at].mean() > 0.0 {
                compared += 1;
                let apart = theirs.low[at].mean() > ours.high[at].mean()
                    || theirs.high[at].mean() < ours.low[at].mean();
                missed += usize::from(apart);
            }
        }
    }
    println!("{missed} of {compared} pixels' bounds are apart");
    assert!(compared > 500, "{compared}");
    assert!(missed * 200 <= compared, "{missed} of {compared}");
}

#[test]
fn light_connected_to_the_camera_finds_nothing_behind_a_pane() {
    let scene = behind_pane();
    let budget = Budget {
        work: Some(100_000),
        ..Budget::default()
    };
    let image = photons::run(
        scene,
        sensor(scene, "camera"),
        PhotonSettings::default(),
        &budget,
        &Progress::default(),
    )
    .unwrap();
    // Every pixel looks through the pane.
    assert!(image.total.values.iter().all(|value| value.is_black()));
    assert!(image.ledger.sum().absorbed.mean() > 0.0);
}

#[test]
fn what_is_seen_directly_and_what_through_glass_are_counted_once() {
    // In the open, some of the floor is seen directly and some through the ball.
    let run = |seen: Seen| {
        let mut settings = settings(seen);
        settings.photons.replicates = 3;
        mapped(in_the_open(), settings, 1).0
    };
    let [direct, specular, all] = [Seen::Directly, Seen::BySpecular, Seen::Anyhow].map(run);
    let (mut seen_directly, mut seen_by_specular) = (0, 0);
    for pixel in 0..WIDTH * HEIGHT {
        let [direct, specular, all] =
            [&direct, &specular, &all].map(|it| it.total.values[pixel].mean());
        // The same photons and the same paths from the camera: integers, each mean rounded once.
        let rounding = 4.0 * f64::EPSILON * all;
        assert!((direct + specular - all).abs() <= rounding, "pixel {pixel}");
        seen_directly += usize::from(direct > 0.0);
        seen_by_specular += usize::from(specular > 0.0);
    }
    assert!(seen_directly > 500 && seen_by_specular > 100);
    let names: Vec<String> = all.layers.iter().map(|it| it.name.to_string()).collect();
    assert!(names.contains(&"LTTD".to_owned()) && names.contains(&"LTTDSE".to_owned()));
    let unique: std::collections::BTreeSet<&String> =
        names.iter().filter(|name| *name != "other").collect();
    let named = names.iter().filter(|name| *name != "other").count();
    assert_eq!(unique.len(), named);
}

#[test]
fn light_and_photon_maps_together_are_all_caustics_each_counted_once() {
    let scene = in_the_open();
    let light = || {
        let settings = PhotonSettings::default();
        let budget = Budget {
            work: Some(1 << 20),
            ..Budget::default()
        };
        let camera = sensor(scene, "camera");
        let traced = photons::run(scene, camera, settings, &budget, &Progress::default());
        traced
            .unwrap()
            .with_bounds(CONFIDENCE, settings.replicates, 0.0)
    };
    let map = |seen: Seen| mapped(scene, settings(seen), 2).0;
    let sum = light().and(map(Seen::BySpecular)).unwrap();
    let all = map(Seen::Anyhow);
    let (ours, theirs) = (
        sum.total.interval.unwrap(),
        all.total.interval.clone().unwrap(),
    );
    let (mut missed, mut lit) = (0, 0);
    for pixel in 0..WIDTH * HEIGHT {
        // A pixel that sees a focus, or the floor's border, has less in a disc than the bounds know of: two
        // thousand lit pixels have few of those.
        let apart = ours.low[pixel].mean() > theirs.high[pixel].mean()
            || ours.high[pixel].mean() < theirs.low[pixel].mean();
        missed += usize::from(apart);
        lit += usize::from(theirs.high[pixel].mean() > 0.0);
    }
    println!("{missed} of {lit} pixels' bounds are apart");
    assert!(lit > 2000 && missed * 100 <= lit, "{missed} of {lit}");
    let names: Vec<String> = sum.layers.iter().map(|it| it.name.to_string()).collect();
    assert!(names.contains(&"LTTD".to_owned()) && names.contains(&"LTTDSE".to_owned()));
    // What is in both is refused.
    let error = light().and(all).unwrap_err();
    assert!(matches!(error, CombineError::Twice { .. }), "{error}");
}

#[test]
fn threads_do_not_change_a_bit() {
    let mut settings = settings(Seen::Anyhow);
    settings.map_photons = 5000;
    settings.photons.replicates = 3;
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let (image, report) = pool.unwrap().install(|| mapped(in_the_open(), settings, 2));
        let layers = std::iter::once(&image.total).chain(&image.layers);
        let values = layers.flat_map(|it| it.values.iter().chain(&it.standard_error));
        values
            .chain(&report.bias)
            .flat_map(|value| value.0.map(f64::to_bits))
            .collect::<Vec<u64>>()
    };
    let alone = on(1);
    assert!([2, 3].iter().all(|&threads| on(threads) == alone));
}

#[test]
fn a_run_that_is_stopped_in_its_first_round_is_one_of_the_replicates_that_are_done() {
    let scene = behind_pane();
    let of = |replicates: u32| {
        let mut settings = settings(Seen::BySpecular);
        settings.photons.replicates = replicates;
        settings
    };
    let progress = Progress::default();
    // More replicates than anybody waits for, of which the watcher waits for three.
    let (stopped, report) = std::thread::scope(|scope| {
        scope.spawn(|| {
            // Or for two minutes, if the run never gets there.
            for _ in 0..120_000 {
                if progress.done() >= 3 * (1 << 15) {
                    break;
                }
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            progress.stop();
        });
        let budget = Budget::time(std::time::Duration::from_secs(3600));
        let camera = sensor(scene, "camera");
        photon_map::run(scene, camera, of(255), &budget, &progress).unwrap()
    });
    let done = stopped.paths >> 15;
    assert!((3..255).contains(&done), "{done} replicates");
    assert!(stopped.incomplete && report.passes == 1);
    let (alone, _) = mapped(scene, of(done as u32), 1);
    let bits = |image: &Estimate| {
        let bounds = image.total.interval.as_ref().unwrap();
        let all = [&image.total.values, &bounds.low, &bounds.high];
        all.map(|it| {
            it.iter()
                .map(|it| it.0.map(f64::to_bits))
                .collect::<Vec<_>>()
        })
    };
    assert!(bits(&stopped) == bits(&alone));
}

/// Settings that a case changes.
type Change = fn(&mut PhotonMapSettings);

#[test]
fn meters_and_settings_out_of_range_are_refused() {
    let scene = in_the_open();
    let refused = |sensor_id: &str, change: Change| {
        let mut settings = settings(Seen::BySpecular);
        change(&mut settings);
        let sensor = sensor(scene, sensor_id);
        let result = photon_map::run(
            scene,
            sensor,
            settings,
            &Budget::default(),
            &Progress::default(),
        );
        result.unwrap_err()
    };
    let error = refused("floor", |_| ());
    assert!(matches!(error, Error::Refused(_)), "{error}");
    let cases: [(Change, &str); 5] = [
        (|it| it.radius = 0.0, "radius"),
        (|it| it.radius = f64::NAN, "radius"),
        (|it| it.alpha = 1.5, "alpha"),
        (|it| it.map_photons = 0, "map-photons"),
        (|it| it.photons.replicates = 0, "replicates"),
    ];
    for (change, expected) in cases {
        let message = refused("camera", change).to_string();
        assert!(message.contains(expected), "{message}");
        assert!(message.contains("allowed"), "{message}");
    }
}

/// All that a run of maps tells, bit by bit.
fn bits((estimate, report): &(Estimate, PhotonMapReport)) -> Vec<u64> {
    let layers = [&estimate.total].into_iter().chain(&estimate.layers);
    let of_layer = |layer: &Layer| {
        let interval = layer.interval.clone().unwrap();
        [
            layer.values.clone(),
            layer.standard_error.clone(),
            interval.low,
            interval.high,
        ]
    };
    let bias = [report.bias.clone(), report.bias_standard_error.clone()];
    let maps = layers.flat_map(of_layer).chain(bias);
    let mut all: Vec<u64> = maps
        .flatten()
        .flat_map(|value| value.0.map(f64::to_bits))
        .collect();
    let counters = estimate.counters;
    all.extend([
        counters.rays,
        counters.node_visits,
        counters.primitive_tests,
    ]);
    all.extend([estimate.paths, estimate.incomplete.into(), report.passes]);
    all.extend(estimate.relative_error.map(f64::to_bits));
    all
}

#[test]
fn maps_in_parts_have_the_bits_of_the_whole_run() {
    // Small films: whether bits agree does not depend on their size.
    let scene = with_films(
        &support::bundled_file("glass-ball-behind-pane"),
        [16, 12],
        64,
    );
    let settings = PhotonMapSettings {
        photons: PhotonSettings {
            replicates: 5,
            ..PhotonSettings::default()
        },
        map_photons: 1 << 12,
        seen: Seen::Anyhow,
        ..PhotonMapSettings::default()
    };
    let camera = sensor(&scene, "camera");
    let progress = Progress::default();
    let setup = Setup::new(&scene, camera, settings, &progress).unwrap();
    let maps = 5 << 12;
    // Rounds of 1, 2, 4 and 3 maps.
    let budget = Budget::work(10 * maps);
    let whole = setup.run(&budget).unwrap();
    assert_eq!(whole.1.passes, 10);
    // More parts than replicates: two have nothing to do.
    for count in [1, 3, 7] {
        let merged = parts::merged(&setup, "camera", &budget, count);
        assert!(bits(&merged) == bits(&whole), "{count} shards");
        let (found, rounds) = parts::gathered(&setup, "camera", &budget, count);
        assert!(bits(&found) == bits(&whole), "{count} parts");
        let each: Vec<u64> = rounds.iter().map(|round| round.each).collect();
        assert_eq!(each, [1, 2, 4, 3]);
    }
    // To four fifths of its error: rounds of 1, 2, 4 and 8 maps or one more.
    let budget = Budget::error(0.8 * whole.0.relative_error.unwrap());
    let whole = setup.run(&budget).unwrap();
    let (found, rounds) = parts::gathered(&setup, "camera", &budget, 2);
    assert!(bits(&found) == bits(&whole));
    assert!((4..6).contains(&rounds.len()), "{rounds:?}");
}

#[test]
fn a_shard_that_lost_rounds_is_no_shorter_run() {
    let settings = PhotonMapSettings {
        photons: PhotonSettings {
            replicates: 2,
            ..PhotonSettings::default()
        },
        map_photons: 1 << 8,
        ..PhotonMapSettings::default()
    };
    let camera = sensor(behind_pane(), "camera");
    let progress = Progress::default();
    let setup = Setup::new(behind_pane(), camera, settings, &progress).unwrap();
    let budget = Budget::work(7 * 2 * 256);
    let shard = Shard { index: 0, count: 1 };
    let file = setup.run_shard("camera", &budget, shard).unwrap().unwrap();
    for lost in 0..3 {
        let mut rounds = parts::parts_of(&file);
        assert_eq!(rounds.len(), 3);
        rounds.remove(lost);
        let mut shards = parts::opened([&rounds.concat()[..]]).unwrap();
        let error = setup.merge("camera", &mut shards).unwrap_err().to_string();
        assert!(
            error.contains(&format!("lack round {}", lost + 1)),
            "{error}"
        );
    }
    // More maps than any run has would take as long to be told as to be made.
    let ends = file.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
    let ends: Vec<usize> = ends.map(|(at, _)| at + 1).take(2).collect();
    let header = std::str::from_utf8(&file[ends[0]..ends[1]]).unwrap();
    let many = header.replace("\"each\":1,", "\"each\":4611686018427387904,");
    assert!(many != header, "{header}");
    let changed = [&file[..ends[0]], many.as_bytes(), &file[ends[1]..]].concat();
    let error = Part::read_from(&changed[..]).unwrap_err().to_string();
    assert!(error.contains("allowed are up to"), "{error}");
    // Whoever would make them is told before.
    let small = PhotonMapSettings {
        map_photons: 1,
        ..settings
    };
    let setup = Setup::new(behind_pane(), camera, small, &progress).unwrap();
    let round = Round {
        number: 28,
        replicates: 2,
        each: 1 << 28,
        before: (1 << 28) - 1,
    };
    let error = setup
        .run_part("camera", round, shard)
        .unwrap_err()
        .to_string();
    assert!(error.contains("larger maps"), "{error}");
}

#[test]
fn maps_in_parts_of_a_scene_without_caustics_are_black_as_the_whole_run_is() {
    let camera = "<sensor type=\"perspective\" id=\"camera\"><film type=\"hdrfilm\"><integer name=\"width\" value=\"3\"/>\
        <integer name=\"height\" value=\"2\"/></film></sensor>";
    let scene = support::paths::scene(&format!(
        "{camera}<emitter type=\"point\"><point name=\"position\" value=\"0, 0, 3\"/></emitter>\
         <shape type=\"rectangle\"><bsdf type=\"diffuse\"/></shape>"
    ));
    let settings = PhotonMapSettings {
        map_photons: 16,
        ..PhotonMapSettings::default()
    };
    let progress = Progress::default();
    let setup = Setup::new(&scene, &scene.sensors()[0], settings, &progress).unwrap();
    assert!(setup.light().is_empty());
    let budget = Budget::work(7 * 16 * 16);
    let whole = setup.run(&budget).unwrap();
    let merged = parts::merged(&setup, "camera", &budget, 3);
    assert!(bits(&merged) == bits(&whole));
}
