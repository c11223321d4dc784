//! Emitters as a point sees them: sampled directions, their density, and closed forms of irradiance.
//!
//! Three independent ways to the same irradiance E = ∫ L cos θ dω: directions that
//! [`Lights::sample`] chooses, directions chosen evenly and met by [`Lights::emitted`], closed forms.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Ray, SurfacePoint};
use nephroid::internals::numeric::{SampleMoments, Stream, StreamKind};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::closed_form::lambert_irradiance;
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::lights::{LightSample, Lights};
use nephroid::internals::transport::visibility::transmittance;

use crate::support::bsdf::scene;

/// Standard errors that an estimate may be off: 6 fail a right program once in 5·10⁸ comparisons; this file
/// makes some hundred.
const SIGMAS: f64 = 6.0;

const RADIANCE: &str =
    "<emitter type=\"area\"><rgb name=\"radiance\" value=\"2, 3, 5\"/></emitter>";

/// A point of a matt surface.
fn surface(position: DVec3, normal: DVec3) -> SurfacePoint {
    SurfacePoint {
        position,
        position_error: position.abs() * f64::EPSILON,
        geometric_normal: normal,
        shading_normal: normal,
        uv: DVec2::ZERO,
    }
}

fn shape(plugin: &str, parameters: &str) -> Scene {
    scene(&format!(
        "<shape type=\"{plugin}\">{parameters}{RADIANCE}</shape>"
    ))
}

fn textured(plugin: &str, parameters: &str) -> Scene {
    scene(&format!(
        "<shape type=\"{plugin}\">{parameters}<emitter type=\"area\"><texture name=\"radiance\" type=\"bitmap\">
         <string name=\"filename\" value=\"color.png\"/></texture></emitter></shape>"
    ))
}

/// Every form of area light, of a size about 1, about the origin.
fn area_lights() -> Vec<(&'static str, Scene)> {
    let turned = "<transform name=\"to_world\"><scale x=\"0.5\" y=\"0.8\"/><rotate x=\"1\" y=\"2\" angle=\"40\"/></transform>";
    vec![
        ("rectangle", shape("rectangle", turned)),
        ("disk", shape("disk", turned)),
        (
            "sphere",
            shape("sphere", "<float name=\"radius\" value=\"0.8\"/>"),
        ),
        (
            "inward sphere",
            shape(
                "sphere",
                "<float name=\"radius\" value=\"0.8\"/><boolean name=\"flip_normals\" value=\"true\"/><bsdf type=\"null\"/>",
            ),
        ),
        (
            "cylinder",
            shape("cylinder", "<float name=\"radius\" value=\"0.4\"/>"),
        ),
        ("cube", shape("cube", turned)),
        ("textured rectangle", textured("rectangle", turned)),
        ("textured sphere", textured("sphere", "")),
        ("textured cube", textured("cube", turned)),
    ]
}

/// Places outside, near and far, and one inside of what has an inside.
const PLACES: [DVec3; 4] = [
    DVec3::new(0.1, 1.2, -1.1),
    DVec3::new(-30.0, 20.0, 10.0),
    DVec3::new(0.2, -0.1, 0.15),
    DVec3::new(0.0, -1.0, 1.3),
];

fn samples<'a>(
    lights: &'a Lights,
    from: &'a SurfacePoint,
    count: u64,
) -> impl Iterator<Item = Option<LightSample>> + 'a {
    let stream = Stream::new(StreamKind::Random, 11);
    (0..count).map(move |index| {
        let [a, b, c, _] = stream.point4(index);
        lights.sample(from, [a, b, c])
    })
}

