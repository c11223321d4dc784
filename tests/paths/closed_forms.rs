//! Images by paths against closed forms.

use std::f64::consts::PI;

use nephroid::internals::numeric::StreamKind;
use nephroid::internals::reference::path::{LightSampling, PathSettings};
use nephroid::internals::transport::path_class::PathClass;

use crate::support;
use crate::support::paths::{
    BOX, assert_mean, camera, class, film, image, scene, with_32_replicates,
};

const WAYS: [LightSampling; 4] = [
    LightSampling::Power,
    LightSampling::Balance,
    LightSampling::Emitters,
    LightSampling::Surfaces,
];

/// A cube about the camera whose six walls have radiance 1 and albedo 1/2: at every point the light that
/// arrives is the same from everywhere, L = 1 + L/2 = 2; and with at most n legs L = 2 − 2^(1−n).
fn furnace() -> String {
    let walls = [
        "<translate z=\"-4\"/>",
        "<rotate x=\"1\" angle=\"180\"/><translate z=\"4\"/>",
        "<rotate x=\"1\" angle=\"90\"/><translate y=\"4\"/>",
        "<rotate x=\"1\" angle=\"-90\"/><translate y=\"-4\"/>",
        "<rotate y=\"1\" angle=\"90\"/><translate x=\"-4\"/>",
        "<rotate y=\"1\" angle=\"-90\"/><translate x=\"4\"/>",
    ];
    let wall = |place: &str| {
        format!(
            "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"4\"/>{place}</transform>\
             <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.5\"/></bsdf>\
             <emitter type=\"area\"><rgb name=\"radiance\" value=\"1\"/></emitter></shape>"
        )
    };
    walls.map(wall).concat()
}

#[test]
fn in_a_furnace_paths_without_choices_have_no_variance_at_all() {
    let scene = scene(&format!("{}{}", camera(60.0, &film(8, 6, BOX)), furnace()));
    for legs in [1, 2, 5, 30] {
        let settings = PathSettings {
            light_sampling: LightSampling::Surfaces,
            max_depth: Some(legs),
            rr_depth: u32::MAX,
            ..with_32_replicates()
        };
        let found = image(&scene, settings, 32);
        let truth = 2.0 - 2f64.powi(1 - legs as i32);
        for (value, error) in found.total.values.iter().zip(&found.total.standard_error) {
            // Every leg adds a power of two: nothing is rounded but the weights' quotient.
            assert!((value.0[0] - truth).abs() < 1e-14, "{legs} legs: {value:?}");
            assert!(error.0[0] < 1e-14);
        }
    }
}

#[test]
fn a_furnace_is_as_bright_as_its_series_however_light_is_found() {
    let scene = scene(&format!(
        "{}{}",
        camera(60.0, &film(16, 12, BOX)),
        furnace()
    ));
    // Sampling emitters alone has no variance to speak of: where two walls meet, cos cos'/r² is not square
    // integrable.
    let ways = WAYS
        .into_iter()
        .filter(|way| *way != LightSampling::Emitters);
    for light_sampling in ways {
        for stream in [StreamKind::Sobol, StreamKind::Random] {
            let settings = PathSettings {
                light_sampling,
                stream,
                rr_depth: 3,
                ..with_32_replicates()
            };
            let found = image(&scene, settings, 128);
            let claim = format!("{light_sampling:?}, {stream:?}");
            assert_mean(&claim, &found.total, 2.0, 0.02);
            // By class: directly seen, one event, the rest.
            let of = |name| class(&found, name).unwrap();
            assert_mean(&claim, of(PathClass::Emitted), 1.0, 1e-12);
            assert_mean(&claim, of(PathClass::Direct), 0.5, 0.02);
            assert_mean(&claim, of(PathClass::Indirect), 0.5, 0.05);
            assert_eq!(found.layers.len(), 3);
        }
    }
}

