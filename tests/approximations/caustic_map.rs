//! Caustic maps: what their stages must do whatever the scene, and what they refuse.

use glam::{DVec2, DVec3};
use nephroid::internals::approximation::LightView;
use nephroid::internals::approximation::Precision;
use nephroid::internals::approximation::caustic_map::hit::{fixed_point, marched};
use nephroid::internals::approximation::caustic_map::lens::Lens;
use nephroid::internals::approximation::caustic_map::refraction::Exit;
use nephroid::internals::approximation::caustic_map::variants::Splat;
use nephroid::internals::approximation::caustic_map::work::Work;
use nephroid::internals::approximation::{DepthMap, Extent, Receivers};
use nephroid::internals::geometry::{Bounds, Ray};
use nephroid::internals::method::Method;
use nephroid::internals::metric::Figure;
use nephroid::internals::optics::refract;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::{Budget, Context, LayerName, Light, Rendering};
use nephroid::internals::setting::Words;
use nephroid::internals::study::attribution::{Truth, attribute};
use nephroid::internals::transport::first_surface::Source;

use crate::support::approximation::{
    EXACT, GLASS, ball, bundled, caustic_map, error, exact_but, lit_by, over_floor, relative_rmse,
    rendered, scene_of, truth,
};
use crate::support::scenes::meter;

const SPLATS: &[(&str, Splat, &str)] = Splat::WORDS;

fn bits(rendering: &Rendering) -> Vec<u64> {
    let values = rendering.estimate.total.values.iter();
    values.flat_map(|value| value.0.map(f64::to_bits)).collect()
}

fn total(rendering: &Rendering) -> f64 {
    rendering
        .estimate
        .total
        .values
        .iter()
        .map(|value| value.mean())
        .sum()
}

fn with_threads<T: Send>(threads: usize, run: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(run)
}

#[test]
fn the_exact_pipeline_converges_to_beams() {
    let scene = bundled("glass-ball", 128);
    let truth = truth(&scene, "LTTD", 1e-3);
    let errors: Vec<f64> = ["128", "512", "2048"]
        .iter()
        .map(|n| error(&exact_but(&[("photons", n)]), &scene, &truth))
        .collect();
    println!("N = 128, 512, 2048: {errors:.5?}");
    // The fold's and the border's cells, of a share 1/N of the light, are off by their own size: first order
    // at least. Half an order is left for the texels that they happen to share.
    for pair in errors.windows(2) {
        assert!(pair[1] < pair[0] / 2.0, "{errors:?}");
    }
    // The issue's bar, and the truth's own error.
    assert!(errors[2] < 0.005 + 0.001, "{errors:?}");
}

#[test]
fn the_exact_pipeline_agrees_with_the_closed_form() {
    // No code in common with beams, nor with this technique.
    let scene = bundled("glass-ball", 128);
    let method = Method::new("closed-form", &[("max-depth".into(), "3".into())].into()).unwrap();
    let (budget, context) = (Budget::default(), Context::default());
    let formula = method
        .run(&scene, meter(&scene), &budget, &context)
        .unwrap();
    let through = LayerName::Path("LTTD".parse().unwrap());
    let mut layers = formula.estimate.layers.iter();
    let layer = layers.find(|layer| layer.name == through).unwrap();
    let truth = Truth {
        modelled: layer.values.clone(),
        not_modelled: f64::NAN,
        relative_error: None,
        is_resolved: true,
    };
    let found = error(&exact_but(&[("photons", "2048")]), &scene, &truth);
    let black = vec![Rgb::BLACK; truth.modelled.len()];
    let black = relative_rmse(&black, &truth.modelled).unwrap();
    println!("relative RMSE to the closed form: {found:.6}; of a black image {black:.3}");
    // From beams it is 2.7e-4, of which the beams' own error is a part.
    assert!(found < 2.7e-4, "{found}");
}

#[test]
fn a_mirrors_exact_pipeline_converges_to_beams_too() {
    let scene = bundled("parabolic-mirror", 64);
    let truth = truth(&scene, "LRD", 1e-2);
    let settings = |n| [("photons", n), ("mode", "reflection")];
    let coarse = error(&exact_but(&settings("128")), &scene, &truth);
    let fine = error(&exact_but(&settings("1024")), &scene, &truth);
    println!("N = 128, 1024: {coarse:.5}, {fine:.5}");
    // Eight times finer, of first order but for the truth's own error.
    assert!(fine < coarse / 4.0 + 0.01, "{coarse} {fine}");
}

