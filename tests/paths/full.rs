//! All light by all methods: each class of paths once, and the image that paths alone make where they can.

use std::time::Duration;

use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::beams;
use nephroid::internals::reference::full::settings::DEFAULT_BEAM_ERROR;
use nephroid::internals::reference::full::{
    Finder, FullReport, FullSettings, PartDetail, Plan, run,
};
use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::reference::photon_map::PhotonMapSettings;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::run::{Budget, Error};
use nephroid::internals::run::{Estimate, Layer, LayerName, Progress};
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::transport::path_class::{PathClass, PathClasses};

use crate::support;
use crate::support::paths::{
    BOX, camera, class, film, image, layer_bits, mean, scene, with_32_replicates,
};
use crate::support::student;

const FLOOR: &str =
    "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.7, 0.5, 0.3\"/></bsdf>";
const BALL: &str = "<shape type=\"sphere\" id=\"ball\"><point name=\"center\" value=\"-0.5, 0, -0.4\"/>\
    <float name=\"radius\" value=\"0.5\"/><bsdf type=\"dielectric\"/></shape>";
const MIRROR: &str = "<shape type=\"sphere\"><point name=\"center\" value=\"0.6, 0.3, -0.5\"/>\
    <float name=\"radius\" value=\"0.4\"/><bsdf type=\"conductor\"/></shape>";
/// Rough glass, and rough metal.
const FROSTED: &str = "<shape type=\"sphere\"><point name=\"center\" value=\"-0.5, 0, -0.4\"/>\
    <float name=\"radius\" value=\"0.5\"/><bsdf type=\"roughdielectric\"><float name=\"alpha\" value=\"0.2\"/>\
    </bsdf></shape>";
const BRUSHED: &str = "<shape type=\"sphere\"><point name=\"center\" value=\"0.6, 0.3, -0.5\"/>\
    <float name=\"radius\" value=\"0.4\"/><bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.3\"/>\
    </bsdf></shape>";
const LAMP: &str = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"1.5\"/>\
    <rotate x=\"1\" angle=\"180\"/><translate z=\"2\"/></transform><emitter type=\"area\">\
    <rgb name=\"radiance\" value=\"2, 3, 4\"/></emitter></shape>";
const POINT: &str = "<emitter type=\"point\"><point name=\"position\" value=\"0, -0.5, 2\"/>\
    <rgb name=\"intensity\" value=\"9\"/></emitter>";
const WALL: &str = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/>\
    <rotate x=\"1\" angle=\"90\"/><translate y=\"1.5\"/></transform><bsdf type=\"diffuse\"/></shape>";

/// A floor and a wall, a camera, and what else is given.
fn room(film: &str, floor: &str, more: &[&str]) -> Scene {
    scene(&format!(
        "{}<shape type=\"rectangle\" id=\"floor\"><transform name=\"to_world\"><scale value=\"3\"/>\
         <translate z=\"-1\"/></transform>{floor}</shape>{WALL}{}",
        camera(45.0, film),
        more.concat()
    ))
}

/// Limits of a run: samples a pixel in the budget, and photons.
#[derive(Clone, Copy, Default)]
struct Limits {
    budget: Budget,
    photons: Option<u64>,
}

fn budget(samples: u64, photons: u64) -> Limits {
    Limits {
        budget: Budget::work(samples),
        photons: Some(photons),
    }
}

fn full(scene: &Scene, settings: FullSettings, limits: &Limits) -> (Estimate, FullReport) {
    let sensor = &scene.sensors()[0];
    let settings = FullSettings {
        most_photons: limits.photons,
        ..settings
    };
    run(
        scene,
        sensor,
        settings,
        &limits.budget,
        &Progress::default(),
    )
    .unwrap()
}

/// The default settings, but for more replicates of paths.
fn settings() -> FullSettings {
    FullSettings {
        path: with_32_replicates(),
        ..FullSettings::default()
    }
}

/// Lookups much narrower than these coarse images' pixels, and so many maps.
fn with_small_maps() -> FullSettings {
    let default = settings();
    FullSettings {
        photon_map: PhotonMapSettings {
            map_photons: 1 << 12,
            radius: 0.3,
            ..default.photon_map
        },
        ..default
    }
}

fn plan(scene: &Scene) -> Plan {
    let path = PathSettings::default().of_integrator(scene.integrator());
    Plan::new(scene, &scene.sensors()[0], &path).unwrap()
}

fn names(image: &Estimate) -> Vec<LayerName> {
    image.layers.iter().map(|layer| layer.name).collect()
}

