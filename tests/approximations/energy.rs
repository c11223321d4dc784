//! The flux of each stage's approximate form against closed forms of that approximation, and the account of it.

use std::f64::consts::PI;

use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::{FluxEntry, Rendering};
use nephroid::internals::scene::Scene;

use super::approximate_ball::{ApproximateBall, BALL, Through, fresnel, schlick, solid_angle};
use crate::support::approximation::{
    GLASS, ball, bundled, caustic_map, exact_but, lit_by, over_floor, rendered, scene_of,
};

/// Intensity of the lamp \[W/sr\].
const INTENSITY: f64 = 100.0;

/// Half the side of the light's image at distance 1: the floor's, 2 by 4, with a margin of a thousandth. The
/// ball has 0.417.
const HALF: f64 = 1.001 * 0.5;

/// A disc of 213 pixels' radius, the ball in a picture of 512², has as many centres as its area within 0.2 %; the
/// normals' pixels add as much at the border of total reflection.
const FIVE_IN_A_THOUSAND: f64 = 5e-3;

/// Solid angle of the light's image: of a square pyramid, by its half-slope.
fn pyramid() -> f64 {
    4.0 * (HALF * HALF / (1.0 + HALF * HALF)).asin()
}

fn image_flux(rendering: &Rendering, area: f64) -> f64 {
    let values = &rendering.estimate.total.values;
    values.iter().map(|value| value.mean()).sum::<f64>() * area
}

/// The light of the floor of 4 x 4 \[W\].
fn floor_flux(rendering: &Rendering) -> f64 {
    image_flux(
        rendering,
        16.0 / rendering.estimate.total.values.len() as f64,
    )
}

fn of<'a>(rendering: &'a Rendering, reason: &str) -> Option<&'a FluxEntry> {
    rendering.flux.iter().find(|entry| entry.reason == reason)
}

fn ball_scene(side: usize) -> Scene {
    scene_of(&over_floor(&ball(GLASS), side))
}

/// Flux \[W\] of the ball's light in closed form: `weight` of what each slope sends.
fn expected(last: f64, weight: impl Fn(f64, &Through) -> f64) -> f64 {
    BALL.integral(last, |slope, ray| INTENSITY * weight(slope, ray))
}

/// A map of image-space refraction with everything else exact but for some settings; no beams, since the
/// picture of normals has steps.
fn approximate(pairs: &[(&str, &str)]) -> Rendering {
    let common = [
        ("refraction", "image-space"),
        ("total-reflection", "drop"),
        ("no-back-face", "drop"),
        ("splat", "fixed"),
        ("splat-size", "1"),
    ];
    rendered(&exact_but(&[&common, pairs].concat()), &ball_scene(32))
}

#[test]
fn each_approximate_factor_of_a_balls_energy_is_that_of_its_closed_form() {
    let total = BALL.false_total_reflection();
    let whole = (2.0 * HALF).powi(2);
    let pyramid = pyramid();
    type Weight = fn(f64, &Through) -> f64;
    let share = |reflectance: fn(f64, f64) -> f64, ray: &Through| {
        let first = 1.0 - reflectance(ray.incidence.cos(), BALL.eta);
        first * (1.0 - reflectance(ray.cos_exit, 1.0 / BALL.eta))
    };
    let own: Weight = |slope, _| solid_angle(slope);
    let landing = |_: f64, ray: &Through| {
        ray.radius
            .map_or(0.0, |radius| solid_angle(radius.abs() / BALL.floor))
    };
    let cases: [(&[(&str, &str)], f64); 7] = [
        (&[("fresnel", "none")], expected(total, own)),
        (
            &[("fresnel", "none"), ("total-reflection", "clamp")],
            // The clamped ring lands too, all of it within the map.
            expected(BALL.edge(), own),
        ),
        (
            &[("fresnel", "schlick")],
            expected(total, |slope, ray| solid_angle(slope) * share(schlick, ray)),
        ),
        (
            &[("fresnel", "exact")],
            expected(total, |slope, ray| solid_angle(slope) * share(fresnel, ray)),
        ),
        (
            &[("fresnel", "none"), ("flux", "uniform")],
            expected(total, |_, _| pyramid / whole),
        ),
        (
            &[("fresnel", "none"), ("flux", "density-ratio")],
            expected(total, landing),
        ),
        (
            &[("fresnel", "exact"), ("flux", "density-ratio")],
            expected(total, |slope, ray| {
                landing(slope, ray) * share(fresnel, ray)
            }),
        ),
    ];
    for (pairs, expected) in cases {
        let found = floor_flux(&approximate(pairs));
        println!("{pairs:?}: {found:.4} W, closed form {expected:.4} W");
        assert!(
            (found / expected - 1.0).abs() < FIVE_IN_A_THOUSAND,
            "{pairs:?}: {found} {expected}"
        );
    }
}

