//! A clear sky and the sun in it. Their radiances are held against Mitsuba's in `mitsuba_oracle.rs`.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Ray, SurfacePoint, Transform};
use nephroid::internals::numeric::{SampleMoments, Stream, StreamKind};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::{Daylight, Emitter, SunDisc};
use nephroid::internals::spectrum::daylight::sunlight::SUN_DIAMETER;
use nephroid::internals::spectrum::daylight::{
    ClearSky, Clock, Place, sun_direction, sun_irradiance,
};
use nephroid::internals::transport::lights::Lights;

use crate::support::bsdf::scene;
use crate::support::scene_files;

fn sunsky(inside: &str) -> String {
    format!("<emitter type=\"sunsky\">{inside}</emitter>")
}

fn daylight(inside: &str) -> Daylight {
    match scene_files::scene(&sunsky(inside))
        .unwrap()
        .emitters
        .remove(0)
    {
        Emitter::Sunsky(daylight) => daylight,
        other => panic!("{other:?}"),
    }
}

fn warnings(inside: &str) -> Vec<String> {
    let parts = scene_files::scene(&sunsky(inside)).unwrap();
    parts.warnings.into_iter().map(|it| it.message).collect()
}

/// A point of a level floor.
fn from_above() -> SurfacePoint {
    SurfacePoint {
        position: DVec3::ZERO,
        position_error: DVec3::ZERO,
        geometric_normal: DVec3::Z,
        shading_normal: DVec3::Z,
        uv: DVec2::ZERO,
    }
}

const NORTHERN: Place = Place {
    latitude: 40.0,
    longitude: 0.0,
    timezone: 0.0,
};

fn on(month: i32, day: i32, minute: f64) -> Clock {
    Clock {
        year: 2010,
        month,
        day,
        hour: 0.0,
        minute,
        second: 0.0,
    }
}

/// The highest that the sun stands on a day, minute by minute.
fn noon(month: i32, day: i32, place: &Place) -> DVec3 {
    let minutes = (0..24 * 60).map(|minute| sun_direction(&on(month, day, minute.into()), place));
    minutes.max_by(|a, b| a.z.total_cmp(&b.z)).unwrap()
}

#[test]
fn the_sun_stands_as_high_at_noon_as_the_axis_of_the_earth_is_inclined() {
    // 2010: June 21, 11:28, December 21, 23:38, March 20, 17:32 universal time. The inclination was 23.438°.
    // The sun's declination differs from that of the instant by up to 12 hours of it: 0.2° at the equinox, and
    // its square, 1e-3°, at a solstice. Parallax is 0.002° and minutes leave 0.01°.
    for (month, day, declination, tolerance) in [
        (6, 21, 23.438, 0.02),
        (12, 21, -23.438, 0.02),
        (3, 20, 0.0, 0.2),
    ] {
        let sun = noon(month, day, &NORTHERN);
        let elevation = sun.z.asin().to_degrees();
        let expected = 90.0 - 40.0 + declination;
        assert!(
            (elevation - expected).abs() < tolerance,
            "{elevation} {expected}"
        );
        // In the south, which is +x: within the half minute by which noon is known, 0.13° of hour angle.
        let azimuth = sun.y.atan2(sun.x).to_degrees();
        assert!(azimuth.abs() < 0.5, "{azimuth}");
    }
}

#[test]
fn the_sun_rises_in_the_east_and_sets_in_the_west_when_day_and_night_are_equal() {
    let sun = |hour: f64| sun_direction(&on(3, 20, 60.0 * hour), &NORTHERN);
    // The equation of time is 7.5 minutes: 1.9° of the sky, of which the elevation takes cos 40°, 1.44°. The sun's
    // declination is within 0.2° of zero.
    let [rise, set] = [sun(6.0), sun(18.0)];
    for (sun, west) in [(rise, -1.0), (set, 1.0)] {
        assert!(sun.z.abs() < 1.7f64.to_radians(), "{sun}");
        assert!((sun.y - west).abs() < 0.01, "{sun}");
    }
}