/// Asserts that a layer measured without bias is that of paths: in the mean, and pixel by pixel.
fn assert_same(what: &str, layer: &Layer, by_paths: &Layer) {
    for channel in 0..3 {
        let (truth, of_truth) = mean(by_paths, channel);
        let (value, _) = mean(layer, channel);
        // Pixels share photons: their errors add up at worst.
        let pixels = layer.standard_error.len() as f64;
        let of_value = layer
            .standard_error
            .iter()
            .map(|it| it.0[channel])
            .sum::<f64>()
            / pixels;
        let error = of_value.hypot(of_truth);
        println!("{what} {channel}: {value} ± {of_value} and {truth} ± {of_truth}");
        assert!(
            (value - truth).abs() <= 4.0 * error,
            "{what}: {value} {truth} ± {error}"
        );
        assert!(
            error <= 0.05 * truth,
            "{what}: {error} of {truth} says little"
        );
    }
    // Where light is rare, paths' errors are far from normal: what is bright is chosen by the other method.
    let brightest = layer.values.iter().map(|it| it.0[1]).fold(0.0, f64::max);
    let squares: Vec<f64> = (0..layer.values.len())
        .filter(|&pixel| layer.values[pixel].0[1] >= 0.03 * brightest)
        .map(|pixel| {
            let difference = layer.values[pixel].0[1] - by_paths.values[pixel].0[1];
            let error = layer.standard_error[pixel].0[1].hypot(by_paths.standard_error[pixel].0[1]);
            (difference / error).powi(2)
        })
        .collect();
    // Welch's t of 31 degrees of freedom or more, of means that are nearly normal.
    let expected = student::moments(31);
    let count = squares.len() as f64;
    let found = squares.iter().sum::<f64>() / count;
    let tolerance = 5.0 * expected.deviation_of_square / count.sqrt();
    println!(
        "{what}: mean z² {found} of {count} pixels, expected {}",
        expected.variance
    );
    assert!(count >= 30.0, "{what}: {count} pixels");
    assert!(
        found < expected.variance + tolerance,
        "{what}: mean z² {found}"
    );
}

/// Asserts that a layer of photon maps is that of paths: in the mean but for the bias stated, and pixel by
/// pixel within its bounds.
fn assert_mapped(layer: &Layer, report: &FullReport, by_paths: &Layer) {
    let what = layer.name;
    let bounds = layer.interval.as_ref().unwrap();
    let pixels = layer.values.len();
    let widths = student::two_sided_quantile(1e-3, 31);
    // Maps whose photons never reached a pixel say 0 ± 0 of it (see the manual): it must be a dark one.
    let is_reached = |pixel: &usize| layer.standard_error[*pixel].0[1] > 0.0;
    let green = |pixel: usize| by_paths.values[pixel].0[1];
    let all: f64 = (0..pixels).map(green).sum();
    let unreached = (0..pixels).filter(|pixel| !is_reached(pixel));
    let unreached = unreached.map(green).sum::<f64>();
    assert!(unreached.abs() < 1e-3 * all, "{what}: {unreached} of {all}");
    let missed = (0..pixels)
        .filter(is_reached)
        .filter(|&pixel| {
            let [truth, error, low, high] = [
                &by_paths.values,
                &by_paths.standard_error,
                &bounds.low,
                &bounds.high,
            ]
            .map(|values| values[pixel].0[1]);
            truth + widths * error < low || truth - widths * error > high
        })
        .count();
    let bias = report
        .parts
        .iter()
        .find(|part| part.classes.iter().any(|it| LayerName::Class(it) == what))
        .map(|part| match &part.detail {
            PartDetail::PhotonMap(map) => map.bias.iter().map(|it| it.0[1]).sum::<f64>(),
            _ => panic!("{what} is not by photon maps"),
        });
    let bias = bias.unwrap() / pixels as f64;
    let (value, truth, of_truth) = {
        let (truth, of_truth) = mean(by_paths, 1);
        (mean(layer, 1).0, truth, of_truth)
    };
    // Pixels share photons: their errors add up at worst.
    let errors = layer.standard_error.iter().map(|it| it.0[1]);
    let error = (errors.sum::<f64>() / pixels as f64).hypot(of_truth);
    println!(
        "{what}: {missed} of {pixels} missed; {value} for {truth}, bias {bias}, error {error}"
    );
    // Each bar holds for 999 of 1000, and their sum more often: of 192 pixels 0.4 are missed at most, four
    // with a probability of 1e-3 were they independent; pixels that share photons miss together.
    assert!(missed <= 4, "{what}: {missed} of {pixels}");
    // What the difference of two radii says of the bias may be too little by √2 + 1 (see
    // `photon_map::finish`).
    let allowed = 4.0 * error + std::f64::consts::SQRT_2 * bias.abs();
    assert!(
        (value - truth - bias).abs() <= allowed,
        "{what}: {value} for {truth}"
    );
    // A class counted twice, or left out, would show.
    assert!(
        allowed + bias.abs() < 0.6 * truth,
        "{what}: {allowed} of {truth} says little"
    );
}

#[test]
fn the_image_is_that_of_paths_class_by_class_where_the_lamp_is_broad() {
    assert_classes_are_those_of_paths(LAMP);
}

#[test]
fn the_image_is_that_of_paths_class_by_class_where_light_comes_from_all_round() {
    assert_classes_are_those_of_paths(
        "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"2, 3, 4\"/></emitter>",
    );
}