#[test]
fn the_account_of_a_ball_has_the_closed_forms_figures() {
    let rendering = approximate(&[("flux", "density-ratio"), ("fresnel", "schlick")]);
    let total = BALL.false_total_reflection();
    let sent = |slope: f64| 2.0 * PI * INTENSITY * (1.0 - 1.0 / (1.0 + slope * slope).sqrt());
    let left_by = |reflectance: fn(f64, f64) -> f64, slope: f64, ray: &Through| {
        let first = 1.0 - reflectance(ray.incidence.cos(), BALL.eta);
        solid_angle(slope) * first * (1.0 - reflectance(ray.cos_exit, 1.0 / BALL.eta))
    };
    let left = |slope: f64, ray: &Through| left_by(schlick, slope, ray);
    let by_fresnel = expected(total, |slope, ray| left_by(fresnel, slope, ray));
    let normalised = expected(total, |slope, ray| {
        let at = ray.radius.unwrap_or(0.0).abs() / BALL.floor;
        left(slope, ray) * (solid_angle(at) / solid_angle(slope) - 1.0)
    });
    for (reason, expected) in [
        ("sets out", sent(BALL.edge())),
        (
            "total reflection at the exit",
            sent(total) - sent(BALL.edge()),
        ),
        ("taken by interfaces", by_fresnel - sent(total)),
        ("of that not modelled", expected(total, left) - by_fresnel),
        ("change by normalisation", normalised),
    ] {
        let found = of(&rendering, reason).unwrap().flux.mean();
        println!("{reason}: {found:.4} W, closed form {expected:.4} W");
        // Of a part, relative to all that sets out.
        let allowed = FIVE_IN_A_THOUSAND * sent(BALL.edge());
        assert!(
            (found - expected).abs() < allowed,
            "{reason}: {found} {expected}"
        );
    }
}

