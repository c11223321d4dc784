//! Every emitter is Mitsuba's, ray by ray.
//!
//! The numbers are those of Mitsuba 3.9.1, `scalar_rgb`, written by `tests/mitsuba/emitter_oracle.py`.

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Ray, SurfacePoint};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::lights::Lights;

use crate::support::bsdf::{folder, scene};

/// Relative. Mitsuba computes in f32 (2⁻²⁴ = 6e-8). A hit is off by some 1e-7 of the distance, 3, which its
/// cosine of at least 0.2 turns into 2e-6 of the density. Angles to a map's poles are off by 6e-8 / sin θ,
/// hardly more than 1e-6 in the directions chosen: as much of sin θ, and of the way between two rows.
const TOLERANCE: f64 = 1e-4;

/// Of radiances up to 8 that change by their whole range over a texel: an eighth of the turn, known to 4e-7.
const ABSOLUTE: f64 = 1e-5;

fn close(found: f64, mitsuba: f64) -> bool {
    (found - mitsuba).abs() <= TOLERANCE * mitsuba.abs() + ABSOLUTE
}

fn close_rgb(found: Rgb, mitsuba: &[f64]) -> bool {
    (0..3).all(|c| close(found.0[c], mitsuba[c]))
}

fn free_point(position: DVec3) -> SurfacePoint {
    SurfacePoint {
        position,
        position_error: DVec3::ZERO,
        geometric_normal: DVec3::Z,
        shading_normal: DVec3::Z,
        uv: DVec2::ZERO,
    }
}

/// Checks the point that a ray meets, and the density of its direction.
fn check_ray(scene: &Scene, lights: &Lights, case: &str, numbers: &[f64]) -> Result<(), String> {
    let from = DVec3::from_slice(numbers);
    let direction = DVec3::from_slice(&numbers[3..]).normalize();
    let ray = Ray::new(from, direction);
    let hit = scene
        .world()
        .closest_hit(&ray, f64::INFINITY, &mut Default::default());
    let found = lights.emitted(&ray, hit.as_ref());
    if !close_rgb(found, &numbers[6..9]) {
        return Err(format!("radiance {found:?}, Mitsuba {:?}", &numbers[6..9]));
    }
    let Some(&mitsuba) = numbers.get(9) else {
        return Ok(());
    };
    let pdf = lights.emitted_and_pdf(from, &ray, hit.as_ref()).1;
    let is_inside = case.contains("sphere") && case.contains("flip_normals");
    // From inside of a ball Mitsuba chooses points of its wall, and this program directions.
    let expected = if is_inside {
        0.25 * std::f64::consts::FRAC_1_PI
    } else {
        mitsuba
    };
    if !close(pdf, expected) {
        return Err(format!("density {pdf}, Mitsuba {mitsuba}"));
    }
    Ok(())
}

/// The one direction to a light.
fn check_delta(lights: &Lights, numbers: &[f64]) -> Result<(), String> {
    let from = free_point(DVec3::from_slice(numbers));
    let Some(sample) = lights.sample(&from, [0.5; 3]) else {
        let is_dark = numbers[7..].iter().all(|channel| *channel < 1e-6);
        return if is_dark {
            Ok(())
        } else {
            Err("no sample".to_owned())
        };
    };
    let direction = DVec3::from_slice(&numbers[3..]);
    if !sample.direction.abs_diff_eq(direction, 1e-6) {
        return Err(format!("from {}", sample.direction));
    }
    let same_distance = sample.distance == numbers[6] || close(sample.distance, numbers[6]);
    if !same_distance || !close_rgb(sample.radiance_over_pdf, &numbers[7..]) {
        return Err(format!(
            "{} away, irradiance {:?}",
            sample.distance, sample.radiance_over_pdf
        ));
    }
    Ok(())
}

#[test]
fn every_emitter_is_mitsubas_along_every_ray() {
    let text = std::fs::read_to_string(folder().join("emitter_oracle.txt")).unwrap();
    let mut wrong = Vec::new();
    let (mut compared, mut lit) = (0, 0);
    let cases = text.split("\ncase ").skip(1);
    for case in cases {
        let mut lines = case.lines();
        let elements = lines.next().unwrap();
        let scene = scene(elements);
        let lights = Lights::new(&scene);
        for line in lines {
            let (word, rest) = line.split_once(' ').unwrap();
            let numbers: Vec<f64> = rest
                .split_whitespace()
                .map(|number| number.parse().unwrap())
                .collect();
            compared += 1;
            lit += usize::from(numbers[6..9].iter().any(|channel| *channel > 0.0));
            let result = match word {
                "ray" => check_ray(&scene, &lights, elements, &numbers),
                "delta" => check_delta(&lights, &numbers),
                _ => panic!("{word}"),
            };
            if let Err(error) = result {
                wrong.push(format!("{elements}\n    {line}: {error}"));
            }
        }
    }
    println!("{compared} rays, {lit} of them lit");
    assert!(compared > 700 && lit > 500, "{compared} {lit}");
    assert!(
        wrong.is_empty(),
        "{} of {compared}:\n{}",
        wrong.len(),
        wrong[..wrong.len().min(30)].join("\n")
    );
}