fn assert_classes_are_those_of_paths(lamp: &str) {
    let scene = room(&film(16, 12, BOX), FLOOR, &[BALL, MIRROR, lamp]);
    let (found, report) = full(&scene, with_small_maps(), &budget(2048, 1 << 22));
    let methods: Vec<Finder> = report.parts.iter().map(|part| part.method).collect();
    assert_eq!(methods, [Finder::Photons, Finder::PhotonMap, Finder::Path]);
    // What paths measure are the bits of `--method path`, and every class is lit.
    let by_paths = image(&scene, with_32_replicates(), 2048);
    assert_eq!(names(&found), PathClass::ALL.map(LayerName::Class));
    let layer = |image, of| class(image, of).unwrap();
    for same in PathClass::ALL {
        if ![PathClass::Caustic, PathClass::SeenCaustic].contains(&same) {
            let [a, b] = [&found, &by_paths].map(|image| layer_bits(layer(image, same)));
            assert_eq!(a, b, "{same}");
        }
    }
    let truth = image(
        &scene,
        PathSettings {
            seed: 1,
            ..with_32_replicates()
        },
        8192,
    );
    for one in [PathClass::Direct, PathClass::Indirect, PathClass::Caustic] {
        assert_same(one.name(), layer(&found, one), layer(&truth, one));
    }
    let seen = PathClass::SeenCaustic;
    assert_mapped(layer(&found, seen), &report, layer(&truth, seen));
}

#[test]
fn the_layers_are_one_a_class_and_sum_to_the_image_with_its_bounds() {
    let scene = room(&film(16, 12, BOX), FLOOR, &[BALL, POINT, LAMP]);
    let (found, report) = full(&scene, settings(), &budget(32, 1 << 20));
    let mut measured = PathClasses::NONE;
    for part in &report.parts {
        for class in part.classes.iter() {
            assert!(!measured.contains(class), "{class} twice");
            measured = measured.with(class);
        }
    }
    assert_eq!(measured, PathClasses::ALL);
    assert_eq!(names(&found), PathClass::ALL.map(LayerName::Class));
    let interval = |layer: &Layer| layer.interval.clone().unwrap();
    let all = interval(&found.total);
    for pixel in 0..found.total.values.len() {
        let sum = |of: &dyn Fn(&Layer) -> Rgb| found.layers.iter().map(of).sum::<Rgb>();
        let value = sum(&|layer| layer.values[pixel]);
        let high = sum(&|layer| interval(layer).high[pixel]);
        for channel in 0..3 {
            let total = found.total.values[pixel].0[channel];
            // Sums of samples in two orders.
            let rounding = 1e-12 * high.0[channel];
            assert!((value.0[channel] - total).abs() <= rounding);
            // Bounds of paths together are narrower than of each class.
            assert!(all.high[pixel].0[channel] <= high.0[channel] + rounding);
            assert!(all.low[pixel].0[channel] <= total && total <= all.high[pixel].0[channel]);
        }
    }
    assert!(
        report
            .notices
            .iter()
            .any(|it| it.contains("caustic-indirect"))
    );
}

#[test]
fn caustics_of_point_lights_which_paths_never_find_are_those_of_beams() {
    let scene = room(&film(16, 12, BOX), FLOOR, &[BALL, POINT]);
    let budget = budget(32, 1 << 19);
    let (found, report) = full(&scene, settings(), &budget);
    assert_eq!(report.parts[0].method, Finder::Beams);
    assert!(matches!(&report.parts[0].detail, PartDetail::Beams(it) if it.passes > 0));
    let aim = Budget::error(DEFAULT_BEAM_ERROR);
    let settings = settings().beams;
    let sensor = &scene.sensors()[0];
    let (alone, _) = beams::run(&scene, sensor, settings, &aim, &Progress::default()).unwrap();
    let caustic = class(&found, PathClass::Caustic).unwrap();
    assert_eq!(layer_bits(caustic), layer_bits(&alone.total));
    for one in [PathClass::Caustic, PathClass::SeenCaustic] {
        assert!(mean(class(&found, one).unwrap(), 0).0 > 0.0, "{one} is lit");
    }
    let by_paths = image(&scene, with_32_replicates(), 32);
    assert!(class(&by_paths, PathClass::Caustic).is_none());
    assert!(class(&found, PathClass::IndirectCaustic).is_none());
    assert!(
        report
            .notices
            .iter()
            .any(|it| it.contains("caustic-indirect"))
    );
}

#[test]
fn caustics_on_surfaces_that_light_cannot_be_connected_from_are_found_by_photon_maps() {
    let rough = "<bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.3\"/></bsdf>";
    let scene = room(&film(16, 12, BOX), rough, &[BALL, LAMP]);
    let (found, report) = full(&scene, with_small_maps(), &budget(64, 1 << 22));
    let methods: Vec<Finder> = report.parts.iter().map(|part| part.method).collect();
    assert_eq!(
        methods,
        [Finder::PhotonMap, Finder::PhotonMap, Finder::Path]
    );
    let truth = image(&scene, with_32_replicates(), 4096);
    for one in [PathClass::Caustic, PathClass::SeenCaustic] {
        let [a, b] = [&found, &truth].map(|image| class(image, one).unwrap());
        assert_mapped(a, &report, b);
    }
}