#[test]
fn the_same_bits_come_from_any_number_of_threads() {
    let scene = scene_of(&over_floor(&ball(GLASS), 24));
    for (splat, ..) in SPLATS {
        for lookup in ["nearest", "bilinear", "exact"] {
            let settings = [
                ("photons", "96"),
                ("map", "80"),
                ("splat", splat),
                ("lookup", lookup),
            ];
            let map = caustic_map(&settings);
            let one = with_threads(1, || rendered(&map, &scene));
            let many = with_threads(5, || rendered(&map, &scene));
            assert_eq!(bits(&one), bits(&many), "{settings:?}");
            let work = |rendering: &Rendering| {
                let stages = rendering.stages.iter();
                stages
                    .map(|stage| (stage.name, stage.work.clone()))
                    .collect::<Vec<_>>()
            };
            assert_eq!(work(&one), work(&many), "{settings:?}");
        }
    }
}

#[test]
fn no_kernel_loses_flux() {
    let scene = scene_of(&over_floor(&ball(GLASS), 32));
    // All light of this path lands on the floor, well inside the map.
    let expected = total(&rendered(&exact_but(&[("photons", "512")]), &scene));
    for splat in ["fixed", "thin-lens", "thick-lens", "two-curvatures"] {
        let map = exact_but(&[("photons", "512"), ("map", "512"), ("splat", splat)]);
        let found = total(&rendered(&map, &scene));
        // Photons at pixel centres are the midpoint rule for what the beams' corners are the trapezoid of:
        // they differ at the border of the ball, of 2/512 of its area, where next to nothing is transmitted.
        assert!(
            (found / expected - 1.0).abs() < 4e-3,
            "{splat}: {found} {expected}"
        );
    }
}

#[test]
fn an_approximate_variant_of_each_stage_makes_an_error_where_nothing_else_errs() {
    let scene = scene_of(&over_floor(&ball(GLASS), 48));
    let truth = truth(&scene, "LTTD", 1e-2);
    let exact = error(&exact_but(&[("photons", "512")]), &scene, &truth);
    for (key, value) in [
        ("view", "f16"),
        ("refraction", "image-space"),
        ("flux", "uniform"),
        ("fresnel", "none"),
        ("fresnel", "schlick"),
        ("splat", "fixed"),
    ] {
        let with = error(
            &exact_but(&[("photons", "512"), (key, value)]),
            &scene,
            &truth,
        );
        println!("{key}={value}: {with:.4}, exact {exact:.4}");
        // An approximate variant that made no difference would be none.
        assert!(with > exact, "{key}={value}: {with} {exact}");
    }
}

#[test]
fn frames_shifted_by_parts_of_a_pixel_average_noise_away() {
    let scene = scene_of(&over_floor(&ball(GLASS), 48));
    let truth = truth(&scene, "LTTD", 1e-2);
    // One texel a photon: all that is wrong is noise, as far as the map's texels are fine enough.
    let noisy = |frames| {
        let settings = [
            ("photons", "96"),
            ("splat", "fixed"),
            ("splat-size", "1"),
            ("frames", frames),
        ];
        error(&exact_but(&settings), &scene, &truth)
    };
    let (one, sixteen) = (noisy("1"), noisy("16"));
    println!("1 frame: {one:.4}, 16 frames: {sixteen:.4}");
    // Independent frames would leave a quarter of the noise, on top of what the map's texels are coarse by;
    // half is clear of both.
    assert!(sixteen < 0.5 * one, "{one} {sixteen}");
}

