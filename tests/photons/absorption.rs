//! Media that absorb light: beside clear ones photon by photon, beside formulas, and beside paths.

use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::full::{Finder, Plan};
use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::reference::photon_map::{PhotonMapSettings, run as by_maps};
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::run::{Budget, Estimate, Progress};
use nephroid::internals::scene::{Scene, Sensor, is_achromatic, requirements};
use nephroid::internals::transport::chain::ChainSettings;
use nephroid::internals::transport::media::first_immersed;
use nephroid::internals::transport::path_class::PathClass;
use nephroid::{Context, Method};

use super::metered::{by_photons, by_photons_with, layer, scene_above_a_floor};
use super::rough::{LAMP, assert_as_paths, ball};
use crate::support::paths;

/// Texels a side of a floor from -1 to 1.
const SIDE: usize = 16;

/// Absorption of ink [1/m].
const INK: [f64; 3] = [0.75, 1.5, 0.0];

/// A medium of ink, with these attributes.
fn ink(attributes: &str) -> String {
    format!(
        "<medium type=\"homogeneous\" {attributes}><rgb name=\"sigma_t\" value=\"0.5, 1, 0\"/>\
         <float name=\"scale\" value=\"1.5\"/><float name=\"albedo\" value=\"0\"/></medium>"
    )
}

fn dielectric(index: f64) -> String {
    format!(
        "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"{index}\"/>\
         <float name=\"ext_ior\" value=\"1\"/></bsdf>"
    )
}

/// A plate far wider than the floor, between the heights 0.5 and 1.
fn plate(index: f64, inside: &str) -> String {
    let placed = "<scale x=\"6\" y=\"6\" z=\"0.25\"/><translate z=\"0.75\"/>";
    format!(
        "<shape type=\"cube\" id=\"plate\"><transform name=\"to_world\">{placed}</transform>{}{inside}</shape>",
        dielectric(index)
    )
}

const HEIGHT: f64 = 0.5;

fn sun([x, z]: [f64; 2]) -> String {
    format!(
        "<emitter type=\"directional\"><vector name=\"direction\" x=\"{x}\" y=\"0\" z=\"{z}\"/>\
         <rgb name=\"irradiance\" value=\"2, 3, 5\"/></emitter>"
    )
}

fn floored(elements: &str) -> Scene {
    scene_above_a_floor(elements, SIDE)
}

/// Every branch has its own photon, so that both runs have the same ones.
fn all_branches() -> PhotonSettings {
    PhotonSettings {
        chains: ChainSettings {
            max_depth: 6,
            split_depth: 6,
            ..ChainSettings::default()
        },
        ..PhotonSettings::default()
    }
}

/// The ratio of a layer's texels with ink and without is `of` the channel's absorption.
fn assert_ratios(
    signature: &str,
    [with, without]: [&Estimate; 2],
    absorption: [f64; 3],
    of: impl Fn(f64) -> f64,
) {
    let pairs = layer(with, signature)
        .into_iter()
        .zip(layer(without, signature));
    for (texel, (inked, clear)) in pairs.enumerate() {
        for (c, &absorption) in absorption.iter().enumerate() {
            // Of single wavelengths a channel may be below zero.
            assert!(clear.0[c] != 0.0, "{signature}: texel {texel} is lit");
            let (ratio, expected) = (inked.0[c] / clear.0[c], of(absorption));
            // Sums are exact but for the quantum of fixed-point numbers, 2^-60 of the whole flux or less; a
            // layer is a thousandth of it, a texel 1/36,000 of the plate's light.
            assert!(
                (ratio - expected).abs() < 1e-9,
                "{signature}: texel {texel}, channel {c}: {ratio} is not {expected}"
            );
        }
    }
}

#[test]
fn light_that_crosses_a_plate_is_absorbed_by_the_length_of_its_way() {
    for [x, z] in [[0.0, -1.0], [1.0, -2.0]] {
        let [with, without] = [ink("name=\"interior\""), String::new()].map(|medium| {
            let scene = floored(&(sun([x, z]) + &plate(1.5, &medium)));
            by_photons_with(&scene, all_branches(), 1 << 18)
        });
        // Snell's law: the cosine inside.
        let sine = x / f64::hypot(x, z) / 1.5;
        let way = HEIGHT / (1.0 - sine * sine).sqrt();
        assert_ratios("LTTD", [&with, &without], INK, |ink| (-ink * way).exp());
        // Reflected at the bottom and at the top: three crossings.
        assert_ratios("LTRRTD", [&with, &without], INK, |ink| {
            (-3.0 * ink * way).exp()
        });
        let closure = with.ledger.closure_error().unwrap();
        assert!(closure < 1e-12, "the ledger is off by {closure}");
    }
}