/// What a ray from a point meets of a scene of one light, walls that do not shine this way being passed: the
/// radiance and density there, the distance, and the cosine at the light.
fn emitted_along(
    scene: &Scene,
    lights: &Lights,
    from: &SurfacePoint,
    direction: DVec3,
) -> (Rgb, f64, f64, f64) {
    let mut ray = Ray::new(from.position, direction);
    let mut found = (Rgb::BLACK, 0.0, 0.0, 1.0);
    while let Some(hit) = scene
        .world()
        .closest_hit(&ray, f64::INFINITY, &mut Default::default())
    {
        let point = scene.world().surface_point(&ray, &hit);
        let (emitted, pdf) = lights.emitted_and_pdf(from.position, &ray, Some(&hit));
        assert_eq!(emitted, lights.emitted(&ray, Some(&hit)));
        if pdf > 0.0 {
            let distance = point.position.distance(from.position);
            let cos = point.geometric_normal.dot(direction).abs();
            found = (lights.emitted(&ray, Some(&hit)), pdf, distance, cos);
            break;
        }
        ray = point.spawn(direction);
    }
    found
}

#[test]
fn a_ray_along_a_sampled_direction_meets_the_light_with_the_sampled_density() {
    for (name, scene) in area_lights() {
        let lights = Lights::new(&scene);
        for place in PLACES {
            let from = surface(place, DVec3::Z);
            let (mut met, mut chosen) = (0, 0);
            for sample in samples(&lights, &from, 4000).flatten() {
                let (emitted, pdf, distance, cos) =
                    emitted_along(&scene, &lights, &from, sample.direction);
                chosen += 1;
                // A convex light hides no front of its own; at its rim rounding may decide.
                if emitted.is_black() || (distance / sample.distance - 1.0).abs() > 1e-6 {
                    continue;
                }
                met += 1;
                // Where a ray touches a round wall at a slant, places ε apart across it are ε / cos apart
                // along it, and their cosines as much: relative to the cosine, ε / cos².
                let tolerance = 1e3 * f64::EPSILON * (cos.powi(-2)).max(place.length_squared());
                let error = (pdf / sample.pdf_solid_angle - 1.0).abs();
                assert!(
                    error < tolerance,
                    "{name} {place}: {error:e} > {tolerance:e}"
                );
                // Even light to rounding; a texture changes by its whole range over a texel, and the two
                // places are as far apart as their densities tell.
                let product = sample.radiance_over_pdf * sample.pdf_solid_angle;
                let change = if name.starts_with("textured") {
                    100.0 * tolerance
                } else {
                    0.0
                };
                let error = (product.0[1] / emitted.0[1] - 1.0).abs();
                assert!(
                    error < 4.0 * f64::EPSILON + change,
                    "{name} {place}: {error:e}"
                );
            }
            let missed = chosen - met;
            assert!(
                missed * 1000 <= chosen,
                "{name} {place}: {missed} of {chosen}"
            );
        }
    }
}

#[test]
fn irradiance_by_light_sampling_is_that_by_even_directions() {
    for (name, scene) in area_lights() {
        let lights = Lights::new(&scene);
        for place in PLACES {
            // Facing the origin, about which the lights stand, at a slant.
            let normal = (DVec3::new(0.2, 0.1, -0.2) - place).normalize();
            let from = surface(place, normal);
            let (mut by_light, mut by_direction, mut total) = (
                SampleMoments::default(),
                SampleMoments::default(),
                SampleMoments::default(),
            );
            for sample in samples(&lights, &from, 40_000) {
                by_light.add(sample.map_or(0.0, |sample| {
                    sample.radiance_over_pdf.0[0] * sample.direction.dot(normal).max(0.0)
                }));
                total.add(f64::from(u8::from(sample.is_some())));
            }
            let stream = Stream::new(StreamKind::Random, 12);
            let mut density = SampleMoments::default();
            for index in 0..200_000 {
                let [a, b] = stream.point2(index);
                let (sin, cos) = (TAU * b).sin_cos();
                let height = 1.0 - 2.0 * a;
                let radius = (1.0 - height * height).sqrt();
                let direction = DVec3::new(radius * cos, radius * sin, height).normalize();
                let (emitted, pdf, ..) = emitted_along(&scene, &lights, &from, direction);
                by_direction.add(emitted.0[0] * direction.dot(normal).max(0.0) * 4.0 * PI);
                density.add(pdf * 4.0 * PI);
            }
            agree(name, place, &by_light, &by_direction);
            // ∫ pdf dω is the probability that a direction is chosen at all.
            agree(name, place, &total, &density);
        }
    }
}