#[test]
fn a_camera_sees_what_a_meter_measures() {
    // Straight down on the part of the floor that the meter measures.
    let camera = r#"<sensor type="orthographic">
        <transform name="to_world"><scale x="2" y="2"/><lookat origin="0, 0, 0.3" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/><rfilter type="box"/></film>
    </sensor>"#;
    let scene = scene_of(&over_floor(&(ball(GLASS) + camera), 32));
    let seen = scene
        .sensors()
        .iter()
        .find(|sensor| sensor.plugin() == "orthographic")
        .unwrap();
    for lookup in ["bilinear", "exact"] {
        let map = exact_but(&[("photons", "256"), ("splat", "fixed"), ("lookup", lookup)]);
        let (budget, context) = (Budget::default(), Context::default());
        let radiance: f64 = total(&map.run(&scene, seen, &budget, &context).unwrap());
        let irradiance = total(&rendered(&map, &scene));
        // The default albedo is 1/2; both grids average the same map over the same square.
        let expected = irradiance * 0.5 * std::f64::consts::FRAC_1_PI;
        assert!(
            (radiance / expected - 1.0).abs() < 1e-3,
            "{lookup}: {radiance} {expected}"
        );
    }
}

/// A meridional ray at `height` on a spherical lens of radii `front` and `back` (both convex) about the axis,
/// from a light `distance` before it; traced by Snell's law. Returns its height `background` behind the lens.
fn traced_height(
    [front, back]: [f64; 2],
    eta: f64,
    thickness: f64,
    distance: f64,
    background: f64,
    height: f64,
) -> f64 {
    // The axis is x, the front's vertex at 0.
    let front_center = DVec3::X * front;
    let entry = DVec3::new(
        front - (front * front - height * height).sqrt(),
        height,
        0.0,
    );
    let arriving = (entry + DVec3::X * distance).normalize();
    let inside = refract(arriving, (entry - front_center) / front, eta).unwrap();
    let back_center = DVec3::X * (thickness - back);
    let offset = entry - back_center;
    let b = offset.dot(inside);
    let reach = -b + (b * b - offset.length_squared() + back * back).sqrt();
    let exit = entry + inside * reach;
    let outside = refract(inside, -(exit - back_center) / back, 1.0 / eta).unwrap();
    (exit + outside * ((thickness + background - exit.x) / outside.x)).y
}

#[test]
fn equation_seven_is_paraxially_that_of_traced_rays() {
    let (radii, eta) = ([2.0, 3.0], 1.5);
    for (distance, background) in [(4.0, 1.0), (4.0, 6.0), (1.5, 2.0), (20.0, 3.0)] {
        for thickness in [1e-4, 0.3, 1.5] {
            let lens = Lens {
                vergence: 1.0 / distance,
                front: 1.0 / radii[0],
                back: 1.0 / radii[1],
                eta,
                thickness,
            };
            // Beside the axis the traced ray departs by the square of its height over the radii: 1e-8.
            let height = 1e-4;
            let traced = traced_height(radii, eta, thickness, distance, background, height).abs();
            let unbent = height * (distance + thickness + background) / distance;
            let (thick, expected) = (lens.thick(background), traced / unbent);
            assert!((thick - expected).abs() < 1e-6, "{thick} {expected}");
            if thickness < 1e-3 {
                // What the thickness is to the shortest distance, and 10 for the curvatures.
                let thin = lens.thin(background);
                assert!((thin - expected).abs() < 1e-3, "{thin} {expected}");
            }
        }
    }
}

#[test]
fn equation_seven_departs_from_traced_rays_away_from_the_axis() {
    let (radii, eta, distance, background) = ([2.0, 2.0], 1.5, 6.0, 1.0);
    let lens = |thickness| Lens {
        vergence: 1.0 / distance,
        front: 0.5,
        back: 0.5,
        eta,
        thickness,
    };
    println!("| height / R | thin lens, D/D0 | traced | thick lens (t = 0.5) | traced |");
    let mut last = 0.0;
    for step in 1..=8 {
        let height = 0.1 * f64::from(step);
        // The beam about a ray at this height: a difference of two, in the meridional plane.
        let width = |thickness| {
            let at = |h| traced_height(radii, eta, thickness, distance, background, h);
            let along = distance / (distance + thickness + background);
            ((at(height + 1e-6) - at(height - 1e-6)) / 2e-6 * along).abs()
        };
        let (thin, thick) = (lens(0.0).thin(background), lens(0.5).thick(background));
        // A sharp-edged lens thinner than its own sag does not exist: the traced one is as thick as it must
        // be.
        let sag = 2.0 * (2.0 - (4.0_f64 - 0.8 * 0.8).sqrt());
        println!(
            "| {:.2} | {thin:.4} | {:.4} | {thick:.4} | {:.4} |",
            height / radii[0],
            width(sag),
            width(0.5)
        );
        let departure = (thick - width(0.5)).abs();
        // Spherical aberration grows with the height.
        assert!(departure > last, "{departure} {last}");
        last = departure;
    }
    assert!(last > 0.05, "{last}");
}