#[test]
fn a_grey_medium_is_followed_in_one_channel() {
    let white = sun([0.0, -1.0]).replace("2, 3, 5", "1, 1, 1");
    let grey = ink("name=\"interior\"").replace("0.5, 1, 0", "0.6, 0.6, 0.6");
    let [with, without] = [grey, String::new()].map(|medium| {
        let scene = floored(&(white.clone() + &plate(1.5, &medium)));
        assert!(is_achromatic(&scene));
        by_photons_with(&scene, all_branches(), 1 << 16)
    });
    let absorption = [0.9; 3];
    assert_ratios("LTTD", [&with, &without], absorption, |it| {
        (-it * HEIGHT).exp()
    });
}

#[test]
fn light_of_single_wavelengths_is_absorbed_channel_by_channel() {
    let [with, without] = [ink("name=\"interior\""), String::new()].map(|medium| {
        let scene = floored(&(sun([0.0, -1.0]) + &plate(1.5, &medium)));
        let scene = scene.with_dispersion(&[("plate", "sf11")]).unwrap();
        by_photons_with(&scene, all_branches(), 1 << 16)
    });
    assert_ratios("LTTD", [&with, &without], INK, |it| (-it * HEIGHT).exp());
}

#[test]
fn a_lamps_light_through_matched_glass_is_absorbed_by_beer_and_lambert() {
    let lamp = "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"3\"/>\
                <rgb name=\"intensity\" value=\"2, 3, 5\"/></emitter>";
    let scene = floored(&(lamp.to_owned() + &plate(1.0, &ink("name=\"interior\""))));
    let estimate = by_photons(&scene, 1 << 21);
    let found = estimate
        .layers
        .iter()
        .find(|it| it.name.to_string() == "LTTD");
    let found = found.expect("two crossings of matched glass");
    let intensity = [2.0, 3.0, 5.0];
    let (mut squares, mut off, mut variance, mut light) = (0.0, [0.0; 3], [0.0; 3], [0.0; 3]);
    for texel in 0..SIDE * SIDE {
        for c in 0..3 {
            // I cos θ / r² exp(-σ h / cos θ), averaged over the texel: 8 x 8 points are exact to 1e-5.
            let mut expected = 0.0;
            for sub in 0..64 {
                let at = |cell: usize, sub: usize| {
                    2.0 * (cell as f64 + (sub as f64 + 0.5) / 8.0) / SIDE as f64 - 1.0
                };
                let (u, v) = (at(texel % SIDE, sub % 8), at(texel / SIDE, sub / 8));
                let squared = u * u + v * v + 9.0;
                let cosine = 3.0 / squared.sqrt();
                let left = (-INK[c] * HEIGHT / cosine).exp();
                expected += intensity[c] * cosine / squared * left / 64.0;
            }
            let (value, error) = (found.values[texel].0[c], found.standard_error[texel].0[c]);
            squares += ((value - expected) / error).powi(2) / (3 * SIDE * SIDE) as f64;
            off[c] += value - expected;
            variance[c] += error * error;
            light[c] += expected;
        }
    }
    // Bars of 32 replicates: z² is Student's, 31/29 in the mean. Texels of Sobol' points are not independent,
    // so that sums may be much nearer than their bars say, but not farther.
    assert!((0.7..1.4).contains(&squares), "mean z² is {squares}");
    for c in 0..3 {
        let bar = 4.0 * variance[c].sqrt();
        assert!(off[c].abs() < bar, "channel {c}: {} beside {bar}", off[c]);
        let joint = bar / light[c];
        assert!(joint < 0.01, "channel {c}: a bar of {joint} tells nothing");
    }
}

#[test]
fn a_ball_of_ink_has_the_lamp_light_that_paths_find() {
    let inked = format!("{}{}", dielectric(1.5), ink("name=\"interior\""));
    assert_as_paths("ink", &(ball(&inked) + LAMP), 0.03);
    // A mirror within, that does not say what is around it.
    let pebble = "<shape type=\"sphere\"><point name=\"center\" x=\"0.2\" y=\"-0.1\" z=\"1.6\"/>\
                  <float name=\"radius\" value=\"0.4\"/><bsdf type=\"conductor\"/></shape>";
    let elements = ball(&inked) + pebble + LAMP;
    assert_as_paths("a mirror in ink", &elements, 0.03);
}