fn agree(name: &str, place: DVec3, a: &SampleMoments, b: &SampleMoments) {
    let (mean_a, mean_b) = (a.mean().unwrap(), b.mean().unwrap());
    let joint = a
        .standard_error()
        .unwrap()
        .hypot(b.standard_error().unwrap());
    assert!(
        (mean_a - mean_b).abs() <= SIGMAS * joint + 1e-12 * mean_a.abs(),
        "{name} at {place}: {mean_a} and {mean_b}, joint error {joint}"
    );
}

/// Mean of E over samples, first channel, and its standard error.
fn irradiance(scene: &Scene, from: &SurfacePoint) -> SampleMoments {
    let lights = Lights::new(scene);
    let mut moments = SampleMoments::default();
    for sample in samples(&lights, from, 40_000) {
        moments.add(sample.map_or(0.0, |sample| {
            sample.radiance_over_pdf.0[0] * sample.direction.dot(from.geometric_normal).max(0.0)
        }));
    }
    moments
}

fn assert_irradiance(scene: &Scene, from: &SurfacePoint, expected: f64) {
    let moments = irradiance(scene, from);
    let (mean, error) = (moments.mean().unwrap(), moments.standard_error().unwrap());
    assert!(
        (mean - expected).abs() <= SIGMAS * error + 1e-12 * expected,
        "{mean} ± {error} instead of {expected}"
    );
}

#[test]
fn irradiance_of_a_disk_on_its_axis_is_that_of_its_cone() {
    // π L sin²: the disk of radius 1 seen from a height of 2.
    let disk = shape("disk", "");
    let from = surface(DVec3::new(0.0, 0.0, 2.0), -DVec3::Z);
    assert_irradiance(&disk, &from, 2.0 * PI / 5.0);
}

#[test]
fn irradiance_of_a_rectangle_is_lamberts() {
    let rectangle = shape("rectangle", "");
    let (x, y) = (DVec3::X, DVec3::Y);
    let position = DVec3::new(0.4, 0.7, 1.5);
    let normal = DVec3::new(0.5, 0.2, -0.6).normalize();
    // Counter-clockwise as seen from above, the side that shines.
    let corners = [-x - y, x - y, x + y, y - x];
    let expected = lambert_irradiance(position, normal, &corners, 2.0);
    assert!(expected > 0.1);
    assert_irradiance(&rectangle, &surface(position, normal), expected);
}

#[test]
fn irradiance_of_a_ball_is_that_of_its_solid_angle_projected() {
    let ball = shape("sphere", "");
    // π L (r/d)² cos θ while none of it is below the horizon.
    for (distance, tilt) in [(1.01f64, 0.0f64), (2.0, 0.5), (1e6, 1.0)] {
        let normal = DVec3::new(tilt.sin(), 0.0, -tilt.cos());
        let from = surface(DVec3::Z * distance, normal);
        let expected = 2.0 * PI / (distance * distance) * tilt.cos();
        assert_irradiance(&ball, &from, expected);
    }
}

#[test]
fn every_sample_of_a_ball_carries_the_same_light() {
    // L Ω, Ω = 2π (1 − cos) of the cone: nothing is left to vary.
    let ball = shape("sphere", "");
    let lights = Lights::new(&ball);
    for distance in [1.001f64, 3.0, 1e8] {
        let from = surface(DVec3::X * distance, -DVec3::X);
        let sin = 1.0 / distance;
        let solid_angle = TAU * sin * sin / (1.0 + ((1.0 - sin) * (1.0 + sin)).sqrt());
        for sample in samples(&lights, &from, 100) {
            let sample = sample.unwrap();
            // `1 − sin` cancels as the distance to the ball does: ε over it.
            let tolerance = 8.0 * f64::EPSILON / (1.0 - sin);
            let ratio = sample.radiance_over_pdf.0[0] / (2.0 * solid_angle);
            assert!((ratio - 1.0).abs() < tolerance, "{ratio}");
        }
    }
}