#[test]
fn error_bars_are_as_wide_as_errors() {
    let scene = scene(&format!(
        "{}{}",
        camera(60.0, &film(32, 24, BOX)),
        furnace()
    ));
    // Random points, and many of them: the mean of a replicate is nearly normal.
    let settings = PathSettings {
        stream: StreamKind::Random,
        ..with_32_replicates()
    };
    let found = image(&scene, settings, 32 * 16);
    let squares: f64 = found
        .total
        .values
        .iter()
        .zip(&found.total.standard_error)
        .map(|(value, error)| ((value.0[0] - 2.0) / error.0[0]).powi(2))
        .sum();
    let pixels = found.total.values.len() as f64;
    let expected = support::student::moments(31);
    // Four standard errors of a mean of squared t; replicates that are not quite normal need the fifth.
    let tolerance = 5.0 * expected.deviation_of_square / pixels.sqrt();
    let mean = squares / pixels;
    assert!(
        (mean - expected.variance).abs() < tolerance,
        "mean z² {mean}, not {} ± {tolerance}",
        expected.variance
    );
}

/// A floor of albedo 0.8 at z = 0, seen from straight above, over so small a field that its light is that of
/// the origin: to (5e-4)² of itself.
const FLOOR_SEEN: &str = "<shape type=\"rectangle\"><bsdf type=\"diffuse\">\
    <rgb name=\"reflectance\" value=\"0.8\"/></bsdf></shape>";

fn from_above(film: &str) -> String {
    format!(
        "<sensor type=\"orthographic\"><transform name=\"to_world\"><scale value=\"5e-4\"/>\
         <lookat origin=\"0, 0, 0.5\" target=\"0, 0, 0\" up=\"0, 1, 0\"/></transform>{film}</sensor>"
    )
}

fn over_floor(light: &str) -> nephroid::internals::scene::Scene {
    scene(&format!(
        "{}{FLOOR_SEEN}{light}",
        from_above(&film(4, 4, BOX))
    ))
}

#[test]
fn a_disc_light_over_a_floor_is_its_closed_form() {
    // E = π L r² / (r² + h²), L' = ρ/π E. h = 1, r = 0.75, L = 3.
    let lamp = "<shape type=\"disk\"><transform name=\"to_world\"><scale value=\"0.75\"/>\
        <rotate x=\"1\" angle=\"180\"/><translate z=\"1\"/></transform><bsdf type=\"diffuse\">\
        <rgb name=\"reflectance\" value=\"0\"/></bsdf><emitter type=\"area\">\
        <rgb name=\"radiance\" value=\"3\"/></emitter></shape>";
    let truth = 0.8 * 3.0 * 0.5625 / 1.5625;
    let scene = over_floor(lamp);
    for light_sampling in WAYS {
        let settings = PathSettings {
            light_sampling,
            ..with_32_replicates()
        };
        let found = image(&scene, settings, 4096);
        assert_mean(&format!("{light_sampling:?}"), &found.total, truth, 3e-3);
        assert_eq!(found.layers.len(), 1, "all of it is direct light");
    }
}

#[test]
fn a_ball_light_over_a_floor_is_its_closed_form() {
    // E = π L R² / d², the ball above the horizon. d = 1, R = 0.3, L = 3.
    let lamp = "<shape type=\"sphere\"><point name=\"center\" value=\"0, 0, 1\"/>\
        <float name=\"radius\" value=\"0.3\"/><bsdf type=\"diffuse\">\
        <rgb name=\"reflectance\" value=\"0\"/></bsdf><emitter type=\"area\">\
        <rgb name=\"radiance\" value=\"3\"/></emitter></shape>";
    let scene = over_floor(lamp);
    for light_sampling in WAYS {
        let settings = PathSettings {
            light_sampling,
            max_depth: Some(2),
            ..with_32_replicates()
        };
        let found = image(&scene, settings, 4096);
        let direct = class(&found, PathClass::Direct).unwrap();
        assert_mean(
            &format!("{light_sampling:?}"),
            direct,
            0.8 * 3.0 * 0.09,
            3e-3,
        );
    }
}

