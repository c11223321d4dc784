//! Light from all round: its sampling, its closed forms, and who refuses it.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat4, DVec2, DVec3};
use nephroid::internals::film::bitmap::Bitmap;
use nephroid::internals::geometry::{Ray, SurfacePoint, Transform};
use nephroid::internals::numeric::distributions::chi_squared_survival;
use nephroid::internals::numeric::{SampleMoments, Stream, StreamKind};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::beams::supports;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::reference::probe::{ProbeSettings, probe};
use nephroid::internals::run::Progress;
use nephroid::internals::scene::{Emitter, Envmap, EnvmapError, Scene, SceneParts, ShapeId};
use nephroid::internals::transport::lights::{LightSample, Lights};

use crate::support;
use crate::support::bsdf::{Bins, folder, scene};
use crate::support::scene_files::Folder;

/// Standard errors that an estimate may be off: 6 fail a right program once in 5·10⁸ comparisons.
const SIGMAS: f64 = 6.0;

/// The probability that the χ² test fails a right program.
const ALPHA: f64 = 1e-6;

const MAP: &str = "<emitter type=\"envmap\"><string name=\"filename\" value=\"environment.exr\"/>
    <transform name=\"to_world\"><rotate x=\"1\" angle=\"77\"/><rotate z=\"1\" angle=\"30\"/></transform></emitter>";

fn point(normal: DVec3) -> SurfacePoint {
    SurfacePoint {
        position: DVec3::new(1.0, 2.0, 3.0),
        position_error: DVec3::ZERO,
        geometric_normal: normal,
        shading_normal: normal,
        uv: DVec2::ZERO,
    }
}

fn samples<'a>(lights: &'a Lights, count: u64) -> impl Iterator<Item = LightSample> + 'a {
    let stream = Stream::new(StreamKind::Random, 3);
    (0..count).filter_map(move |index| {
        let [a, b, c, _] = stream.point4(index);
        lights.sample(&point(DVec3::Z), [a, b, c])
    })
}

fn identity() -> Transform {
    Transform::IDENTITY
}

fn image(width: usize, texels: Vec<[f32; 3]>) -> Arc<Bitmap> {
    Arc::new(Bitmap::new(width, texels).unwrap())
}

#[test]
fn directions_fall_as_often_as_their_density_says() {
    const COUNT: u64 = 200_000;
    let bins = Bins {
        rows: 12,
        columns: 24,
    };
    for environment in ["<emitter type=\"constant\"/>", MAP] {
        let scene = scene(environment);
        let lights = Lights::new(&scene);
        let mut found = vec![0u32; bins.rows * bins.columns];
        for sample in samples(&lights, COUNT) {
            found[bins.of(sample.direction)] += 1;
        }
        assert_eq!(u64::from(found.iter().sum::<u32>()), COUNT);
        let pdf = |w: DVec3| {
            lights
                .emitted_and_pdf(DVec3::ZERO, &Ray::new(DVec3::ZERO, w), None)
                .1
        };
        let expected = bins.integrals(pdf, 1e-7);
        let whole: f64 = expected.iter().sum();
        // 288 bins, 16 squares each, good to 1e-7 / 16 a square.
        assert!((whole - 1.0).abs() < 288.0 * 1e-7, "{whole}");
        // Bins of less than 5 are counted together.
        let (mut statistic, mut degrees) = (0.0, -1.0);
        let (mut few_found, mut few_expected) = (0.0, 0.0);
        for (found, share) in found.iter().zip(&expected) {
            let expected = share * COUNT as f64;
            if expected < 5.0 {
                few_found += f64::from(*found);
                few_expected += expected;
            } else {
                statistic += (f64::from(*found) - expected).powi(2) / expected;
                degrees += 1.0;
            }
        }
        if few_expected > 5.0 {
            statistic += (few_found - few_expected).powi(2) / few_expected;
            degrees += 1.0;
        }
        let p = chi_squared_survival(statistic, degrees);
        assert!(
            p > ALPHA,
            "{environment}: χ² {statistic} of {degrees}, p {p:e}"
        );
    }
}