#[test]
fn inside_a_ball_that_shines_inward_irradiance_is_pi_l_everywhere() {
    let ball = shape("sphere", "<boolean name=\"flip_normals\" value=\"true\"/>");
    for place in [DVec3::ZERO, DVec3::new(0.3, 0.8, -0.4), DVec3::Z * 0.999] {
        for normal in [DVec3::X, -DVec3::Z] {
            assert_irradiance(&ball, &surface(place, normal), 2.0 * PI);
        }
    }
}

#[test]
fn on_its_own_wall_an_inward_ball_is_lit_from_the_inside_only() {
    let ball = shape("sphere", "<boolean name=\"flip_normals\" value=\"true\"/>");
    let ray = Ray::new(DVec3::ZERO, DVec3::new(2.0, 1.0, -2.0) / 3.0);
    let hit = ball
        .world()
        .closest_hit(&ray, f64::INFINITY, &mut Default::default())
        .unwrap();
    let point = ball.world().surface_point(&ray, &hit);
    assert_irradiance(&ball, &point, 2.0 * PI);
    let lights = Lights::new(&ball);
    for sample in samples(&lights, &point, 1000).flatten() {
        assert!(sample.direction.dot(point.geometric_normal) > 0.0);
    }
    // And a ball that shines outward does not light itself.
    let ball = shape("sphere", "");
    let mut outward = point;
    outward.geometric_normal = -point.geometric_normal;
    let lights = Lights::new(&ball);
    assert!(samples(&lights, &outward, 1000).flatten().next().is_none());
}

#[test]
fn the_back_of_a_light_is_dark() {
    for plugin in ["rectangle", "disk"] {
        let scene = shape(plugin, "");
        let lights = Lights::new(&scene);
        for (height, shines) in [(1.0, true), (-1.0, false)] {
            let from = surface(DVec3::new(0.1, 0.2, height), DVec3::Z);
            let ray = Ray::new(from.position, DVec3::Z * -height);
            let hit = scene
                .world()
                .closest_hit(&ray, f64::INFINITY, &mut Default::default());
            assert!(hit.is_some());
            assert_eq!(!lights.emitted(&ray, hit.as_ref()).is_black(), shines);
            let pdf = lights.emitted_and_pdf(from.position, &ray, hit.as_ref()).1;
            assert_eq!(pdf > 0.0, shines);
            assert_eq!(lights.sample(&from, [0.5; 3]).is_some(), shines);
        }
    }
}

#[test]
fn flipped_normals_turn_the_front_round() {
    let scene = shape(
        "rectangle",
        "<boolean name=\"flip_normals\" value=\"true\"/>",
    );
    let lights = Lights::new(&scene);
    let above = surface(DVec3::Z, -DVec3::Z);
    let below = surface(-DVec3::Z, DVec3::Z);
    assert!(lights.sample(&above, [0.5; 3]).is_none());
    assert!(lights.sample(&below, [0.5; 3]).is_some());
}