#[test]
fn sizes_of_zero_are_refused_and_of_one_are_well_defined() {
    assert!(caustic_map(&[]).with("photons", "0").is_err());
    let scene = scene_of(&over_floor(&ball(GLASS), 4));
    for (splat, ..) in SPLATS {
        for lookup in ["nearest", "bilinear", "exact"] {
            let map = caustic_map(&[
                ("photons", "1"),
                ("map", "1"),
                ("splat", splat),
                ("lookup", lookup),
            ]);
            let rendering = rendered(&map, &scene);
            let is_sound = |value: &Rgb| value.is_finite() && value.min_channel() >= 0.0;
            assert!(
                rendering.estimate.total.values.iter().all(is_sound),
                "{splat:?} {lookup}"
            );
        }
    }
}

#[test]
fn scenes_without_a_refractor_or_a_lamp_are_refused_by_name() {
    let refusal = |xml: &str, settings: &[(&str, &str)]| {
        let scene = scene_of(xml);
        let map = caustic_map(settings);
        let (budget, context) = (Budget::default(), Context::default());
        let error = map.run(&scene, meter(&scene), &budget, &context);
        error.unwrap_err().to_string()
    };
    let matt = ball(r#"<bsdf type="diffuse"/>"#);
    let none = refusal(&over_floor(&matt, 4), &[]);
    assert!(none.contains("no shape mirrors"), "{none}");
    let none = refusal(&over_floor(&matt, 4), &[("mode", "refraction")]);
    assert!(none.contains("no shape refracts"), "{none}");
    let dark = refusal(&lit_by("", &ball(GLASS), 4), &[]);
    assert!(dark.contains("no emitter shines"), "{dark}");
    let area = r#"<shape type="sphere"><point name="center" x="0" y="0" z="4"/><float name="radius" value="0.1"/>
        <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>"#;
    let area = refusal(&lit_by(area, &ball(GLASS), 4), &[]);
    assert!(
        area.contains("area") && area.contains("point, spot"),
        "{area}"
    );
    let within =
        r#"<emitter type="point"><point name="position" x="0.2" y="0" z="1.5"/></emitter>"#;
    let within = refusal(&lit_by(within, &ball(GLASS), 4), &[]);
    assert!(within.contains("is inside shape"), "{within}");
}

#[test]
fn a_lamp_amid_its_receivers_has_a_cube_of_views() {
    // Between the ball and the floor, the lamp's light leaves the ball upward: none lands, but none fails.
    let lamp = r#"<emitter type="point"><point name="position" x="0" y="0" z="0.2"/><rgb name="intensity" value="1"/></emitter>"#;
    let scene = scene_of(&lit_by(lamp, &ball(GLASS), 16));
    for lookup in ["bilinear", "exact"] {
        let map = exact_but(&[("photons", "64"), ("map", "64"), ("lookup", lookup)]);
        assert_eq!(total(&rendered(&map, &scene)), 0.0);
    }
    // From beside the ball, some lands.
    let lamp = r#"<emitter type="point"><point name="position" x="-1.5" y="0.1" z="1.9"/><rgb name="intensity" value="100"/></emitter>"#;
    let scene = scene_of(&lit_by(lamp, &ball(GLASS), 32));
    let direct = total(&rendered(&exact_but(&[("photons", "512")]), &scene));
    // Without the shadow test: the floor is seen at grazing angles, where a depth map shadows itself.
    let lost = |texels| {
        let map = exact_but(&[
            ("photons", "512"),
            ("map", texels),
            ("lookup", "bilinear"),
            ("samples", "16"),
            ("bias", "1"),
        ]);
        (total(&rendered(&map, &scene)) / direct - 1.0).abs()
    };
    let (coarse, fine) = (lost("256"), lost("1024"));
    println!("of the light, amiss at M = 256: {coarse:.4}, 1024: {fine:.4}");
    // Texels that reach over the floor's border are read as if they were all on it: of first order in a
    // texel's size, four times less; half is clear of how the border happens to lie.
    assert!(direct > 0.0 && fine < 0.5 * coarse, "{coarse} {fine}");
}

#[test]
fn a_march_goes_on_from_one_face_of_a_cube_to_the_next() {
    // The lamp sees the floor by faces of a cube. The ray starts in the one to the left and lands in the one
    // below.
    let lamp = r#"<emitter type="point"><point name="position" x="0" y="0" z="1"/><rgb name="intensity" value="1"/></emitter>"#;
    let scene = scene_of(&lit_by(lamp, "", 4));
    let source = &Source::all(&scene)[0];
    let floor = Bounds::from_points([DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 0.0)]);
    let receivers = Receivers::new(&scene);
    let depths: Vec<DepthMap> = LightView::around(source, &[Extent::Box(floor)], 64)
        .into_iter()
        .map(|view| DepthMap::new(&receivers, view, Precision::Exact).0)
        .collect();
    let (start, target) = (DVec3::new(-1.5, 0.2, 0.9), DVec3::new(0.3, -0.4, 0.0));
    let exit = exit(start, target, false);
    let mut work = Work::default();
    let found = marched(&exit, &depths, [256, 20], &mut work).unwrap();
    let off = found.position.distance(target);
    // The floor is parallel to the face below: its depth is exact there, and the march to half of a 2^20th of
    // a 256th of at most 3 (the way to the floor's corners).
    assert!(off < 3.0 / 256.0 / 2_f64.powi(20), "{off}");
    // One picture alone loses it.
    for one in depths.chunks(1) {
        assert!(marched(&exit, one, [256, 20], &mut work).is_err());
    }
}