#[test]
fn light_of_rough_interfaces_is_measured_once() {
    // Where nothing is smooth, photons are connected; what is seen of rough glass on rough metal, and behind
    // the glass, is for paths.
    let scene = room(&film(16, 12, BOX), FLOOR, &[FROSTED, BRUSHED, LAMP]);
    let (found, report) = full(&scene, settings(), &budget(2048, 1 << 22));
    let methods: Vec<Finder> = report.parts.iter().map(|part| part.method).collect();
    assert_eq!(methods, [Finder::Photons, Finder::Path]);
    assert!(report.notices.is_empty(), "{:?}", report.notices);
    let settings = PathSettings {
        seed: 1,
        ..with_32_replicates()
    };
    let truth = image(&scene, settings, 1 << 13);
    let layer = |image, of| class(image, of).unwrap();
    for one in [PathClass::Direct, PathClass::Indirect, PathClass::Caustic] {
        let (of_one, of_all) = (mean(layer(&truth, one), 0).0, mean(&truth.total, 0).0);
        println!("{one}: {:.4} of the light", of_one / of_all);
        assert_same(one.name(), layer(&found, one), layer(&truth, one));
    }
    assert_same("total", &found.total, &truth.total);
    // Beside smooth interfaces there are maps: what these throw on rough ones is seen there.
    let scene = room(&film(16, 12, BOX), FLOOR, &[FROSTED, MIRROR, LAMP]);
    let (found, report) = full(&scene, with_small_maps(), &budget(64, 1 << 22));
    let methods: Vec<Finder> = report.parts.iter().map(|part| part.method).collect();
    assert_eq!(
        methods,
        [Finder::PhotonMap, Finder::PhotonMap, Finder::Path]
    );
    let truth = image(&scene, with_32_replicates(), 1 << 12);
    for one in [PathClass::Caustic, PathClass::SeenCaustic] {
        let [a, b] = [&found, &truth].map(|image| class(image, one).unwrap());
        assert_mapped(a, &report, b);
    }
}

#[test]
fn light_of_coats_is_measured_once() {
    // A smooth coat mirrors as S; a rough one and its base are one D, which is for paths. Of an index of 3 a coat
    // mirrors a quarter of most light: what is counted twice is seen.
    let ball = |center: &str, radius: f64, bsdf: &str| {
        format!(
            "<shape type=\"sphere\"><point name=\"center\" value=\"{center}\"/>\
             <float name=\"radius\" value=\"{radius}\"/>{bsdf}</shape>"
        )
    };
    let coat = |plugin: &str| {
        format!(
            "<bsdf type=\"{plugin}\"><float name=\"int_ior\" value=\"3\"/><float name=\"ext_ior\" value=\"1\"/>\
             <rgb name=\"diffuse_reflectance\" value=\"0.2, 0.3, 0.1\"/></bsdf>"
        )
    };
    // With a mirror caustics are for maps. It is small and far: nearly all of this one is the coats'.
    let things = [
        ball("-0.5, 0, -0.4", 0.5, &coat("plastic")),
        ball("0.2, 1.1, -0.4", 0.5, &coat("roughplastic")),
        ball("2.5, 2.5, -0.9", 0.1, "<bsdf type=\"conductor\"/>"),
        LAMP.to_owned(),
    ];
    let things = things.each_ref().map(String::as_str);
    let scene = room(&film(16, 12, BOX), FLOOR, &things);
    let (found, report) = full(&scene, with_small_maps(), &budget(2048, 1 << 24));
    let methods: Vec<Finder> = report.parts.iter().map(|part| part.method).collect();
    assert_eq!(
        methods,
        [Finder::PhotonMap, Finder::PhotonMap, Finder::Path]
    );
    assert!(report.notices.is_empty(), "{:?}", report.notices);
    let settings = PathSettings {
        seed: 1,
        ..with_32_replicates()
    };
    let truth = image(&scene, settings, 1 << 13);
    let layer = |image, of| class(image, of).unwrap();
    let caustic = PathClass::Caustic;
    assert_mapped(layer(&found, caustic), &report, layer(&truth, caustic));
    // Few paths of a camera go on from a coat: too few for a test of each pixel, or of what is scattered on.
    let seen = PathClass::SeenCaustic;
    let [(found_seen, error), (truth_seen, of_truth)] =
        [&found, &truth].map(|image| mean(layer(image, seen), 1));
    let joint = 4.0 * error.hypot(of_truth);
    println!("{seen}: {found_seen} ± {error} for {truth_seen} ± {of_truth}");
    assert!((found_seen - truth_seen).abs() < joint && joint < 0.6 * truth_seen);
    for one in [PathClass::Direct, PathClass::Indirect] {
        assert_same(one.name(), layer(&found, one), layer(&truth, one));
    }
}

/// A ball of two materials in shares of 0.4 and 0.6.
fn blended(center: &str, radius: f64, first: &str, second: &str) -> String {
    format!(
        "<shape type=\"sphere\" id=\"blended\"><point name=\"center\" value=\"{center}\"/>\
         <float name=\"radius\" value=\"{radius}\"/><bsdf type=\"blendbsdf\">\
         <float name=\"weight\" value=\"0.6\"/>{first}{second}</bsdf></shape>"
    )
}

const MATT: &str =
    "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.2, 0.5, 0.6\"/></bsdf>";