#[test]
fn glass_that_does_not_refract_makes_direct_light() {
    // Direct light within the ball's shadow: a disc of radius 4 tan(asin(1/2.6)).
    const SIDE: usize = 128;
    const PARTS: usize = 16;
    let glass = GLASS.replace("\"1.5\"", "\"1.0001\"");
    assert_ne!(glass, GLASS);
    let scene = scene_of(&over_floor(&ball(&glass), SIDE));
    let radius = 4.0 * BALL.edge();
    let direct: Vec<f64> = (0..SIDE * SIDE)
        .map(|texel| {
            let mut sum = 0.0;
            for part in 0..PARTS * PARTS {
                let column = (texel % SIDE * PARTS + part % PARTS) as f64 + 0.5;
                let row = (texel / SIDE * PARTS + part / PARTS) as f64 + 0.5;
                let scale = 4.0 / (SIDE * PARTS) as f64;
                let (x, y) = (column * scale - 2.0, row * scale - 2.0);
                let beside = x * x + y * y;
                if beside < radius * radius {
                    sum += INTENSITY * 4.0 / (beside + 16.0).powf(1.5);
                }
            }
            sum / (PARTS * PARTS) as f64
        })
        .collect();
    let light: f64 = direct.iter().sum();
    let off = |pairs: &[(&str, &str)]| {
        let found = rendered(&caustic_map(pairs), &scene);
        let values = found.estimate.total.values.iter();
        let pairs = values.zip(&direct);
        pairs.map(|(a, t)| (a.mean() - t).abs()).sum::<f64>() / light
    };
    // All settings as the authors had them. The disc's border, 213 texels from its middle, is blurred by splats
    // of D0 = 3 and by look-ups: an L1 of 0.8 σ / 213, σ about 0.7 texels. Photons in a lattice and Gaussians of
    // half a texel leave ripples below 1 %.
    let authors = off(&[]);
    println!(
        "L1 as the authors have it: {authors:.4}, uniform: {:.4}",
        off(&[("flux", "uniform")])
    );
    assert!(authors < 0.02, "{authors}");
    // Uniform photons have the frustum's mean solid angle everywhere.
    let mean = pyramid() / (2.0 * HALF).powi(2);
    let differing = BALL.integral(BALL.edge(), |slope, _| (mean - solid_angle(slope)).abs());
    let expected = differing / BALL.integral(BALL.edge(), |slope, _| solid_angle(slope));
    let uniform = off(&[("flux", "uniform")]);
    println!("closed form of uniform: {expected:.4}");
    assert!((uniform - expected).abs() < 0.02, "{uniform} {expected}");
}

#[test]
fn narrow_and_coarse_photon_buffers_have_the_same_density_where_light_is_not_bent() {
    // Both frustums have the ball's and the lamp's axis, so that only pixels by slope differ.
    let glass = GLASS.replace("\"1.5\"", "\"1.0001\"");
    let scene = scene_of(&over_floor(&ball(&glass), 64));
    let expected = 2.0 * PI * INTENSITY * (1.0 - BALL.edge().atan().cos());
    for (frustum, photons) in [("scene", "512"), ("object", "512"), ("object", "400")] {
        let pairs = [
            ("frustum", frustum),
            ("photons", photons),
            ("base-size", "4"),
        ];
        let found = floor_flux(&rendered(&caustic_map(&pairs), &scene));
        assert!(
            (found / expected - 1.0).abs() < FIVE_IN_A_THOUSAND,
            "{pairs:?}: {found} {expected}"
        );
    }
}

#[test]
fn one_interface_of_an_open_surface_is_passed_as_snells_law_says() {
    // Flat water at height 1 under a lamp at height 4: all its light, which the floor has more than all of.
    let water = r#"<shape type="rectangle"><transform name="to_world"><scale x="1" y="1"/><translate z="1"/></transform>
        <bsdf type="dielectric"><float name="int_ior" value="1.33"/><float name="ext_ior" value="1"/></bsdf></shape>"#;
    let scene = scene_of(&over_floor(water, 64));
    // Beams: a lattice of photons would have a row more or less at the border.
    let rendering = rendered(&exact_but(&[]), &scene);
    let name = nephroid::internals::run::Light::Path("LTD".parse().unwrap());
    assert_eq!(rendering.light, name);
    // The rectangle of half-slope 1/3, by the midpoint rule.
    let parts = 1000;
    let mut expected = 0.0;
    for index in 0..parts * parts {
        let at = |index: i32| (2.0 * (f64::from(index) + 0.5) / f64::from(parts) - 1.0) / 3.0;
        let (x, y) = (at(index % parts), at(index / parts));
        let cos = 1.0 / (1.0 + x * x + y * y).sqrt();
        expected += INTENSITY * cos.powi(3) * (1.0 - fresnel(cos, 1.33));
    }
    expected *= (2.0 / 3.0 / f64::from(parts)).powi(2);
    let found = floor_flux(&rendering);
    println!("{found} {expected}");
    assert!(
        (found / expected - 1.0).abs() < FIVE_IN_A_THOUSAND,
        "{found} {expected}"
    );
    // And the border of its light: tan θt from 3 of air on, at 1/3 of slope.
    let sine: f64 = (1.0_f64 / 3.0).atan().sin() / 1.33;
    let border = 1.0 + sine / (1.0 - sine * sine).sqrt();
    let values = &rendering.estimate.total.values;
    let middle = &values[32 * 64..33 * 64];
    let lit = middle.iter().filter(|value| value.mean() > 1.0).count() as f64 / 64.0 * 4.0;
    // To a texel of 1/16 on either side.
    assert!((lit - 2.0 * border).abs() < 2.0 / 16.0, "{lit} {border}");
}