#[test]
fn the_ledger_closes_and_black_glass_lets_nothing_through() {
    let scene_of = |scale: f64| {
        let medium = ink("name=\"interior\"").replace("1.5", &scale.to_string());
        floored(&(sun([0.0, -1.0]) + &plate(1.5, &medium)))
    };
    for scale in [1e-12, 1.0, 1e12] {
        let estimate = by_photons(&scene_of(scale), 1 << 16);
        let closure = estimate.ledger.closure_error().unwrap();
        assert!(closure < 1e-12, "scale {scale}: off by {closure}");
        let row = estimate.ledger.rows[&"LTTD".parse().unwrap()];
        let clear = row.received.0[2];
        assert!(clear > 0.0, "blue is not absorbed");
        if scale > 1e6 {
            assert_eq!([row.received.0[0], row.received.0[1]], [0.0, 0.0]);
        }
    }
}

/// Not quite none, so that lengths are those from the camera.
const NEAR: f64 = 1e-7;

/// A camera in a bubble of radius 0.5 that bends no light, above a ball and a floor.
fn from_a_bubble(medium: &str) -> Scene {
    let film = paths::film(12, 12, paths::BOX);
    paths::scene(&format!(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"2\"/></transform>\
         <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.5\"/></bsdf></shape>{}\
         <emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"5\"/></emitter>\
         <shape type=\"sphere\"><point name=\"center\" x=\"0\" y=\"-3\" z=\"2\"/>\
         <float name=\"radius\" value=\"0.5\"/>{}{medium}</shape>\
         <sensor type=\"perspective\"><float name=\"fov\" value=\"30\"/><float name=\"near_clip\" value=\"{NEAR}\"/>\
         <transform name=\"to_world\"><lookat origin=\"0, -3, 2\" target=\"0, 0, 0\" up=\"0, 0, 1\"/>\
         </transform>{film}</sensor>",
        ball(&dielectric(1.5)),
        dielectric(1.0)
    ))
}

#[test]
fn photon_maps_see_through_ink() {
    let [with, without] = [ink("name=\"interior\""), String::new()].map(|medium| {
        let scene = from_a_bubble(&medium);
        let settings = PhotonMapSettings {
            map_photons: 1 << 14,
            ..PhotonMapSettings::default()
        };
        let budget = Budget::work(settings.map_photons * 32);
        let camera = &scene.sensors()[0];
        by_maps(&scene, camera, settings, &budget, &Progress::default())
            .unwrap()
            .0
    });
    let total = |estimate: &Estimate| {
        let layers = estimate.layers.iter();
        layers.fold(vec![Rgb::BLACK; 144], |sum, layer| {
            let sums = sum.iter().zip(&layer.values);
            sums.map(|(a, b)| *a + *b).collect()
        })
    };
    let mut lit = 0;
    for (inked, clear) in total(&with).into_iter().zip(total(&without)) {
        for c in (0..3).filter(|&c| clear.0[c] > 0.0) {
            lit += 1;
            let expected = (-INK[c] * 0.5).exp();
            let ratio = inked.0[c] / clear.0[c];
            // The near plane is as far as 1.04 NEAR; sums have relative quanta of 1e-9 where the caustic is
            // faint.
            assert!((ratio - expected).abs() < 1e-6, "{ratio} is not {expected}");
        }
    }
    assert!(lit > 100, "only {lit} channels of pixels are lit");
}

fn refusal(method: &str, scene: &Scene, sensor: &Sensor) -> String {
    let method = Method::new(method, &Default::default()).unwrap();
    let run = method.run(scene, sensor, &Budget::work(1 << 12), &Context::default());
    run.err()
        .map_or_else(String::new, |error| error.to_string())
}

#[test]
fn methods_that_know_clear_media_only_say_so() {
    let medium = ink("name=\"interior\" id=\"ink\"");
    let scene = floored(&(sun([0.0, -1.0]) + &plate(1.5, &medium)));
    // Light volumes follow light through one open surface.
    let open = format!(
        "{}<shape type=\"rectangle\"><transform name=\"to_world\"><translate z=\"1\"/></transform>{}{medium}</shape>",
        sun([0.0, -1.0]),
        dielectric(1.5)
    );
    let open = floored(&open);
    for (method, scene) in [
        ("beams", &scene),
        ("closed-form", &scene),
        ("caustic-map", &scene),
        ("caustics-volume", &scene),
        ("local-irradiance", &scene),
        ("light-volume", &open),
    ] {
        let message = refusal(method, scene, &scene.sensors()[0]);
        let expected = "medium \"ink\" absorbs light on its way";
        assert!(message.contains(expected), "{method}: {message}");
    }
    let chosen = Method::choose(&scene, &scene.sensors()[0]).unwrap();
    assert_eq!(chosen.method.name(), "photons");
}