#[test]
fn light_of_blends_is_measured_once() {
    // Photons go on from a blend's mirrors and glass, and are connected from its matt part.
    let mirror = blended("0.6, 0.3, -0.5", 0.4, MATT, "<bsdf type=\"conductor\"/>");
    let glass = blended("-0.5, 0, -0.4", 0.5, MATT, "<bsdf type=\"dielectric\"/>");
    let glass = glass.replace(" id=\"blended\"", "");
    let scene = room(&film(16, 12, BOX), FLOOR, &[&mirror, &glass, LAMP]);
    let (found, report) = full(&scene, with_small_maps(), &budget(2048, 1 << 23));
    let methods: Vec<Finder> = report.parts.iter().map(|part| part.method).collect();
    assert_eq!(methods, [Finder::Photons, Finder::PhotonMap, Finder::Path]);
    assert!(report.notices.is_empty(), "{:?}", report.notices);
    let settings = PathSettings {
        seed: 1,
        ..with_32_replicates()
    };
    let truth = image(&scene, settings, 1 << 13);
    let layer = |image, of| class(image, of).unwrap();
    for one in [PathClass::Direct, PathClass::Indirect, PathClass::Caustic] {
        assert_same(one.name(), layer(&found, one), layer(&truth, one));
    }
    let seen = PathClass::SeenCaustic;
    assert_mapped(layer(&found, seen), &report, layer(&truth, seen));
    // Photons end at its rough parts, where paths go on: light of a smooth mirror is looked up there.
    let rough = "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.3\"/></bsdf>";
    let rough = blended("-0.5, 0, -0.4", 0.5, MATT, rough);
    let scene = room(&film(16, 12, BOX), FLOOR, &[&rough, MIRROR, LAMP]);
    let (found, report) = full(&scene, with_small_maps(), &budget(2048, 1 << 23));
    let methods: Vec<Finder> = report.parts.iter().map(|part| part.method).collect();
    assert_eq!(
        methods,
        [Finder::PhotonMap, Finder::PhotonMap, Finder::Path]
    );
    let truth = image(&scene, settings, 1 << 13);
    for one in [PathClass::Direct, PathClass::Indirect] {
        assert_same(one.name(), layer(&found, one), layer(&truth, one));
    }
    for one in [PathClass::Caustic, PathClass::SeenCaustic] {
        assert_mapped(layer(&found, one), &report, layer(&truth, one));
    }
}