#[test]
fn the_account_adds_up_to_the_images_flux_whatever_the_settings() {
    let scenes = [
        (ball_scene(32), 16.0 / 1024.0),
        (bundled("coffee-cup", 32), 64.0 / 1024.0),
        (bundled("parabolic-mirror", 16), 0.0256 / 256.0),
        (bundled("glass-ball-behind-pane", 16), 16.0 / 256.0),
    ];
    let settings: [&[(&str, &str)]; 13] = [
        &[],
        &[("flux", "uniform"), ("fresnel", "schlick"), ("view", "f16")],
        &[
            ("total-reflection", "drop"),
            ("no-back-face", "drop"),
            ("frames", "3"),
        ],
        &[
            ("hit", "fixed-point"),
            ("back", "nearest"),
            ("thickness", "view"),
        ],
        &[
            ("kernel", "wyman-2008"),
            ("splat", "fixed"),
            ("splat-size", "2.5"),
        ],
        &[
            ("splat", "multi-resolution"),
            ("lookup", "nearest"),
            ("kernel", "wyman-2008"),
        ],
        &[("splat", "mip"), ("lookup", "exact")],
        &[("splat", "mip-splat"), ("frustum", "object")],
        &[("splat", "two-curvatures"), ("fresnel", "exact")],
        &[("splat", "exact"), ("frames", "2")],
        &[("splat", "exact"), ("lookup", "exact")],
        &[
            ("splat", "exact"),
            ("lookup", "exact"),
            ("hit", "exact"),
            ("flux", "exact"),
        ],
        &[
            ("refraction", "exact"),
            ("fresnel", "exact"),
            ("hit", "exact"),
            ("flux", "exact"),
        ],
    ];
    for (scene, area) in &scenes {
        for pairs in settings {
            let size = [("photons", "96"), ("map", "80")];
            let rendering = rendered(&caustic_map(&[&size, pairs].concat()), scene);
            let image: Rgb = rendering.estimate.total.values.iter().copied().sum();
            let image = image * *area;
            let account: Rgb = rendering.flux.iter().map(|entry| entry.flux).sum();
            let sent = of(&rendering, "sets out").unwrap().flux.mean();
            let off = (account - image)
                .0
                .iter()
                .fold(0.0, |all: f64, x| all.max(x.abs()));
            assert!(off < 1e-9 * sent, "{pairs:?}: {account:?} {image:?}");
            assert!(sent > 0.0);
            // What is dropped is not added.
            for reason in [
                "no back face",
                "total reflection at the exit",
                "meets no receiver",
            ] {
                let flux = of(&rendering, reason).map_or(0.0, |entry| entry.flux.mean());
                assert!(flux <= 0.0, "{reason}: {flux}");
            }
        }
    }
}