#[test]
fn the_sun_is_mitsubas_within_an_eighth_of_a_degree() {
    // As `mi.traverse` prints `sun_direction`, whose day is known to a quarter.
    let clock = |hour, minute| Clock {
        hour,
        minute,
        ..on(7, 10, 0.0)
    };
    let tokyo = Place {
        latitude: 35.6894,
        longitude: 139.6917,
        timezone: 9.0,
    };
    let cape_town = Place {
        latitude: -33.9,
        longitude: 18.4,
        timezone: 2.0,
    };
    let autumn = Clock {
        year: 2015,
        month: 3,
        day: 20,
        ..clock(9.5, 20.0)
    };
    for (clock, place, mitsuba) in [
        (
            clock(15.0, 0.0),
            tokyo,
            DVec3::new(0.051_385_447, 0.691_747_96, 0.720_308_48),
        ),
        (
            clock(8.0, 0.0),
            tokyo,
            DVec3::new(-0.010_881_035, -0.772_855_94, 0.634_488_17),
        ),
        (
            autumn,
            cape_town,
            DVec3::new(-0.383_410_13, -0.719_442_61, 0.579_136_37),
        ),
    ] {
        let angle = sun_direction(&clock, &place)
            .angle_between(mitsuba)
            .to_degrees();
        assert!(angle < 0.13, "{angle} {mitsuba}");
    }
    // And the file's default is Tokyo's afternoon.
    let default = daylight("").sun.unwrap();
    assert!(default.contains(sun_direction(&clock(15.0, 0.0), &tokyo)));
}

/// |a − b| in the channel where it is largest.
fn apart(a: Rgb, b: Rgb) -> f64 {
    (a - b).map(f64::abs).max_channel()
}

#[test]
fn a_sun_of_any_size_lights_a_surface_across_it_by_the_projection_of_its_disc() {
    for degrees in [0.5358, 5.0, 60.0, 179.0] {
        let half = 0.5 * f64::to_radians(degrees);
        let fluence = Rgb::new(3.0, 2.0, 1.0);
        let sun = SunDisc::new(DVec3::X, half, fluence, DVec3::X);
        let stream = Stream::new(StreamKind::Sobol, 1);
        let count = 1 << 12;
        let cosines = (0..count).map(|index| {
            let [u, v, ..] = stream.point4(index);
            let direction = sun.direction([u, v]);
            sun.radiance(direction) * direction.x
        });
        let found = cosines.sum::<Rgb>() * (sun.solid_angle() / count as f64);
        // E = L π sin² h, with L = fluence / 2π (1 − cos h). Sobol' points of 2¹²: 1e-3 of a range up to 1.
        let expected = fluence * (0.5 * (1.0 + half.cos()));
        assert!(
            apart(found, expected) < 3e-3,
            "{degrees}: {found:?} {expected:?}"
        );
    }
}

#[test]
fn directions_of_the_sun_are_even_and_end_at_its_limb_and_at_the_horizon() {
    let half = 0.2;
    let axis = DVec3::new(0.6, 0.0, 0.1).normalize();
    let sun = SunDisc::new(axis, half, Rgb::WHITE, DVec3::Z);
    let stream = Stream::new(StreamKind::Sobol, 1);
    let (mut mean, mut lit, count) = (DVec3::ZERO, 0, 1 << 12);
    for index in 0..count {
        let [u, v, ..] = stream.point4(index);
        let direction = sun.direction([u, v]);
        assert!(direction.is_normalized() && sun.contains(direction));
        lit += u64::from(!sun.radiance(direction).is_black());
        assert_eq!(sun.radiance(direction).is_black(), direction.z < 0.0);
        mean += direction / count as f64;
    }
    // The mean of a cap is its axis times cos²(half / 2). Sobol' points of 2¹²: 1e-3.
    assert!(
        (mean - axis * (0.5 * half).cos().powi(2)).length() < 1e-3,
        "{mean}"
    );
    // Some of it is below the horizon: a chord at sin 0.165 / sin 0.2 of its radius cuts off 5.2 %, nearly as of a
    // flat disc.
    let above = lit as f64 / count as f64;
    let (h, r): (f64, f64) = (0.1 / 0.37f64.sqrt(), half.sin());
    let flat = 1.0 - ((h / r).acos() - h / r * (1.0 - (h / r).powi(2)).sqrt()) / PI;
    assert!(
        (above - flat).abs() < 0.01 && above < 0.97,
        "{above} {flat}"
    );
    // The limb: γ itself, and a little more.
    let at = |gamma: f64| sun.contains((axis * gamma.cos() + DVec3::Y * gamma.sin()).normalize());
    assert!(at(half * (1.0 - 1e-9)) && !at(half * (1.0 + 1e-9)));
}