#[test]
fn the_plan_takes_the_best_method_that_a_scene_allows_and_says_why() {
    use Finder::{Beams, Path, PhotonMap, Photons};
    let plastic = "<bsdf type=\"plastic\"/>";
    let rough_plastic = "<bsdf type=\"roughplastic\"/>";
    let mixed = "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.5\"/><bsdf type=\"plastic\"/>\
        <bsdf type=\"diffuse\"/></bsdf>";
    let textured =
        "<bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\"/></bsdf>";
    let height = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/mitsuba/height.png");
    let bumpy = format!(
        "<shape type=\"cube\"><bsdf type=\"bumpmap\"><texture type=\"bitmap\" name=\"arbitrary\">\
         <boolean name=\"raw\" value=\"true\"/><string name=\"filename\" value=\"{height}\"/></texture>\
         <bsdf type=\"dielectric\"/></bsdf></shape>"
    );
    let turned = bumpy.replace("dielectric", "plastic");
    let turned = turned.replace("\"cube\"", "\"disk\"");
    let mirror = blended("0.6, 0.3, -0.5", 0.4, MATT, "<bsdf type=\"conductor\"/>");
    let gloss = "<bsdf type=\"roughconductor\"/>";
    let gloss = blended("0.6, 0.3, -0.5", 0.4, MATT, gloss);
    let weight = "<texture name=\"weight\" type=\"checkerboard\"/>";
    let painted = mirror.replace("<float name=\"weight\" value=\"0.6\"/>", weight);
    let board = "<shape type=\"sphere\"><emitter type=\"area\"><texture type=\"checkerboard\" name=\"radiance\"/>\
        </emitter></shape>";
    let along = "<shape type=\"disk\"><emitter type=\"directionalarea\"/></shape>";
    let sky = "<emitter type=\"constant\"/>";
    let hidden =
        "<integrator type=\"path\"><boolean name=\"hide_emitters\" value=\"true\"/></integrator>";
    let short = "<integrator type=\"path\"><integer name=\"max_depth\" value=\"2\"/></integrator>";
    let legs = "<integrator type=\"path\"><integer name=\"max_depth\" value=\"9\"/></integrator>";
    for (floor, more, caustic, seen, says) in [
        (
            FLOOR,
            &[BALL, POINT][..],
            Beams,
            PhotonMap,
            &["caustic-indirect"][..],
        ),
        (FLOOR, &[BALL, LAMP], Photons, PhotonMap, &[]),
        (
            FLOOR,
            &[BALL, LAMP, legs],
            Photons,
            PhotonMap,
            &["max_depth"],
        ),
        (FLOOR, &[LAMP, POINT], Path, Path, &[]),
        (FLOOR, &[BALL, LAMP, short], Path, Path, &[]),
        (FLOOR, &[BALL, LAMP, hidden], Path, Path, &["hide_emitters"]),
        (
            FLOOR,
            &[BALL, POINT, hidden],
            Beams,
            PhotonMap,
            &["caustic-indirect"],
        ),
        (FLOOR, &[BALL, sky], Photons, PhotonMap, &[]),
        (
            FLOOR,
            &[BALL, sky, POINT],
            Photons,
            PhotonMap,
            &["caustic-indirect"],
        ),
        (FLOOR, &[BALL, board], Photons, PhotonMap, &[]),
        (
            FLOOR,
            &[BALL, along],
            Photons,
            PhotonMap,
            &["caustic-indirect"],
        ),
        (textured, &[BALL, LAMP], Photons, PhotonMap, &[]),
        (
            textured,
            &[BALL, POINT],
            Photons,
            PhotonMap,
            &[
                "caustic: by photons instead of beams, as sensor \"perspective_0\" may see shape \"floor\"",
                "caustic-indirect",
            ],
        ),
        (plastic, &[BALL, LAMP], PhotonMap, PhotonMap, &[]),
        (
            plastic,
            &[BALL, POINT],
            PhotonMap,
            PhotonMap,
            &["caustic-indirect"],
        ),
        (
            plastic,
            &[LAMP],
            Path,
            Path,
            &["coats (of shape \"floor\")"],
        ),
        (plastic, &[FROSTED, LAMP], PhotonMap, PhotonMap, &[]),
        (
            plastic,
            &[POINT],
            PhotonMap,
            PhotonMap,
            &["caustic-indirect"],
        ),
        (rough_plastic, &[BALL, LAMP], PhotonMap, PhotonMap, &[]),
        (rough_plastic, &[POINT], Path, Path, &[]),
        (FLOOR, &[BALL, &turned, LAMP], Path, Path, &["(bumpmap)"]),
        (mixed, &[BALL, LAMP], Path, Path, &["\"floor\" (blendbsdf)"]),
        (FLOOR, &[&bumpy, LAMP], Path, Path, &["(bumpmap)"]),
        (
            FLOOR,
            &[&mirror, POINT],
            Photons,
            PhotonMap,
            &["caustic-indirect"],
        ),
        (
            FLOOR,
            &[&painted, LAMP],
            Path,
            Path,
            &[
                "\"blended\" has a blendbsdf with a mirror or glass, whose weight or factor is a texture",
            ],
        ),
        (FLOOR, &[FROSTED, LAMP], Photons, Path, &[]),
        (FLOOR, &[FROSTED, &gloss, LAMP], PhotonMap, Path, &[]),
    ] {
        let scene = room(&film(4, 4, BOX), floor, more);
        let plan = plan(&scene);
        let found = [PathClass::Caustic, PathClass::SeenCaustic].map(|class| plan.finder(class));
        assert_eq!(
            found,
            [caustic, seen],
            "{more:?} {floor}: {:?}",
            plan.notices
        );
        let rest = [
            PathClass::Emitted,
            PathClass::Direct,
            PathClass::Indirect,
            PathClass::IndirectCaustic,
        ];
        assert!(rest.iter().all(|class| plan.finder(*class) == Path));
        assert_eq!(plan.notices.len(), says.len(), "{:?}", plan.notices);
        for (notice, words) in plan.notices.iter().zip(says) {
            assert!(notice.contains(words), "{words} in {notice}");
        }
    }
}

/// The error of a run on a scene's sensor.
fn refused(scene: &Scene, sensor: &Sensor) -> String {
    let none = Budget::default();
    let error: Error = run(scene, sensor, settings(), &none, &Progress::default())
        .err()
        .unwrap();
    error.to_string()
}

#[test]
fn a_receiver_is_refused_and_matt_scenes_have_one_part() {
    let meter = scene(&format!(
        "<shape type=\"rectangle\"><sensor type=\"irradiancemeter\" id=\"meter\"/></shape>{LAMP}{BALL}"
    ));
    let said = refused(&meter, &meter.sensors()[0]);
    assert!(said.contains("\"meter\" is an irradiancemeter"), "{said}");
    for matt in [
        through_lens(FLOOR, &[LAMP]),
        room(&film(4, 4, GAUSSIAN), FLOOR, &[LAMP]),
    ] {
        let (_, report) = full(&matt, settings(), &budget(32, 1));
        assert_eq!(report.parts.len(), 1);
        assert_eq!(report.parts[0].classes, PathClasses::ALL);
    }
}

const GAUSSIAN: &str = "<rfilter type=\"gaussian\"/>";
const MITCHELL: &str = "<rfilter type=\"mitchell\"/>";
const TILES: &str = "<bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\">\
    <rgb name=\"color0\" value=\"0.8, 0.6, 0.1\"/><rgb name=\"color1\" value=\"0.2, 0.3, 0.7\"/>\
    <transform name=\"to_uv\"><scale x=\"5\" y=\"5\"/></transform></texture></bsdf>";

/// The room seen through a lens that blurs all but its middle.
fn through_lens(floor: &str, more: &[&str]) -> Scene {
    let view = film(16, 12, GAUSSIAN);
    let pinhole = camera(45.0, &view);
    let lens = pinhole.replace(
        "type=\"perspective\">",
        "type=\"thinlens\"><float name=\"aperture_radius\" value=\"0.2\"/>\
         <float name=\"focus_distance\" value=\"3\"/>",
    );
    assert_ne!(lens, pinhole);
    scene(&format!(
        "{lens}<shape type=\"rectangle\" id=\"floor\"><transform name=\"to_world\"><scale value=\"3\"/>\
         <translate z=\"-1\"/></transform>{floor}</shape>{WALL}{}",
        more.concat()
    ))
}