/// Light that left the last interface at one point towards another.
fn exit(start: DVec3, towards: DVec3, may_be_inside: bool) -> Exit {
    Exit {
        ray: Ray::new(start, (towards - start).normalize()),
        throughput: Rgb::WHITE,
        by_fresnel: Rgb::WHITE,
        lens: Lens {
            vergence: 1.0,
            front: 0.0,
            back: 0.0,
            eta: 1.0,
            thickness: 0.0,
        },
        derivatives: Default::default(),
        may_be_inside,
        topology: 0,
    }
}

#[test]
fn the_march_of_2008_lands_where_the_ray_meets_a_floor_across_the_axis() {
    let lamp = r#"<emitter type="point"><point name="position" x="0" y="0" z="4"/><rgb name="intensity" value="1"/></emitter>"#;
    let scene = scene_of(&lit_by(lamp, "", 4));
    let source = &Source::all(&scene)[0];
    let floor = Bounds::from_points([DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 0.0)]);
    let view = LightView::around(source, &[Extent::Box(floor)], 64)[0];
    let (depths, _) = DepthMap::new(&Receivers::new(&scene), view, Precision::Exact);
    let (start, target) = (DVec3::new(-0.5, 0.2, 1.3), DVec3::new(0.9, -0.4, 0.0));
    let exit = |towards: DVec3| exit(start, towards, true);
    let mut work = Work::default();
    let found = fixed_point(&exit(target), std::slice::from_ref(&depths), &mut work).unwrap();
    // All of the floor is at the depth of 4: the first step is at the place.
    let off = found.position.distance(target);
    assert!(off < 1e-12, "{off}");
    // Two guesses and ten steps.
    assert_eq!((work.steps, work.fetches), (12, 12));
    // Neither beside the floor nor upward is there a place.
    let beside = exit(DVec3::new(2.5, 0.0, 0.0));
    assert!(fixed_point(&beside, std::slice::from_ref(&depths), &mut work).is_err());
    let upward = exit(DVec3::new(0.0, 0.0, 3.0));
    assert!(fixed_point(&upward, std::slice::from_ref(&depths), &mut work).is_err());
}

