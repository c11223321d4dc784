//! Every bsdf is Mitsuba's, direction by direction.
//!
//! The numbers are those of Mitsuba 3.9.1, `scalar_rgb`, written by `tests/mitsuba/bsdf_oracle.py`.

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::Ray;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::transport::bsdf::{Bsdf, Transport};

use crate::support::bsdf::{Surface, direction, folder};

/// Relative. Mitsuba computes in f32 (2⁻²⁴ = 6e-8). Half vectors are off by a few of that, and the
/// sharpest distribution here, α = 0.05, turns it into 2 tan θ_m / (α² (1 + ...)) times as much: up to some
/// 400 near the edge of the lobe. The tables of rough plastic are sums of 1024 and 16384 such numbers.
const TOLERANCE: f64 = 1e-4;

/// Of values that cancel to nothing beside what they are made of, at most 1 or so here.
const ABSOLUTE: f64 = 1e-6;

/// Mitsuba's density for Beckmann's distribution has the fit of G₁ that its value has, off by
/// 0.35 % from what it samples; ours has the true one.
const FIT: f64 = 3.5e-3;

struct Case {
    bsdf: String,
    /// The word that the line begins with, and the numbers after it.
    lines: Vec<(String, Vec<f64>)>,
}

fn cases() -> Vec<Case> {
    let text = std::fs::read_to_string(folder().join("bsdf_oracle.txt")).unwrap();
    let mut cases: Vec<Case> = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (word, rest) = line.split_once(' ').unwrap();
        if word == "case" {
            cases.push(Case {
                bsdf: rest.to_owned(),
                lines: Vec::new(),
            });
        } else {
            let numbers = rest.split(' ').map(|number| number.parse().unwrap());
            let last = cases.last_mut().unwrap();
            last.lines.push((word.to_owned(), numbers.collect()));
        }
    }
    cases
}

fn check(what: &str, found: f64, mitsuba: f64, tolerance: f64) -> Result<(), String> {
    if (found - mitsuba).abs() <= tolerance * mitsuba.abs() + ABSOLUTE {
        Ok(())
    } else {
        Err(format!("{what}: {found}, Mitsuba {mitsuba}"))
    }
}

fn check_rgb(what: &str, found: Rgb, mitsuba: &[f64]) -> Result<(), String> {
    (0..3).try_for_each(|c| check(what, found.0[c], mitsuba[c], TOLERANCE))
}

fn check_eval(bsdf: &Bsdf, case: &str, numbers: &[f64]) -> Result<(), String> {
    let wi = direction(numbers[0], numbers[1]);
    let wo = direction(numbers[2], numbers[3]);
    check_rgb(
        "f cos",
        bsdf.eval(wi, wo, Transport::Radiance),
        &numbers[4..7],
    )?;
    // Mitsuba leaves turned normals out of the adjoint. At grazing angles its thin sheet lets light through one way
    // only: the adjoint has that of the other way.
    let is_lopsided = case.contains("principledthin") && wi.z * wo.z < 0.0;
    if !case.contains("map\"") && !is_lopsided {
        check_rgb(
            "adjoint",
            bsdf.eval(wi, wo, Transport::Flux),
            &numbers[7..10],
        )?;
    }
    let is_fitted =
        case.contains("beckmann") || case.contains("bsdf type=\"roughconductor\"><texture");
    let tolerance = if is_fitted {
        FIT + TOLERANCE
    } else {
        TOLERANCE
    };
    check(
        "density",
        bsdf.pdf_solid_angle(wi, wo),
        numbers[10],
        tolerance,
    )
}

fn check_delta(bsdf: &Bsdf, case: &str, numbers: &[f64]) -> Result<(), String> {
    let wi = direction(numbers[0], numbers[1]);
    let u = [numbers[2], 0.3, 0.6];
    let sample = bsdf.sample(wi, u, Transport::Radiance).ok_or("no sample")?;
    assert!(sample.is_delta);
    let wo = DVec3::new(numbers[3], numbers[4], numbers[5]);
    if !sample.wo.abs_diff_eq(wo, 1e-6) {
        return Err(format!("goes to {}, Mitsuba {wo}", sample.wo));
    }
    check_rgb("weight", sample.weight, &numbers[6..9])?;
    if !case.contains("map\"") {
        let flux = bsdf.sample(wi, u, Transport::Flux).ok_or("no sample")?;
        check_rgb("adjoint weight", flux.weight, &numbers[9..12])?;
    }
    check(
        "probability",
        sample.pdf_solid_angle,
        numbers[12],
        TOLERANCE,
    )?;
    check("eta", sample.eta, numbers[13], TOLERANCE)
}

#[test]
fn every_bsdf_is_mitsubas_in_every_direction() {
    let mut wrong = Vec::new();
    let mut compared = 0;
    for case in cases() {
        let surface = Surface::square(&case.bsdf, DVec2::new(0.3, 0.7));
        let bsdf = surface.bsdf();
        for (word, numbers) in &case.lines {
            compared += 1;
            let result = match word.as_str() {
                "eval" => check_eval(&bsdf, &case.bsdf, numbers),
                "delta" => check_delta(&bsdf, &case.bsdf, numbers),
                _ => panic!("{word}"),
            };
            if let Err(error) = result {
                wrong.push(format!("{}\n    {:?}: {error}", case.bsdf, &numbers[..4]));
            }
        }
    }
    println!("{compared} pairs of directions, {} wrong", wrong.len());
    assert!(compared > 1500);
    assert!(
        wrong.is_empty(),
        "{} of {compared}:\n{}",
        wrong.len(),
        wrong[..wrong.len().min(60)].join("\n")
    );
}

/// The same for bsdfs that care which way a surface runs, on shapes of every kind: numbers of
/// `tests/mitsuba/frame_oracle.py`.
#[test]
fn tangents_and_turned_normals_are_mitsubas_on_every_shape() {
    let text = std::fs::read_to_string(folder().join("frame_oracle.txt")).unwrap();
    let mut shape = "";
    let mut wrong = Vec::new();
    let mut lit = 0;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        if let Some(case) = line.strip_prefix("case ") {
            shape = case;
            continue;
        }
        let numbers: Vec<f64> = line
            .split(' ')
            .map(|number| number.parse().unwrap())
            .collect();
        let [x, y, wi_theta, wi_phi, wo_theta, wo_phi, value] = numbers[..] else {
            panic!("{line}");
        };
        let surface = Surface::of(shape, Ray::new(DVec3::new(x, y, 5.0), -DVec3::Z));
        let wi = direction(wi_theta, wi_phi);
        let wo = direction(wo_theta, wo_phi);
        let found = surface.bsdf().eval(wi, wo, Transport::Radiance).0[1];
        lit += usize::from(value > 0.0);
        // Hits are known to f32 (some 1e-7 of the distance 5), and a bump map's slope changes by its
        // full size, 4 texels times a scale of 0.6, over a texel: up to 1e-5 of a slope of order 1; values
        // change by a few times as much.
        if let Err(error) = check("f cos", found, value, TOLERANCE) {
            wrong.push(format!("{shape}\n    {line}: {error}"));
        }
    }
    assert!(lit > 100, "{lit}");
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}