#[test]
fn samples_say_what_their_direction_says_and_half_of_them_look_at_the_sun() {
    let scene = scene(&sunsky(
        "<vector name=\"sun_direction\" x=\"0.3\" y=\"-0.5\" z=\"0.6\"/><float name=\"sun_aperture\" value=\"20\"/>",
    ));
    let lights = Lights::new(&scene);
    let [
        Emitter::Sunsky(Daylight {
            sun: Some(sun),
            sky,
        }),
    ] = scene.emitters()
    else {
        panic!("{:?}", scene.emitters());
    };
    let stream = Stream::new(StreamKind::Random, 3);
    let (mut at_sun, mut irradiance) = (0u32, SampleMoments::default());
    let count = 40_000;
    for index in 0..count {
        let [a, b, c, _] = stream.point4(index);
        let sample = lights.sample(&from_above(), [a, b, c]).unwrap();
        let ray = Ray::new(DVec3::ZERO, sample.direction);
        let (emitted, pdf) = lights.emitted_and_pdf(DVec3::ZERO, &ray, None);
        assert_eq!(emitted, lights.emitted(&ray, None));
        // As of maps in `environments.rs`.
        assert!((pdf / sample.pdf_solid_angle - 1.0).abs() < 1e-9);
        let back = sample.radiance_over_pdf * sample.pdf_solid_angle;
        assert!(apart(back, lights.emitted(&ray, None)) <= 1e-9 * back.max_channel());
        at_sun += u32::from(sun.contains(sample.direction));
        irradiance.add(sample.radiance_over_pdf.0[1] * sample.direction.z.max(0.0));
    }
    // Half of them, and the part of the sky's that look there, too: 3 % of the dome, up to ten times as bright.
    let share = f64::from(at_sun) / count as f64;
    assert!((0.5..0.7).contains(&share), "{share}");
    // E of the sun is its cosine's mean over the disc times its irradiance; of the sky the midpoint rule in cos²θ
    // and φ, which is good to 1e-3 of it.
    let up = DVec3::new(0.3, -0.5, 0.6).normalize().z;
    let of_sun = sun.peak().0[1] * PI * 10f64.to_radians().sin().powi(2) * up;
    let (rows, columns) = (200, 400);
    let mut of_sky = 0.0;
    for row in 0..rows {
        let squared = (f64::from(row) + 0.5) / f64::from(rows);
        let (z, out) = (squared.sqrt(), (1.0 - squared).sqrt());
        for column in 0..columns {
            let phi = TAU * (f64::from(column) + 0.5) / f64::from(columns);
            of_sky += sky
                .radiance(DVec3::new(out * phi.cos(), out * phi.sin(), z))
                .0[1];
        }
    }
    of_sky *= PI / f64::from(rows * columns);
    let (mean, error) = (
        irradiance.mean().unwrap(),
        irradiance.standard_error().unwrap(),
    );
    let expected = of_sun + of_sky;
    // 6 standard errors fail a right program once in 5·10⁸.
    assert!(
        (mean - expected).abs() < 6.0 * error + 1e-3 * of_sky,
        "{mean} ± {error}, {expected}"
    );
    assert!(error < 0.02 * expected, "{error} {expected}");
}

#[test]
fn a_skys_light_is_its_formula_and_not_that_of_its_image() {
    let sun = DVec3::new(0.4, 0.2, 0.5).normalize();
    let sky = ClearSky::new(4.0, Rgb::grey(0.3), sun);
    let found = Daylight::new(sky.clone(), None, &Transform::IDENTITY, 2.0).unwrap();
    let mut most: f64 = 0.0;
    for index in 0..500 {
        let [u, v, ..] = Stream::new(StreamKind::Random, 7).point4(index);
        let z = u;
        let out = (1.0 - z * z).sqrt();
        let direction = DVec3::new(out * (TAU * v).cos(), out * (TAU * v).sin(), z).normalize();
        let expected = sky.radiance(direction) * 2.0;
        let light = found.radiance(direction);
        for c in 0..3 {
            // A direction turned by a matrix is off by ε, over which the sky changes by less than 10⁴ of itself.
            assert!(
                (light.0[c] - expected.0[c]).abs() < 1e-11 * expected.0[c],
                "{direction}"
            );
        }
        // Its image is off by more: this test sees the difference.
        let map = &found.sky;
        let cell = map.cell(map.coordinates(direction).0);
        let of_image = cell.blend(|x, y| Rgb(map.image().texel(x, y))) * map.scale();
        most = most.max((of_image.0[2] / expected.0[2] - 1.0).abs());
    }
    assert!(most > 1e-4, "{most}");
}