#[test]
fn photons_refuse_media_that_absorb_direct_light() {
    let medium = ink("name=\"interior\"");
    let open = format!(
        "{}<shape type=\"sphere\" id=\"cloud\"><bsdf type=\"null\"/>{medium}</shape>",
        sun([0.0, -1.0])
    );
    let inside = format!(
        "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"0.75\"/></emitter>{}",
        plate(1.5, &medium)
    );
    for (elements, expected) in [
        (open, "the medium at shape \"cloud\" absorbs direct light"),
        (inside, "the medium around emitter 0 absorbs direct light"),
    ] {
        let scene = floored(&elements);
        let message = refusal("photons", &scene, &scene.sensors()[0]);
        assert!(message.contains(expected), "{message}");
    }
    let scene = from_a_bubble(&medium);
    let camera = &scene.sensors()[0];
    let message = refusal("photons", &scene, camera);
    assert!(
        message.contains("is in a medium that absorbs light"),
        "{message}"
    );
    let chosen = Method::choose(&scene, camera).unwrap();
    assert_eq!(chosen.method.name(), "photon-map");
}

#[test]
fn lamps_in_a_medium_are_found() {
    let medium = ink("name=\"interior\"");
    let plate = plate(1.5, &medium);
    let lamp = |kind: &str, at: f64| {
        format!(
            "<shape type=\"{kind}\"><transform name=\"to_world\"><scale value=\"0.3\"/>\
             <translate z=\"{at}\"/></transform><emitter type=\"area\"/></shape>"
        )
    };
    let spot = |at: f64| {
        format!(
            "<emitter type=\"spot\"><transform name=\"to_world\"><translate z=\"{at}\"/></transform></emitter>"
        )
    };
    let told = "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"3\"/><ref id=\"ink\"/></emitter>";
    let ink = ink("id=\"ink\"");
    for (lamp, is_immersed) in [
        (spot(0.75), true),
        (spot(1.25), false),
        (lamp("rectangle", 0.75), true),
        (lamp("rectangle", 1.25), false),
        (lamp("sphere", 3.0), false),
        (lamp("cube", 0.3), true),
        // Its top is above the plate, its bottom below, its equator within.
        (lamp("sphere", 0.75), true),
        (sun([0.0, -1.0]), false),
        (format!("{ink}{told}"), true),
    ] {
        let scene = floored(&(lamp.clone() + &plate));
        let found = first_immersed(&scene).is_some();
        assert_eq!(found, is_immersed, "{lamp}");
    }
}

#[test]
fn a_camera_at_a_border_is_refused_unless_the_file_tells_its_medium() {
    let film = paths::film(4, 4, paths::BOX);
    let half_in = |told: &str| {
        paths::scene(&format!(
            "{}<shape type=\"cube\"><transform name=\"to_world\"><translate x=\"1\"/></transform>{}\
             <ref name=\"interior\" id=\"ink\"/></shape><emitter type=\"constant\"/>\
             <sensor type=\"orthographic\"><float name=\"near_clip\" value=\"0.1\"/>\
             <transform name=\"to_world\"><scale value=\"0.5\"/>\
             <lookat origin=\"0, 0, 0\" target=\"0, 1, 0\" up=\"0, 0, 1\"/></transform>{film}{told}</sensor>",
            ink("id=\"ink\""),
            dielectric(1.0)
        ))
    };
    let scene = half_in("");
    let message = refusal("path", &scene, &scene.sensors()[0]);
    assert!(message.contains("partly in a medium"), "{message}");
    let scene = half_in("<ref id=\"ink\"/>");
    assert_eq!(refusal("path", &scene, &scene.sensors()[0]), "");
}

#[test]
fn full_takes_photons_for_what_ink_colours() {
    let film = paths::film(8, 8, paths::BOX);
    let inked = format!("{}{}", dielectric(1.5), ink("name=\"interior\""));
    let scene = paths::scene(&format!(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"2\"/></transform>\
         <bsdf type=\"diffuse\"/></shape>{}{}{}",
        ball(&inked),
        sun([0.0, -1.0]),
        paths::camera(30.0, &film)
    ));
    let settings = PathSettings::default();
    let plan = Plan::new(&scene, &scene.sensors()[0], &settings).unwrap();
    assert_eq!(plan.finder(PathClass::Caustic), Finder::Photons);
    let feature = |name: &str| {
        let all = requirements(&scene);
        all.into_iter()
            .find(|it| it.feature == name)
            .unwrap()
            .needed
    };
    assert!(feature("absorbing media") && feature("colour"));
}

#[test]
fn a_medium_that_absorbs_nothing_changes_no_bit() {
    let scale_0 = ink("name=\"interior\"").replace("1.5", "0");
    let [with, without] = [scale_0, String::new()].map(|medium| {
        let scene = floored(&(sun([1.0, -2.0]) + &plate(1.5, &medium)));
        assert!(scene.is_clear());
        by_photons(&scene, 1 << 14)
    });
    assert_eq!(paths::bits(&with), paths::bits(&without));
}