#[test]
fn delta_lights_bring_their_irradiance_from_their_one_direction() {
    let scene = scene(
        "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"2\"/><rgb name=\"intensity\" value=\"8, 4, 2\"/></emitter>
         <emitter type=\"directional\"><vector name=\"direction\" x=\"0\" y=\"3\" z=\"-4\"/><rgb name=\"irradiance\" value=\"7, 1, 1\"/></emitter>
         <emitter type=\"spot\"><transform name=\"to_world\"><lookat origin=\"2,0,0\" target=\"0,0,0\" up=\"0,0,1\"/></transform>
            <rgb name=\"intensity\" value=\"1, 2, 3\"/><float name=\"cutoff_angle\" value=\"30\"/><float name=\"beam_width\" value=\"10\"/></emitter>",
    );
    let lights = Lights::new(&scene);
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 16.0 * f64::EPSILON;
    let origin = surface(DVec3::ZERO, DVec3::Z);
    // Each emitter is one third of the choices: the samples are three times the light.
    let point = lights.sample(&origin, [0.1, 0.5, 0.5]).unwrap();
    assert!(point.is_delta && point.emitter == 0);
    assert_eq!((point.direction, point.distance), (DVec3::Z, 2.0));
    assert!(close(point.radiance_over_pdf.0[0], 3.0 * 8.0 / 4.0));
    assert!(close(point.pdf_solid_angle, 1.0 / 3.0));
    let parallel = lights.sample(&origin, [0.5, 0.5, 0.5]).unwrap();
    assert_eq!(parallel.emitter, 1);
    assert!(parallel.distance.is_infinite() && parallel.reach.is_infinite());
    assert!(
        parallel
            .direction
            .abs_diff_eq(DVec3::new(0.0, -0.6, 0.8), 1e-15)
    );
    assert!(close(parallel.radiance_over_pdf.0[0], 3.0 * 7.0));
    let axis = lights.sample(&origin, [0.9, 0.5, 0.5]).unwrap();
    assert!(close(axis.radiance_over_pdf.0[2], 3.0 * 3.0 / 4.0));
    // At 20 degrees, half way down from 10 to 30; beyond 30 nothing.
    let off_axis = surface(
        DVec3::new(0.0, 2.0 * 20f64.to_radians().tan(), 0.0),
        DVec3::Z,
    );
    let half = lights.sample(&off_axis, [0.9, 0.5, 0.5]).unwrap();
    let squared = 4.0 / (20f64.to_radians().cos().powi(2));
    assert!((half.radiance_over_pdf.0[2] / (3.0 * 0.5 * 3.0 / squared) - 1.0).abs() < 1e-13);
    let outside = surface(DVec3::new(0.0, 2.0, 0.0), DVec3::Z);
    assert!(lights.sample(&outside, [0.9, 0.5, 0.5]).is_none());
    // At the light itself there is no direction.
    let inside = surface(DVec3::Z * 2.0, DVec3::Z);
    assert!(lights.sample(&inside, [0.1, 0.5, 0.5]).is_none());
}

#[test]
fn a_shadow_ray_stops_short_of_the_light_and_not_short_of_a_blocker() {
    for (name, light) in area_lights() {
        if name == "inward sphere" {
            continue; // from outside its own wall is in the way, as it should be
        }
        let lights = Lights::new(&light);
        for place in [PLACES[0], PLACES[1], PLACES[3]] {
            let from = surface(place, DVec3::Z);
            for sample in samples(&lights, &from, 4000).flatten() {
                let open = transmittance(
                    &light,
                    &from,
                    sample.direction,
                    sample.reach,
                    &mut Default::default(),
                );
                assert_eq!(open, 1.0, "{name} from {place}");
                assert!(sample.reach <= sample.distance);
                // All but grazing rays reach nearly as far as the light is.
                assert!(sample.reach > 0.999 * sample.distance || sample.pdf_solid_angle > 1e9);
            }
        }
    }
}

#[test]
fn a_scene_without_lights_has_nothing_to_sample() {
    let scene = scene("<shape type=\"sphere\"/>");
    let lights = Lights::new(&scene);
    let from = surface(DVec3::Z * 2.0, DVec3::Z);
    assert!(lights.sample(&from, [0.5; 3]).is_none());
    let ray = Ray::new(from.position, -DVec3::Z);
    assert!(lights.emitted(&ray, None).is_black());
    assert_eq!(lights.emitted_and_pdf(from.position, &ray, None).1, 0.0);
}