#[test]
fn the_sun_of_pure_air_is_as_bright_as_known() {
    // Above the air 1361 W/m² reach the Earth. On the ground, with the sun at the zenith of clear air, some 1000
    // W/m², nearly half of it visible: 100,000 lx, 683 lm/W at most: 100,000 / 683 / 106.75 nm = 1.37 W/m²/nm.
    let irradiance = sun_irradiance(2.0, PI / 2.0);
    let luminance = irradiance.0[0] * 0.2126 + irradiance.0[1] * 0.7152 + irradiance.0[2] * 0.0722;
    assert!((1.0..1.8).contains(&luminance), "{luminance}");
    // Haze takes light away, blue first; a low sun is red.
    let hazy = sun_irradiance(8.0, PI / 2.0);
    assert!(hazy.0[2] / hazy.0[0] < irradiance.0[2] / irradiance.0[0]);
    assert!(hazy.max_channel() < irradiance.max_channel());
    let low = sun_irradiance(3.0, 0.1);
    assert!(
        low.0[0] > 2.0 * low.0[2] && low.0[0] < 0.5 * irradiance.0[0],
        "{low:?}"
    );
    assert_eq!(sun_irradiance(3.0, -0.01), Rgb::BLACK);
    assert!((SUN_DIAMETER.to_degrees() - 0.5358).abs() < 1e-15);
}

#[test]
fn what_the_model_cannot_tell_is_said() {
    let below = warnings("<vector name=\"sun_direction\" x=\"1\" y=\"0\" z=\"-0.2\"/>");
    assert!(below[0].contains("below the horizon"), "{below:?}");
    let dark = daylight("<vector name=\"sun_direction\" x=\"1\" y=\"0\" z=\"-0.2\"/>");
    assert_eq!(dark.sun, None);
    assert_eq!(dark.radiance(DVec3::Z), Rgb::BLACK);
    let red = warnings("<vector name=\"sun_direction\" x=\"1\" y=\"0\" z=\"0.01\"/>");
    assert!(red[0].contains("redder than linear sRGB"), "{red:?}");
    assert!(warnings("<vector name=\"sun_direction\" x=\"1\" y=\"0\" z=\"1\"/>").is_empty());
    // No sun is asked for.
    assert_eq!(
        daylight("<float name=\"sun_scale\" value=\"0\"/>").sun,
        None
    );
}

#[test]
fn wrong_numbers_of_a_sunsky_are_errors_that_say_what_is_allowed() {
    let sun = "<vector name=\"sun_direction\" x=\"0\" y=\"0\" z=\"1\"/>";
    for (inside, expected) in [
        (
            "<float name=\"turbidity\" value=\"0.5\"/>".to_owned(),
            "\"turbidity\": must be from 1 to 10, not 0.5",
        ),
        (
            "<float name=\"sun_scale\" value=\"-1\"/>".to_owned(),
            "\"sun_scale\": must be at least 0",
        ),
        (
            "<float name=\"sun_aperture\" value=\"180\"/>".to_owned(),
            "\"sun_aperture\": must be at least 0.000001 and below 180",
        ),
        (
            "<rgb name=\"albedo\" value=\"2\"/>".to_owned(),
            "must lie in 0..=1",
        ),
        (
            "<integer name=\"month\" value=\"13\"/>".to_owned(),
            "\"month\": must be from 1 to 12",
        ),
        (
            "<float name=\"day\" value=\"1.5\"/>".to_owned(),
            "\"day\": must be a whole number, not 1.5",
        ),
        (
            format!("{sun}<float name=\"hour\" value=\"3\"/>"),
            "\"sun_direction\": and \"hour\" exclude each other",
        ),
        (
            "<vector name=\"sun_direction\" x=\"0\" y=\"0\" z=\"0\"/>".to_owned(),
            "must not be zero",
        ),
        (
            "<boolean name=\"complex_sun\" value=\"true\"/>".to_owned(),
            "darker towards its limb",
        ),
        (
            "<transform name=\"to_world\"><scale x=\"2\"/></transform>".to_owned(),
            "must not change angles",
        ),
    ] {
        let error = scene_files::scene(&sunsky(&inside)).unwrap_err();
        assert!(
            error.contains(expected) && error.contains("scene.xml:"),
            "{error}"
        );
    }
    let two = format!("{}<emitter type=\"constant\"/>", sunsky(sun));
    assert!(
        scene_files::scene(&two)
            .unwrap_err()
            .contains("second environment")
    );
}