#[test]
fn caustics_through_any_filter_on_any_texture_are_those_of_paths() {
    for filter in [GAUSSIAN, MITCHELL] {
        let scene = room(&film(16, 12, filter), TILES, &[BALL, MIRROR, LAMP]);
        let (found, report) = full(&scene, with_small_maps(), &budget(64, 1 << 24));
        let methods: Vec<Finder> = report.parts.iter().map(|part| part.method).collect();
        assert_eq!(methods, [Finder::Photons, Finder::PhotonMap, Finder::Path]);
        let truth = image(&scene, with_32_replicates(), 8192);
        let layer = |image, of| class(image, of).unwrap();
        let one = PathClass::Caustic;
        assert_same(filter, layer(&found, one), layer(&truth, one));
        let seen = PathClass::SeenCaustic;
        assert_mapped(layer(&found, seen), &report, layer(&truth, seen));
    }
}

#[test]
fn tiles_have_their_colours_in_the_light_of_a_white_lamp() {
    // All light is grey: only what the camera sees is not.
    let scene = scene(&format!(
        "{}<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/>\
         <translate z=\"-1\"/></transform>{TILES}</shape>{BALL}{POINT}",
        camera(45.0, &film(16, 12, BOX))
    ));
    let (found, report) = full(&scene, settings(), &budget(32, 1 << 20));
    assert_eq!(report.parts[0].method, Finder::Photons);
    let caustic = class(&found, PathClass::Caustic).unwrap();
    let lit: Vec<Rgb> = caustic
        .values
        .iter()
        .copied()
        .filter(|it| it.0[1] > 0.0)
        .collect();
    // Pixels hold parts of both tiles, (0.8, 0.6, 0.1) and (0.2, 0.3, 0.7): red is 4/3 to 2/3 of green, and
    // blue 1/6 to 7/3.
    let of_green = |channel: usize| {
        let ratios = lit.iter().map(|it| it.0[channel] / it.0[1]);
        ratios.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], it| {
            [low.min(it), high.max(it)]
        })
    };
    println!(
        "{} lit, red {:?}, blue {:?}",
        lit.len(),
        of_green(0),
        of_green(2)
    );
    assert!(lit.len() >= 8);
    for value in &lit {
        let [red, green, blue] = value.0;
        let (red, blue) = (red / green, blue / green);
        assert!(red > 0.666 && red < 1.334, "{value:?}");
        assert!(blue > 0.166 && blue < 2.334, "{value:?}");
        // Both are mixtures of the same two.
        let share = (red - 2.0 / 3.0) * 1.5;
        let expected = 7.0 / 3.0 - share * (7.0 / 3.0 - 1.0 / 6.0);
        assert!((blue - expected).abs() < 1e-6, "{value:?}: {expected}");
    }
    // Both tiles are lit.
    let [low, high] = of_green(0);
    assert!(high > 1.5 * low);
}

#[test]
fn a_border_that_is_sampled_shines_into_the_image() {
    let border = "<boolean name=\"sample_border\" value=\"true\"/><rfilter type=\"gaussian\"/>";
    let [with, without] = [border, GAUSSIAN].map(|filter| {
        // The ball's caustic is wider than this view of its middle.
        let view = camera(25.0, &film(12, 10, filter));
        let view = view.replace("target=\"0, 0, 0\"", "target=\"-0.5, 0.4, -1\"");
        let scene = scene(&format!(
            "{view}<shape type=\"disk\"><transform name=\"to_world\"><scale value=\"3\"/>\
             <translate z=\"-1\"/></transform>{TILES}</shape>{BALL}{LAMP}"
        ));
        let (found, _) = full(&scene, with_small_maps(), &budget(64, 1 << 22));
        let truth = image(&scene, with_32_replicates(), 8192);
        let one = PathClass::Caustic;
        let layer = |image| class(image, one).unwrap().clone();
        assert_same(filter, &layer(&found), &layer(&truth));
        layer(&found)
    });
    assert!(with.values != without.values);
}

#[test]
fn caustics_seen_through_a_lens_are_those_of_paths() {
    let scene = through_lens(TILES, &[BALL, MIRROR, LAMP]);
    let (found, report) = full(&scene, with_small_maps(), &budget(64, 1 << 24));
    let methods: Vec<Finder> = report.parts.iter().map(|part| part.method).collect();
    assert_eq!(
        methods,
        [Finder::PhotonMap, Finder::PhotonMap, Finder::Path]
    );
    let told = "caustic: by photon-map instead of beams, as sensor \"thinlens_0\" is a thinlens";
    assert!(
        report.notices.iter().any(|it| it.contains(told)),
        "{:?}",
        report.notices
    );
    let truth = image(&scene, with_32_replicates(), 8192);
    for one in [PathClass::Caustic, PathClass::SeenCaustic] {
        let [a, b] = [&found, &truth].map(|image| class(image, one).unwrap());
        assert_mapped(a, &report, b);
    }
}