#[test]
fn a_sample_says_what_its_direction_says() {
    let scene = scene(MAP);
    let lights = Lights::new(&scene);
    for sample in samples(&lights, 2000) {
        assert!(sample.distance.is_infinite() && !sample.is_delta);
        let ray = Ray::new(DVec3::ZERO, sample.direction);
        let (radiance, pdf) = lights.emitted_and_pdf(DVec3::ZERO, &ray, None);
        assert_eq!(radiance, lights.emitted(&ray, None));
        // A direction is known to ε, its angle about the poles to ε / sin θ, over which weights change by
        // less than 8 / 2π of themselves a radian; texels that are nearly black may differ by more.
        let error = (pdf / sample.pdf_solid_angle - 1.0).abs();
        assert!(error < 1e-9, "{error:e}");
        let back = sample.radiance_over_pdf * sample.pdf_solid_angle;
        for c in 0..3 {
            assert!((back.0[c] - radiance.0[c]).abs() < 1e-12);
        }
    }
}

#[test]
fn under_even_light_irradiance_is_pi_l() {
    let even = Envmap::new(image(7, vec![[2.0, 2.0, 2.0]; 28]), &identity(), 1.5).unwrap();
    let parts = SceneParts {
        emitters: vec![Emitter::Envmap(even)],
        ..SceneParts::default()
    };
    let map = Scene::new(parts).unwrap();
    let constant =
        scene("<emitter type=\"constant\"><rgb name=\"radiance\" value=\"3\"/></emitter>");
    for scene in [map, constant] {
        let lights = Lights::new(&scene);
        let normal = DVec3::new(0.6, 0.0, -0.8);
        let mut moments = SampleMoments::default();
        for sample in samples(&lights, 100_000) {
            moments.add(sample.radiance_over_pdf.0[0] * sample.direction.dot(normal).max(0.0));
        }
        let (mean, error) = (moments.mean().unwrap(), moments.standard_error().unwrap());
        assert!((mean - 3.0 * PI).abs() < SIGMAS * error, "{mean} ± {error}");
        // Uniform directions: the spread of 12 π cos θ on one half of the sphere, 12, by √n.
        assert!(error < 0.05, "{error}");
    }
}

#[test]
fn a_map_repeats_across_its_seam_and_is_one_value_at_its_poles() {
    let texels: Vec<[f32; 3]> = (0..12).map(|i| [i as f32, 1.0, 2.0]).collect();
    let map = Envmap::new(image(4, texels), &identity(), 1.0).unwrap();
    // The seam, between the centers of the last column and the first, looks along −z: −x beside +x.
    let beside = |x: f64| map.radiance(DVec3::new(x, 0.0, -1.0).normalize()).0[0];
    // Row 1 holds 4 to 7: half way from 7 to 4.
    assert!((beside(1e-12) - 5.5).abs() < 1e-9 && (beside(-1e-12) - 5.5).abs() < 1e-9);
    // A quarter of a turn a column: its center is an eighth to the right of −z.
    let first = map.radiance(DVec3::new(1.0, 0.0, -1.0).normalize());
    assert!((first.0[0] - 4.0).abs() < 1e-12);
    // The last row at −y.
    let bottom = map.radiance(DVec3::new(1e-9, -1.0, -1e-9).normalize());
    assert!((bottom.0[0] - 8.0).abs() < 1e-6, "{bottom:?}");
    // What lies in a direction lies in the direction of where it lies.
    for direction in [DVec3::X, -DVec3::Z, DVec3::new(0.3, -0.9, 0.1).normalize()] {
        let (back, sin) = map.direction(map.coordinates(direction).0);
        assert!(back.abs_diff_eq(direction, 1e-14));
        assert!((sin - direction.x.hypot(direction.z)).abs() < 1e-14);
    }
}

#[test]
fn a_black_map_is_never_sampled() {
    let black = Envmap::new(image(2, vec![[0.0; 3]; 6]), &identity(), 1.0).unwrap();
    let parts = SceneParts {
        emitters: vec![Emitter::Envmap(black)],
        ..SceneParts::default()
    };
    let scene = Scene::new(parts).unwrap();
    let lights = Lights::new(&scene);
    assert_eq!(samples(&lights, 100).count(), 0);
    let ray = Ray::new(DVec3::ZERO, DVec3::Y);
    assert_eq!(lights.emitted_and_pdf(DVec3::ZERO, &ray, None).1, 0.0);
    assert_eq!(lights.emitted(&ray, None), Rgb::BLACK);
}