#[test]
fn splats_of_unbent_light_are_as_wide_as_their_pixels_on_the_map() {
    // Sunlight through a block: no lens at all, D = D0, of 4 pixels. An interval of 4 texels holds 4 centres.
    let sun = r#"<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/><rgb name="irradiance" value="1"/></emitter>"#;
    let block = format!(
        r#"<shape type="cube"><transform name="to_world"><scale x="1" y="1" z="0.5"/><translate z="1"/></transform>{GLASS}</shape>"#
    );
    let scene = scene_of(&lit_by(sun, &block, 8));
    for splat in ["thin-lens", "thick-lens"] {
        for (map, texels) in [("65", 4), ("130", 8), ("195", 12)] {
            let pairs = [
                ("photons", "65"),
                ("map", map),
                ("base-size", "4"),
                ("splat", splat),
            ];
            let rendering = rendered(&exact_but(&pairs), &scene);
            let stage = rendering.stages.iter().find(|stage| stage.name == "splat");
            let work = &stage.unwrap().work;
            let (splats, fragments) = (work.get("splats"), work.get("fragments"));
            assert!(splats > 900, "{splats}");
            // Where centres lie on both ends of the interval, there is one more each way.
            let (least, most) = (texels * texels, (texels + 1) * (texels + 1));
            assert!(fragments >= splats * least, "{fragments} {splats}");
            assert!(fragments <= splats * most, "{fragments} {splats}");
        }
    }
}

#[test]
fn one_photon_through_the_middle_of_a_ball_is_as_wide_as_the_lens_equations_say() {
    // One pixel, one photon on the axis. D0 is an eighth of a pixel, 64 texels of 512. The lamp is 1.6 before the
    // ball of power 1 and thickness 2, the floor 0.4 behind it.
    let scene = scene_of(&over_floor(&ball(GLASS), 8));
    let image = 1.0 / (1.0 - 1.0 / 1.6);
    let thin: f64 = 1.6 / 2.0 * (0.4 - image) / image;
    // A paraxial ray at height 1, its slope 1/1.6: refracted by half a power each at the front and 2 further.
    let inside = (1.0 / 1.6 - 0.5) / 1.5;
    let height = 1.0 + 2.0 * inside;
    let outside = 1.5 * inside - 0.5 * height;
    let thick: f64 = (height + 0.4 * outside) / (1.0 + 2.4 / 1.6);
    for (splat, factor) in [("thin-lens", thin.abs()), ("thick-lens", thick.abs())] {
        let pairs = [
            ("photons", "1"),
            ("map", "512"),
            ("base-size", "0.125"),
            ("largest-splat", "512"),
            ("splat", splat),
        ];
        let rendering = rendered(&exact_but(&pairs), &scene);
        let stage = rendering.stages.iter().find(|stage| stage.name == "splat");
        let fragments = stage.unwrap().work.get("fragments");
        // The middle is a corner of texels: so many of their centres are within half a diameter on either side.
        let across = 2 * (32.0 * factor + 0.5).floor() as u64;
        println!("{splat}: D/D0 = {factor:.4}, {across} texels");
        assert_eq!(fragments, across * across, "{splat}");
    }
}