#[test]
fn the_same_bits_come_from_any_number_of_threads() {
    // Beams in the one, to what they reach in a second; connected photons in the other; maps in both.
    // Then photons spread by a filter, and maps through a lens.
    let scenes = [
        (room(&film(19, 7, BOX), FLOOR, &[BALL, POINT]), Some(1.0)),
        (room(&film(19, 7, BOX), FLOOR, &[BALL, LAMP]), None),
        (room(&film(19, 7, GAUSSIAN), TILES, &[BALL, POINT]), None),
        (through_lens(TILES, &[BALL, LAMP]), None),
    ];
    for (scene, relative_error) in scenes {
        let limits = budget(8, 1 << 14);
        let budget = Limits {
            budget: Budget {
                relative_error,
                ..limits.budget
            },
            ..limits
        };
        let settings = FullSettings {
            photons: PhotonSettings {
                replicates: 4,
                ..PhotonSettings::default()
            },
            ..settings()
        };
        let [alone, together] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let (image, report) = pool.unwrap().install(|| full(&scene, settings, &budget));
            let bounds = image.total.interval.clone().unwrap();
            let ends = bounds.low.iter().chain(&bounds.high);
            let mut bits: Vec<u64> = ends.flat_map(|it| it.0.map(f64::to_bits)).collect();
            bits.extend(support::paths::bits(&image));
            (bits, serde_json::to_string(&report).unwrap())
        });
        assert!(alone == together);
    }
}

#[test]
fn each_method_has_its_own_limit_and_its_part_of_the_time() {
    let scene = room(&film(16, 12, BOX), FLOOR, &[BALL, LAMP]);
    let (found, report) = full(&scene, settings(), &budget(96, 1 << 20));
    let paths: Vec<u64> = report.parts.iter().map(|part| part.paths).collect();
    assert_eq!(paths, [1 << 20, 1 << 20, 96 * 16 * 12]);
    assert!(!found.incomplete);
    // No time at all: nothing is known, and said so.
    let timed = |time| Limits {
        budget: Budget::time(time),
        photons: None,
    };
    let none = timed(Duration::ZERO);
    let (found, report) = full(&scene, settings(), &none);
    assert!(found.incomplete && found.total.is_unknown());
    assert!(report.parts.iter().all(|part| part.incomplete));
    // With some, each has a share: none could do its part in no time.
    let (found, report) = full(&scene, with_small_maps(), &timed(Duration::from_secs(6)));
    assert!(!found.incomplete && !found.total.is_unknown());
    assert!(
        report
            .parts
            .iter()
            .all(|part| part.paths > 0 && !part.incomplete)
    );
}

#[test]
fn a_class_that_nothing_ends_in_time_is_left_to_paths_and_said_to_be() {
    // Every look-up finds every photon: a map takes minutes, and paths a tenth of a second.
    let scene = room(&film(512, 384, BOX), FLOOR, &[BALL, POINT]);
    let limits = Limits {
        budget: Budget::time(Duration::from_secs(3)),
        photons: None,
    };
    let mut settings = settings();
    settings.photon_map.radius = 1e6;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
    let (found, report) = pool.unwrap().install(|| full(&scene, settings, &limits));
    let told = "caustic-sds: nothing ended in its share of the time: it is left to paths, which find it by chance, \
                and that of lights that are a point or a direction never";
    assert!(
        report.notices.iter().any(|one| one == told),
        "{:?}",
        report.notices
    );
    let paths = report.parts.last().unwrap();
    assert!(paths.method == Finder::Path && paths.classes.contains(PathClass::SeenCaustic));
    // There is a picture, but it is not all, and nobody knows how much more there is.
    assert!(!found.total.is_unknown() && found.incomplete);
    let high = &found.total.interval.as_ref().unwrap().high;
    assert!(high.iter().all(|it| it.0[0] == f64::INFINITY));
}

#[test]
fn what_ends_nothing_in_its_time_gives_way_to_what_does() {
    // Beams follow all of a bumpy body's chains before they know anything, and that takes minutes.
    let scene = nephroid::load(
        "scenes/turntable-bumpy.xml".as_ref(),
        &[("width", "24"), ("height", "18")],
    )
    .unwrap();
    let view = scene.sensors().iter().find(|one| one.is_camera()).unwrap();
    let within = |seconds: u64| {
        let budget = Budget::time(Duration::from_secs(seconds));
        run(&scene, view, settings(), &budget, &Progress::default()).unwrap()
    };
    // On a slow machine paths end nothing in their share of three seconds. Beams take longer there, too, and end
    // nothing in the longer time either.
    let (estimate, report) = [3, 6, 12]
        .into_iter()
        .map(within)
        .find(|(estimate, _)| !estimate.total.is_unknown())
        .expect("paths end something in twelve seconds");
    for layer in &estimate.layers {
        assert!(
            layer.values.iter().all(|value| value.is_finite()),
            "{}",
            layer.name
        );
    }
    let by = |finder| report.parts.iter().any(|part| part.method == finder);
    let told = "caustic: beams ended nothing in its share of the time, or gave up: it is measured by photons, with \
                a larger error";
    assert!(
        report.notices.iter().any(|one| one == told),
        "{:?}",
        report.notices
    );
    assert!(by(Finder::Photons) && !by(Finder::Beams));
}