#[test]
fn the_account_is_in_the_report_and_has_the_same_bits_on_any_threads() {
    let scene = ball_scene(24);
    for splat in ["thin-lens", "multi-resolution", "exact"] {
        let map = caustic_map(&[("photons", "96"), ("map", "80"), ("splat", splat)]);
        let [one, many] = [1, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| rendered(&map, &scene))
        });
        assert_eq!(one.flux, many.flux, "{splat}");
        let listed = one.report["flux"].as_array().unwrap();
        assert_eq!(listed.len(), one.flux.len());
        assert_eq!(listed[0]["reason"], "sets out");
        assert!(listed[0]["flux"][0].as_f64().unwrap() > 0.0);
    }
}

#[test]
fn the_filter_of_2008_loses_what_its_integral_is_short_of_one() {
    let scene = ball_scene(24);
    // ∫ w dA over the circle: π α (1/4 − (1/4 − (1 − e^(−β/2)) / 2β) / (1 − e^−β)) / 0.42.
    let (alpha, beta): (f64, f64) = (0.918, 1.953);
    let fall = (0.25 - (1.0 - (-0.5 * beta).exp()) / (2.0 * beta)) / (1.0 - (-beta).exp());
    let integral = PI * alpha * (0.25 - fall) / 0.42;
    for (size, allowed) in [("31", 1e-4), ("2.5", 5e-4)] {
        let pairs = [
            ("kernel", "wyman-2008"),
            ("splat", "fixed"),
            ("splat-size", size),
        ];
        let rendering = rendered(&caustic_map(&pairs), &scene);
        let before = |entry: &&FluxEntry| !["splat", "lookup"].contains(&entry.stage);
        let landed: Rgb = rendering
            .flux
            .iter()
            .filter(before)
            .map(|entry| entry.flux)
            .sum();
        let added = of(&rendering, "weights of the kernel").unwrap().flux.mean() / landed.mean();
        println!("{size} texels: {added:.5}, integral {:.5}", integral - 1.0);
        // Sums over the centres of 31² texels are the integral; of 2.5 they vary by 10 %, which 90,000 photons
        // at all places of a texel average out to a few 1e-4.
        assert!(
            (added - (integral - 1.0)).abs() < allowed,
            "{size}: {added} {integral}"
        );
    }
}

#[test]
fn an_approximate_ball_of_thickness_by_the_view_alone_has_other_light() {
    let by_view = ApproximateBall {
        by_view: true,
        ..BALL
    };
    let total = by_view.false_total_reflection();
    let expected = by_view.integral(total, |slope, _| INTENSITY * solid_angle(slope));
    let found = floor_flux(&approximate(&[("thickness", "view")]));
    println!("{found} of {expected} W that land, from a slope of {total:.3} on none");
    // With Fresnel exact, as all else: its share is taken off in closed form.
    let taken = by_view.integral(total, |slope, ray| {
        let first = 1.0 - fresnel(ray.incidence.cos(), 1.5);
        INTENSITY * solid_angle(slope) * first * (1.0 - fresnel(ray.cos_exit, 1.0 / 1.5))
    });
    assert!(
        (found / taken - 1.0).abs() < FIVE_IN_A_THOUSAND,
        "{found} {taken}"
    );
}