#[test]
fn an_environment_is_what_rays_meet_that_meet_nothing() {
    let scene = scene(
        "<shape type=\"sphere\"/><emitter type=\"constant\"><rgb name=\"radiance\" value=\"1, 2, 3\"/></emitter>",
    );
    let lights = Lights::new(&scene);
    let ray = Ray::new(DVec3::Z * 3.0, -DVec3::Z);
    let hit = scene
        .world()
        .closest_hit(&ray, f64::INFINITY, &mut Default::default());
    assert_eq!(lights.emitted(&ray, hit.as_ref()), Rgb::BLACK);
    assert_eq!(
        lights.emitted_and_pdf(ray.origin, &ray, hit.as_ref()).1,
        0.0
    );
    assert_eq!(lights.emitted(&ray, None), Rgb::new(1.0, 2.0, 3.0));
    let pdf = lights.emitted_and_pdf(ray.origin, &ray, None).1;
    assert!((pdf * 2.0 * TAU - 1.0).abs() < 4.0 * f64::EPSILON);
}

#[test]
fn images_that_are_no_environment_are_refused() {
    let good = || image(2, vec![[1.0; 3]; 6]);
    let refusal = |image, to_world: &Transform, scale| Envmap::new(image, to_world, scale).err();
    assert_eq!(refusal(good(), &identity(), 1.0), None);
    assert_eq!(
        refusal(image(2, vec![[1.0; 3]; 4]), &identity(), 1.0),
        Some(EnvmapError::Size {
            width: 2,
            height: 2
        })
    );
    let mut texels = vec![[1.0; 3]; 6];
    texels[3][1] = -0.5;
    assert_eq!(
        refusal(image(2, texels), &identity(), 1.0),
        Some(EnvmapError::Negative {
            column: 1,
            row: 1,
            value: -0.5
        })
    );
    let scaled = |scale| Transform::from_matrix(DMat4::from_scale(scale)).unwrap();
    assert_eq!(
        refusal(good(), &scaled(DVec3::new(1.0, 2.0, 1.0)), 1.0),
        Some(EnvmapError::Stretched)
    );
    assert_eq!(
        refusal(good(), &scaled(DVec3::new(1.0, 1.0, -1.0)), 1.0),
        None
    );
    for scale in [-1.0, f64::INFINITY] {
        assert_eq!(
            refusal(good(), &identity(), scale),
            Some(EnvmapError::Scale { scale })
        );
    }
    assert!(refusal(good(), &identity(), f64::NAN).is_some());
}

#[test]
fn a_scene_has_one_environment_and_a_shape_one_emitter() {
    let constant = Emitter::Constant {
        radiance: Rgb::WHITE,
    };
    let parts = SceneParts {
        emitters: vec![constant.clone(), constant],
        ..SceneParts::default()
    };
    let error = Scene::new(parts).unwrap_err().to_string();
    assert!(error.contains("two environments"), "{error}");
    let area = Emitter::Area {
        shape: ShapeId(0),
        radiance: Rgb::WHITE,
        texture: None,
    };
    let mut parts = support::scene_files::scene("<shape type=\"sphere\"/>").unwrap();
    parts.emitters = vec![area.clone(), area];
    let error = Scene::new(parts).unwrap_err().to_string();
    assert!(error.contains("two emitters"), "{error}");
}

#[test]
fn photons_beams_and_probes_refuse_textures_on_smooth_interfaces_by_name() {
    let scene = scene(
        "<emitter type=\"point\"/><shape type=\"rectangle\"><sensor type=\"irradiancemeter\"/></shape>
         <shape type=\"sphere\" id=\"ball\"><bsdf type=\"dielectric\"><texture type=\"bitmap\" name=\"specular_transmittance\">
         <string name=\"filename\" value=\"color.png\"/></texture></bsdf></shape>",
    );
    for message in refusals(&scene) {
        let named = "shape \"ball\" has a dielectric with a texture";
        assert!(message.contains(named), "{message}");
    }
}

/// A scene beside a copy of the oracle's environment.
fn loaded(elements: &str) -> Result<SceneParts, String> {
    let temporary = Folder::new();
    let map = std::fs::read(folder().join("environment.exr")).unwrap();
    temporary.write("environment.exr", map);
    temporary.write("broken.exr", b"no image");
    temporary.write(
        "scene.xml",
        format!("<scene version=\"3.0.0\">\n{elements}\n</scene>"),
    );
    temporary.load("scene.xml", &[])
}

