//! Mirrors and glass whose factors vary by a texture.

use std::collections::BTreeMap;

use nephroid::Method;
use nephroid::internals::run::{Budget, Context};
use nephroid::internals::scene::Scene;

use super::metered::{by_photons, layer, scene_above_a_floor};
use super::rough::{LAMP, assert_as_paths, ball};

/// Texels a side of a floor from -1 to 1.
const SIDE: usize = 16;

const COLORS: [[f64; 3]; 2] = [[0.2, 0.3, 0.6], [0.9, 0.8, 0.5]];

/// Four squares over the unit square of (u, v), or another number of them.
fn board(factor: &str, scale: f64) -> String {
    let [[a, b, c], [d, e, f]] = COLORS;
    format!(
        "<texture type=\"checkerboard\" name=\"{factor}\"><rgb name=\"color0\" value=\"{a}, {b}, {c}\"/>\
         <rgb name=\"color1\" value=\"{d}, {e}, {f}\"/>\
         <transform name=\"to_uv\"><scale value=\"{scale}\"/></transform></texture>"
    )
}

fn floored(elements: &str) -> Scene {
    scene_above_a_floor(elements, SIDE)
}

/// A sun straight down, or one that a mirror beside the floor turns down to it.
fn sun([x, z]: [f64; 2]) -> String {
    format!(
        "<emitter type=\"directional\"><vector name=\"direction\" x=\"{x}\" y=\"0\" z=\"{z}\"/></emitter>"
    )
}

#[test]
fn each_photon_takes_the_factor_of_its_place() {
    let sheet = "<translate z=\"1\"/>";
    // Upright at x = 1, with u up: light at 45 degrees falls at x = 1 - z, so that u falls along x.
    let mirror = "<rotate y=\"1\" angle=\"-90\"/><translate x=\"1\" z=\"1\"/>";
    let (down, across) = ([0.0, -1.0], [1.0, -1.0]);
    for (signature, bsdf) in [
        ("LTD", "dielectric"),
        ("LTD", "thindielectric"),
        ("LRD", "conductor"),
        ("LRD", "thindielectric"),
    ] {
        let is_mirror = signature == "LRD";
        let (light, placed, factor) = if is_mirror {
            (across, mirror, "specular_reflectance")
        } else {
            (down, sheet, "specular_transmittance")
        };
        let of = |texture: &str| {
            let shape = format!(
                "<shape type=\"rectangle\"><transform name=\"to_world\">{placed}</transform>\
                 <bsdf type=\"{bsdf}\">{texture}</bsdf></shape>"
            );
            let scene = floored(&(sun(light) + &shape));
            layer(&by_photons(&scene, 1 << 16), signature)
        };
        let (textured, plain) = (of(&board(factor, 1.0)), of(""));
        for (texel, (found, white)) in textured.iter().zip(&plain).enumerate() {
            let is_low = |index: usize| usize::from(index < SIDE / 2);
            let u_is_low = is_low(texel % SIDE) ^ usize::from(is_mirror);
            let color = COLORS[u_is_low ^ is_low(texel / SIDE)];
            for (c, expected) in color.into_iter().enumerate() {
                assert!(white.0[c] > 0.0, "{bsdf}: texel {texel} is lit");
                let ratio = found.0[c] / white.0[c];
                // The same photons: sums differ by their quantum alone.
                assert!(
                    (ratio - expected).abs() < 1e-9,
                    "{bsdf} {signature}: texel {texel}, channel {c}: {ratio} is not {expected}"
                );
            }
        }
    }
}

#[test]
fn a_patterned_ball_of_glass_has_the_lamp_light_that_paths_find() {
    let bsdf = format!(
        "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/>{}{}</bsdf>",
        board("specular_transmittance", 3.0),
        board("specular_reflectance", 2.0)
    );
    assert_as_paths("patterned glass", &(ball(&bsdf) + LAMP), 0.03);
}

#[test]
fn methods_that_need_one_colour_say_so() {
    let shape = |kind: &str| {
        format!(
            "<shape type=\"{kind}\" id=\"glass\"><transform name=\"to_world\"><scale value=\"0.5\"/>\
             <translate z=\"1\"/></transform><bsdf type=\"dielectric\">{}</bsdf></shape>",
            board("specular_transmittance", 1.0)
        )
    };
    for (method, kind) in [
        ("beams", "sphere"),
        ("caustic-map", "sphere"),
        ("caustics-volume", "sphere"),
        ("local-irradiance", "sphere"),
        ("light-volume", "rectangle"),
    ] {
        let scene = floored(&(sun([0.0, -1.0]) + &shape(kind)));
        let (sensor, method) = (&scene.sensors()[0], Method::new(method, &BTreeMap::new()));
        let run = method.unwrap();
        let run = run.run(&scene, sensor, &Budget::work(1 << 12), &Context::default());
        let message = run
            .err()
            .map_or_else(String::new, |error| error.to_string());
        let expected = "shape \"glass\" has a dielectric with a texture";
        assert!(message.contains(expected), "{kind}: {message}");
    }
}