#[test]
fn no_image_is_black_without_a_reason() {
    let dark = |scene: &Scene, pairs: &[(&str, &str)]| {
        let rendering = rendered(&caustic_map(pairs), scene);
        let values = &rendering.estimate.total.values;
        assert!(values.iter().all(|value| value.is_black()), "{pairs:?}");
        rendering.warnings
    };
    let said = |warnings: &[String], begin: &str, figure: &str| {
        let is_said = |text: &String| text.starts_with(begin) && text.contains(figure);
        assert!(warnings.iter().any(is_said), "{warnings:?}");
    };
    // Below the dish: nothing of the receiver's front is seen by the sun.
    let mirror = bundled("parabolic-mirror", 16);
    let warnings = dark(&mirror, &[]);
    said(
        &warnings,
        "the map's light is not seen by the sensor",
        "4,096 look-ups",
    );
    // A rectangle has no back side, if refraction by two interfaces is asked for.
    let pane = r#"<shape type="rectangle"><transform name="to_world"><translate z="1"/></transform>
        <bsdf type="thindielectric"/></shape>"#;
    let pane = scene_of(&over_floor(pane, 8));
    let two = [("mode", "refraction")];
    said(
        &dark(&pane, &two),
        "all ",
        "photons were dropped: no back face",
    );
    let exact = [("mode", "refraction"), ("refraction", "exact")];
    said(
        &dark(&pane, &exact),
        "all ",
        "photons were dropped: no second interface",
    );
    // A roof over the ball.
    let roof = r#"<shape type="rectangle"><transform name="to_world"><scale x="2" y="2"/><translate z="3.5"/></transform>
        <bsdf type="diffuse"/></shape>"#;
    let hidden = scene_of(&over_floor(&(ball(GLASS) + roof), 8));
    said(&dark(&hidden, &[]), "no photon meets a specular object", "");
    // A mirror that sends its light up.
    let mirror = r#"<shape type="rectangle"><transform name="to_world"><translate z="1"/></transform>
        <bsdf type="conductor"><string name="material" value="none"/></bsdf></shape>"#;
    let up = scene_of(&over_floor(mirror, 8));
    let none = [("hit", "exact")];
    said(
        &dark(&up, &none),
        "all ",
        "photons were dropped: meets no receiver",
    );
    let beams = [("hit", "exact"), ("splat", "exact"), ("lookup", "exact")];
    said(&dark(&up, &beams), "all ", "photons were dropped: ");
}

#[test]
fn shipped_scenes_have_light_or_say_why_not() {
    for name in [
        "water",
        "pool",
        "parabolic-mirror",
        "mirror-ring",
        "prism",
        "cube",
        "diamond",
        "lens",
        "glass-ball",
        "glass-ball-mesh",
        "glass-ball-behind-pane",
        "coffee-cup",
        "cornell-caustics",
        "turntable-ball",
        "turntable-cube",
        "turntable-prism",
        "turntable-ring",
        "turntable-bumpy",
        "turntable-terrain",
    ] {
        let scene = bundled(name, 8);
        let map = caustic_map(&[("photons", "64"), ("map", "64")]);
        let rendering = rendered(&map, &scene);
        let is_black = rendering
            .estimate
            .total
            .values
            .iter()
            .all(|it| it.is_black());
        assert_eq!(is_black, name == "parabolic-mirror", "{name}");
        assert_eq!(
            is_black,
            !rendering.warnings.is_empty(),
            "{name}: {:?}",
            rendering.warnings
        );
    }
}

#[test]
fn back_faces_move_with_the_photons_of_a_frame() {
    // The block's border is 16.73 pixels from the middle: the 17th is beside it, and on it where photons are
    // shifted inward by 0.27 pixels and more.
    let sun = r#"<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/><rgb name="irradiance" value="1"/></emitter>"#;
    let block = format!(
        r#"<shape type="cube"><transform name="to_world"><scale x="1" y="1" z="0.5"/><translate z="1"/></transform>{GLASS}</shape>"#
    );
    let scene = scene_of(&lit_by(sun, &block, 16));
    let map = caustic_map(&[
        ("photons", "67"),
        ("map", "64"),
        ("frames", "7"),
        ("no-back-face", "drop"),
    ]);
    let rendering = rendered(&map, &scene);
    // Light goes straight down through the block: every photon that meets its top has its bottom's back face.
    assert!(
        of(&rendering, "no back face").is_none(),
        "{:?}",
        rendering.flux
    );
    let found = floor_flux(&rendering);
    // The block's 4 m². Photons are 0.06 m apart; the places of evenly shifted rows count a length to a seventh
    // of that, twice over along each side.
    assert!(
        (found - 4.0).abs() < 2.0 * 2.0 * 2.0 * 0.06 / 7.0,
        "{found}"
    );
}