#[test]
fn light_through_a_mask_and_a_null_surface_keeps_what_they_let_pass() {
    // A point light at h = 1: L' = ρ/π I / h², times what passes the sheet between.
    let lamp = "<emitter type=\"point\"><point name=\"position\" value=\"0, 0, 1\"/>\
        <rgb name=\"intensity\" value=\"2\"/></emitter>";
    let sheet = |bsdf: &str| {
        format!(
            "<shape type=\"rectangle\"><transform name=\"to_world\"><translate z=\"0.8\"/></transform>{bsdf}</shape>"
        )
    };
    let black = "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0\"/></bsdf>";
    let mask =
        format!("<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.25\"/>{black}</bsdf>");
    let open = 0.8 / PI * 2.0;
    for (bsdf, passed) in [
        ("<bsdf type=\"null\"/>", 1.0),
        (mask.as_str(), 0.75),
        (black, 0.0),
    ] {
        let scene = over_floor(&format!("{lamp}{}", sheet(bsdf)));
        let found = image(&scene, with_32_replicates(), 64);
        let (value, _) = support::paths::mean(&found.total, 0);
        // The field's far corner is 7e-4 off the axis: 3/2 (7e-4)² = 7e-7 of the light at most.
        assert!(
            (value - open * passed).abs() <= 7e-7 * open,
            "{bsdf}: {value}"
        );
    }
    // Of a disc light paths run through the mask, too, and both ways to find it must weigh alike.
    let lamp = "<shape type=\"disk\"><transform name=\"to_world\"><scale value=\"0.75\"/>\
        <rotate x=\"1\" angle=\"180\"/><translate z=\"1\"/></transform><bsdf type=\"diffuse\">\
        <rgb name=\"reflectance\" value=\"0\"/></bsdf><emitter type=\"area\">\
        <rgb name=\"radiance\" value=\"3\"/></emitter></shape>";
    let scene = over_floor(&format!("{lamp}{}", sheet(&mask)));
    for light_sampling in WAYS {
        let settings = PathSettings {
            light_sampling,
            // Passing is no leg: two are enough.
            max_depth: Some(2),
            ..with_32_replicates()
        };
        let found = image(&scene, settings, 4096);
        let truth = 0.75 * 0.8 * 3.0 * 0.5625 / 1.5625;
        assert_mean(&format!("{light_sampling:?}"), &found.total, truth, 5e-3);
    }
}

#[test]
fn radiance_behind_glass_scales_by_the_square_of_its_index_and_back() {
    // A wall of radiance 1 through a slab of glass, straight on: both interfaces pass 1 − F, F = 1/25, and
    // what they throw to and fro adds up to (1 − F) / (1 + F).
    let wall = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"50\"/>\
        <rotate x=\"1\" angle=\"90\"/><translate y=\"5\"/></transform><bsdf type=\"diffuse\">\
        <rgb name=\"reflectance\" value=\"0\"/></bsdf><emitter type=\"area\">\
        <rgb name=\"radiance\" value=\"1\"/></emitter></shape>";
    let slab = "<shape type=\"cube\"><transform name=\"to_world\"><scale x=\"9\" y=\"0.5\" z=\"9\"/></transform>\
        <bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/>\
        </bsdf></shape>";
    let scene = scene(&format!("{}{wall}{slab}", camera(0.01, &film(8, 8, BOX))));
    // Roulette must not be misled by radiance that is n² times as high inside of the glass.
    let settings = PathSettings {
        rr_depth: 1,
        ..with_32_replicates()
    };
    let found = image(&scene, settings, 2048);
    let reflectance: f64 = 0.04;
    let truth = (1.0 - reflectance) / (1.0 + reflectance);
    assert_mean("slab", &found.total, truth, 2e-3);
}