#[test]
fn a_scaled_environment_is_as_far_away_as_any() {
    let map = |scale: &str| {
        let parts = loaded(&format!(
            "<emitter type=\"envmap\"><string name=\"filename\" value=\"environment.exr\"/><transform name=\"to_world\">\
             {scale}<rotate x=\"0.6\" y=\"0.8\" angle=\"70\"/></transform></emitter>"
        ));
        let parts = parts.unwrap();
        let Emitter::Envmap(map) = parts.emitters[0].clone() else {
            panic!("{:?}", parts.emitters);
        };
        let warnings: Vec<_> = parts.warnings.into_iter().map(|one| one.message).collect();
        (map, warnings)
    };
    let (plain, none) = map("");
    assert!(none.is_empty(), "{none:?}");
    for (scale, factor) in [
        ("<scale value=\"1000\"/>", "1000.000000"),
        ("<scale value=\"-0.5\"/><scale value=\"-1\"/>", "0.500000"),
    ] {
        let (scaled, warnings) = map(scale);
        let expected = format!("scales the environment by {factor}");
        assert!(warnings[0].contains(&expected), "{warnings:?}");
        for direction in [DVec3::X, DVec3::Y, DVec3::new(1.0, -2.0, 2.0) / 3.0] {
            let (found, expected) = (scaled.radiance(direction), plain.radiance(direction));
            for c in 0..3 {
                // Coordinates are off by a few roundings, times the image's slope: some texels of size 1.
                let off = (found.0[c] - expected.0[c]).abs();
                assert!(off <= 1e-13, "{direction}: {found:?} {expected:?}");
            }
        }
    }
}

#[test]
fn errors_of_environments_name_place_and_reason() {
    let map = |rest: &str| {
        loaded(&format!(
            "<emitter type=\"envmap\">{rest}<string name=\"filename\" value=\"environment.exr\"/></emitter>"
        ))
    };
    assert!(map("").is_ok_and(|parts| parts.warnings.is_empty()));
    let cases = [
        (
            map("<float name=\"scale\" value=\"-2\"/>"),
            "scene.xml:2",
            "\"scale\" is -2",
        ),
        (
            map("<transform name=\"to_world\"><scale x=\"2\"/></transform>"),
            "scene.xml:2",
            "must be a rotation",
        ),
        (
            loaded("<emitter type=\"envmap\"/>"),
            "scene.xml:2",
            "filename",
        ),
        (
            loaded(
                "<emitter type=\"envmap\"><string name=\"filename\" value=\"none.exr\"/></emitter>",
            ),
            "scene.xml:2",
            "none.exr cannot be read",
        ),
        (
            loaded(
                "<emitter type=\"envmap\"><string name=\"filename\" value=\"broken.exr\"/></emitter>",
            ),
            "scene.xml:2",
            "broken.exr",
        ),
        (
            loaded("<emitter type=\"constant\"/>\n<emitter type=\"constant\"/>"),
            "scene.xml:3",
            "second environment",
        ),
        (
            loaded("<emitter type=\"constant\"><float name=\"scale\" value=\"2\"/></emitter>"),
            "scene.xml:2",
            "scale",
        ),
        (
            loaded("<shape type=\"sphere\"><emitter type=\"constant\"/></shape>"),
            "scene.xml:2",
            "cannot be inside a shape",
        ),
    ];
    for (result, place, reason) in cases {
        let error = result.unwrap_err();
        assert!(error.contains(place) && error.contains(reason), "{error}");
    }
}

/// Messages of beams and probes on a scene that they must refuse, for its first sensor.
fn refusals(scene: &Scene) -> [String; 2] {
    let sensor = &scene.sensors()[0];
    let probed = probe(scene, sensor, DVec2::splat(0.5), &ProbeSettings::default());
    [
        supports(scene).unwrap_err().to_string(),
        probed.unwrap_err().to_string(),
    ]
}

#[test]
fn methods_refuse_what_they_cannot_start_from_by_name() {
    let meter = "<shape type=\"rectangle\"><sensor type=\"irradiancemeter\"/></shape>";
    let along = "<shape type=\"disk\"><emitter type=\"directionalarea\"/></shape>";
    for (emitter, named) in [
        (MAP, "emitter 0 (envmap) shines from all round"),
        (
            "<emitter type=\"constant\"/>",
            "emitter 0 (constant) shines from all round",
        ),
        (
            along,
            "emitter 0 (directionalarea) shines along the normals",
        ),
    ] {
        let scene = scene(&format!("{emitter}{meter}"));
        let progress = Progress::default();
        let settings = PhotonSettings::default();
        let photons = Setup::new(&scene, &scene.sensors()[0], settings, &progress);
        assert!(photons.is_ok(), "{named}");
        for message in refusals(&scene) {
            assert!(
                message.contains(named) && message.contains("--method path"),
                "{message}"
            );
        }
    }
}