#[test]
fn attribution_adds_up_and_tells_what_is_not_modelled() {
    let scene = bundled("glass-ball", 32);
    let map = caustic_map(&[("photons", "128"), ("map", "128")]);
    let exact = truth(&scene, "LTTD", 1e-2);
    let mut heard = Vec::new();
    let mut listen = |done: usize, all: usize| heard.push((done, all));
    let context = Context::default();
    let found = attribute(
        &map,
        &scene,
        meter(&scene),
        &context,
        &mut listen,
        |light| {
            assert_eq!(light, Light::Path("LTTD".parse().unwrap()));
            Ok(Truth {
                not_modelled: 0.25,
                ..exact.clone()
            })
        },
    );
    let found = found.unwrap().unwrap();
    assert_eq!(found.not_modelled, 0.25);
    // All subsets of the stages that are not exact as they are set.
    let stages = map.stages();
    let inexact = stages.iter().filter(|stage| !stage.is_exact()).count();
    assert_eq!(found.runs, 1 << inexact);
    assert_eq!(heard.last(), Some(&(found.runs, found.runs)));
    let names: Vec<&str> = found
        .stages
        .iter()
        .map(|stage| stage.name.as_str())
        .collect();
    assert_eq!(names, EXACT.map(|(name, _)| name));
    for shares in &found.figures {
        let added: f64 = shares.stages.iter().map(|stage| stage.share.value).sum();
        // Sums of 128 products of numbers below 10.
        assert!(
            (shares.residual + added - shares.whole).abs() < 1e-12,
            "{shares:?}"
        );
    }
    let shares = found.of(Figure::L1).unwrap();
    assert!(shares.residual < 0.1 * shares.whole, "{found:?}");
    // The figures of single runs by their formula: films are f32.
    let l1 = |map: &Method| {
        let values = rendered(map, &scene).estimate.total.values;
        let pairs = values.iter().zip(&exact.modelled);
        let (apart, sum) = pairs.fold((0.0, 0.0), |(apart, sum), (a, t)| {
            let parts = a.0.iter().zip(t.0);
            let d: f64 = parts.map(|(a, t)| (a - t).abs()).sum();
            (apart + d, sum + t.0.iter().sum::<f64>())
        });
        apart / sum
    };
    let is = |found: f64, map: &Method| (found / l1(map) - 1.0).abs() < 1e-5;
    assert!(is(shares.whole, &map));
    for (i, stage) in stages.iter().enumerate() {
        let fixed = map.with_exact(stage.name).unwrap();
        assert!(is(shares.stages[i].fixed, &fixed), "{}", stage.name);
        let set = [(stage.name, stage.variant.as_str())];
        let size = [("photons", "128"), ("map", "128")];
        let spoiled = exact_but(&[&size[..], &set].concat());
        assert!(is(shares.stages[i].spoiled, &spoiled), "{}", stage.name);
    }
}

#[test]
fn attribution_to_a_truth_that_is_unknown_or_unresolved_says_so() {
    let scene = scene_of(&over_floor(&ball(GLASS), 4));
    let map = caustic_map(&[("photons", "16"), ("map", "16")]);
    let with = |value: f64| {
        let truth = Truth {
            modelled: vec![Rgb::grey(value); 16],
            not_modelled: 0.0,
            relative_error: None,
            is_resolved: false,
        };
        let context = Context::default();
        attribute(
            &map,
            &scene,
            meter(&scene),
            &context,
            &mut |_, _| (),
            |_| Ok(truth),
        )
    };
    let unknown = with(f64::NAN).unwrap_err().to_string();
    assert!(
        unknown.contains("stopped before its first pass"),
        "{unknown}"
    );
    let dark = with(0.0).unwrap_err().to_string();
    assert!(dark.contains("no light of path LTTD"), "{dark}");
    assert!(!with(1.0).unwrap().unwrap().is_resolved);
}

#[test]
fn an_unknown_stage_or_setting_is_told_with_what_there_is() {
    let map = caustic_map(&[]);
    let error = map.with_exact("splatt").unwrap_err().to_string();
    assert!(error.contains("did you mean \"splat\"?"), "{error}");
    let error = map.with("photon", "8").unwrap_err().to_string();
    assert!(error.contains("did you mean \"photons\"?"), "{error}");
}

#[test]
fn the_look_ups_area_is_that_of_the_traced_texel() {
    let scene = bundled("glass-ball", 4);
    let source = Source::all(&scene)[0];
    let floor = Bounds::from_points([DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 0.0)]);
    let view = LightView::around(&source, &[Extent::Box(floor)], 512)[0];
    let at = DVec2::new(100.5, 300.5);
    let on_floor = |at| {
        let ray = view.ray(at);
        ray.at(-ray.origin.z / ray.direction.z)
    };
    let (a, b) = (on_floor(at - 0.5), on_floor(at + 0.5));
    let traced = ((b - a).x * (b - a).y).abs();
    let area = view.seen_area(on_floor(at), DVec3::Z);
    // Squares of a plane that is parallel to the image are exact, to rounding of differences of 1e-2.
    assert!((area / traced - 1.0).abs() < 1e-11, "{area} {traced}");
    let measure = view.measure_of(at - 0.5, at + 0.5);
    let middle = on_floor(at);
    let distance = middle.distance(view.ray(at).origin);
    let cos = view.direction_to(middle).z.abs();
    // The solid angle of a pixel of 1/512 varies by (1/512)² over it.
    assert!((measure * distance * distance / cos / area - 1.0).abs() < 1e-5);
}