#[test]
fn without_a_sky_all_samples_look_at_the_sun() {
    let scene = scene(&sunsky("<float name=\"sky_scale\" value=\"0\"/>"));
    assert!(scene.emitters()[0].is_environment() && !scene.emitters()[0].is_delta());
    let lights = Lights::new(&scene);
    for index in 0..100 {
        let [a, b, c, _] = Stream::new(StreamKind::Random, 3).point4(index);
        let sample = lights.sample(&from_above(), [a, b, c]).unwrap();
        assert!(!sample.radiance_over_pdf.is_black());
    }
}

#[test]
fn no_direction_of_a_sky_is_brighter_than_the_bound_of_the_texels_about_it() {
    // Suns between four texels of the image: at the zenith, and half a texel beside one at 60°.
    let texel = PI / 256.0;
    for (turbidity, zenith) in [(1.0, 0.5), (3.0, 0.5), (3.0, 85.5), (10.0, 0.5)] {
        let angle = zenith * texel;
        let sun = DVec3::new(angle.sin(), 0.0, angle.cos());
        let sky = ClearSky::new(turbidity, Rgb::grey(0.2), sun);
        let Daylight { sky: map, .. } =
            Daylight::new(sky, None, &Transform::IDENTITY, 1.0).unwrap();
        for index in 0..400 {
            let [u, v, ..] = Stream::new(StreamKind::Sobol, 2).point4(index);
            let offset = DVec3::new(u - 0.5, v - 0.5, 0.0) * (4.0 * texel);
            let direction = (sun + offset).normalize();
            let cell = map.cell(map.coordinates(direction).0);
            let mut most = Rgb::BLACK;
            for (row, column) in cell
                .rows
                .into_iter()
                .flat_map(|r| cell.columns.map(|c| (r, c)))
            {
                let there = map.image().texel(column, row);
                most = Rgb(std::array::from_fn(|c| most.0[c].max(there[c])));
            }
            let (found, bound) = (map.radiance(direction), map.bound(most));
            assert!(
                (0..3).all(|c| found.0[c] <= bound.0[c]),
                "{found:?} {bound:?}"
            );
            assert!((0..3).all(|c| found.0[c] <= map.peak().0[c]), "{found:?}");
        }
    }
}

#[test]
fn numbers_at_the_edge_of_what_is_written_make_light_or_an_error() {
    for inside in [
        "<vector name=\"sun_direction\" x=\"1e300\" y=\"-1e300\" z=\"1e300\"/>",
        "<vector name=\"sun_direction\" x=\"1e-300\" y=\"0\" z=\"1e-300\"/>",
        "<vector name=\"sun_direction\" x=\"0\" y=\"0\" z=\"1\"/><float name=\"sun_aperture\" value=\"1e-6\"/>",
        "<vector name=\"sun_direction\" x=\"1\" y=\"0\" z=\"0\"/><float name=\"turbidity\" value=\"10\"/><float name=\"albedo\" value=\"0\"/>",
        "<float name=\"sun_scale\" value=\"1e200\"/><float name=\"sky_scale\" value=\"1e-200\"/>",
        "<integer name=\"year\" value=\"9999\"/><integer name=\"month\" value=\"12\"/><integer name=\"day\" value=\"31\"/>",
    ] {
        let light = daylight(inside);
        assert!(
            light.peak().is_finite() && light.peak().min_channel() >= 0.0,
            "{inside}"
        );
        if let Some(sun) = &light.sun {
            assert!(sun.contains(sun.direction([0.3, 0.5])), "{inside}");
        }
    }
    let error = scene_files::scene(&sunsky("<float name=\"sun_aperture\" value=\"1e-300\"/>"));
    assert!(
        error
            .unwrap_err()
            .contains("\"sun_aperture\": must be at least")
    );
}
