//! A prism's rainbow beside its closed form: where lines of the spectrum go, and what colours land where.
//!
//! The closed form is written down here once more: the prism of the scene `rainbow` in the plane of the page,
//! Schott's published coefficients of SF11, Snell's law and Fresnel's equations. Of the crate it takes the
//! tables of the CIE's curves, and the matrix to sRGB.

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Hit, Ray, SurfacePoint, TraversalCounters};
use nephroid::internals::scene::{MaterialsAtWavelength, Scene};
use nephroid::internals::spectrum::observer::{CURVES, xyz_to_srgb};
use nephroid::internals::transport::chain::{Arrival, ChainSettings, ChainSink, ChainTracer};
use nephroid::internals::transport::flux::Flux;
use nephroid::internals::transport::ledger::Fate;
use nephroid::internals::transport::signature::Signature;

use crate::support::chains::light;
use crate::support::scenes::layer;
use crate::support::student::{moments, two_sided_quantile};
use crate::support::{Photons, bundled};

/// Fraunhofer's lines F, d and C [nm].
const LINES: [f64; 3] = [486.1327, 587.5618, 656.2725];

/// The refracting angle.
const ANGLE: f64 = std::f64::consts::FRAC_PI_3;

/// SF11 against air: Schott's data sheet; λ in nm.
fn sf11(wavelength: f64) -> f64 {
    let squared = (wavelength / 1000.0).powi(2);
    let term = |b: f64, c: f64| b * squared / (squared - c);
    let sum = term(1.73848403, 0.0136068604)
        + term(0.311168974, 0.0615960463)
        + term(1.17490871, 121.922711);
    (1.0 + sum).sqrt()
}

/// The incidence at which line d is deviated least.
fn incidence() -> f64 {
    (sf11(LINES[1]) * (0.5 * ANGLE).sin()).asin()
}

/// δ = i + asin(n sin(A − asin(sin(i)/n))) − A.
fn deviation(incidence: f64, n: f64) -> f64 {
    let inside = (incidence.sin() / n).asin();
    incidence + (n * (ANGLE - inside).sin()).asin() - ANGLE
}

fn rainbow(side: usize) -> Scene {
    let glass = [("glass", "sf11")];
    bundled("rainbow", side).with_dispersion(&glass).unwrap()
}

/// The direction of the last leg through the prism.
#[derive(Default)]
struct Exit(Option<DVec3>);

impl ChainSink<3> for Exit {
    fn travels(
        &mut self,
        ray: &Ray,
        _end: Option<(&Hit, &SurfacePoint)>,
        signature: Signature,
        _flux: Flux<3>,
    ) {
        if signature == "LTTD".parse().unwrap() {
            self.0 = Some(ray.direction);
        }
    }

    fn arrived(&mut self, _arrival: &Arrival<3>, _counters: &mut TraversalCounters) -> Fate {
        Fate::Absorbed
    }

    fn ended(&mut self, _signature: Signature, _fate: Fate, _flux: Flux<3>) {}

    fn gained(&mut self, _flux: Flux<3>) {}
}

/// The angle by which the prism deviates light of a wavelength that comes through the middle of the slit, from
/// the sun or from `turned` radians above it.
fn traced(scene: &Scene, wavelength: f64, turned: f64) -> f64 {
    let mut materials = MaterialsAtWavelength::new(scene).unwrap();
    let angle = 0.5 * std::f64::consts::PI - deviation(incidence(), sf11(LINES[1])) + turned;
    let direction = DVec3::new(angle.cos(), 0.0, -angle.sin());
    let ray = Ray {
        origin: DVec3::new(-0.1, 0.0, 0.44739),
        direction,
    };
    let mut exit = Exit::default();
    let mut tracer = ChainTracer::<3>::new(scene, ChainSettings::default());
    tracer.trace_among(materials.at(wavelength), &light(ray), &mut exit);
    exit.0.unwrap().angle_between(direction)
}

/// What is allowed. What is left is the mesh, rounded to single precision (6e-8 of 3 cm in a vertex, 1e-7
/// rad in a facet's normal), and the scene's angles, which have eight digits.
const LINE_ERROR: f64 = 1e-6;

#[test]
fn lines_of_the_spectrum_leave_a_prism_at_their_closed_form_angles() {
    let scene = rainbow(8);
    for line in LINES {
        let (found, expected) = (
            traced(&scene, line, 0.0),
            deviation(incidence(), sf11(line)),
        );
        let off = (found - expected).abs();
        println!("{line} nm: {found:.9} rad, off by {off:.1e}");
        assert!(off < LINE_ERROR, "{line} nm: {found} is not {expected}");
    }
}

#[test]
fn line_d_is_deviated_least_where_the_closed_form_says() {
    let scene = rainbow(8);
    let least = 2.0 * (sf11(LINES[1]) * (0.5 * ANGLE).sin()).asin() - ANGLE;
    assert!((traced(&scene, LINES[1], 0.0) - least).abs() < LINE_ERROR);
    for turned in [-2e-2, -1e-2, 1e-2, 2e-2] {
        let more = traced(&scene, LINES[1], turned) - least;
        // A smaller angle above the horizon is a larger incidence.
        let expected = deviation(incidence() - turned, sf11(LINES[1])) - least;
        assert!(more > 10.0 * LINE_ERROR, "{turned}: {more}");
        assert!(
            (more - expected).abs() < LINE_ERROR,
            "{turned}: {more} is not {expected}"
        );
    }
}

/// A direction after refraction in the plane, and the share of unpolarised light that passes. `normal` is on
/// the side that light comes from; `eta` is the index behind by that before.
fn refracted(direction: DVec2, normal: DVec2, eta: f64) -> Option<(DVec2, f64)> {
    let cos = -direction.dot(normal);
    let cos_behind = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
    if cos_behind.is_nan() {
        return None;
    }
    let behind = direction / eta + normal * (cos / eta - cos_behind);
    let across = ((cos - eta * cos_behind) / (cos + eta * cos_behind)).powi(2);
    let along = ((eta * cos - cos_behind) / (eta * cos + cos_behind)).powi(2);
    Some((behind, 1.0 - 0.5 * (across + along)))
}

/// The sun's direction in the page: x to the right, z up.
fn sun() -> DVec2 {
    let angle = deviation(incidence(), sf11(LINES[1]));
    DVec2::new(angle.sin(), -angle.cos())
}

/// The place on the screen where light of index n lands that passes the slit at a height, and the share of it
/// that the two faces let through.
fn landing(height: f64, n: f64) -> Option<(f64, f64)> {
    let center = DVec2::new(-0.005472, 0.4);
    let first_corner = 0.5 * deviation(incidence(), sf11(LINES[1]));
    // The faces beside the refracting edge look 60° away from it.
    let normals = [ANGLE, -ANGLE].map(|turned| DVec2::from_angle(first_corner + turned));
    let inradius = 0.03 / 12.0f64.sqrt();
    let meet = |origin: DVec2, direction: DVec2, normal: DVec2| {
        let t = (inradius - (origin - center).dot(normal)) / direction.dot(normal);
        origin + direction * t
    };
    let entry = meet(DVec2::new(-0.1, height), sun(), normals[0]);
    let (inside, first) = refracted(sun(), normals[0], n)?;
    let exit = meet(entry, inside, normals[1]);
    let (out, second) = refracted(inside, -normals[1], 1.0 / n)?;
    Some((exit.x - out.x / out.y * exit.y, first * second))
}

/// Irradiance of LTTD on the columns of the screen, three channels each: light of 1000 W/m² by wavelengths.
fn columns(side: usize) -> Vec<[f64; 3]> {
    const STEP: f64 = 0.02;
    let row = |wavelength: f64| (wavelength - 360.0) / 5.0;
    let response = |wavelength: f64| -> [f64; 3] {
        let below = row(wavelength).floor() as usize;
        let part = row(wavelength) - below as f64;
        let at = |row: usize| {
            let [x, y, z, d65] = CURVES[row];
            xyz_to_srgb([x, y, z]).0.map(|channel| channel * d65)
        };
        let (low, high) = (at(below), at(below + 1));
        std::array::from_fn(|c| low[c] + (high[c] - low[c]) * part)
    };
    let wavelengths = || (0..20_000).map(|step| 380.0 + STEP * (f64::from(step) + 0.5));
    let mut white = [0.0; 3];
    for wavelength in wavelengths() {
        let channels = response(wavelength);
        (0..3).for_each(|c| white[c] += STEP * channels[c]);
    }
    let width = 0.1 / side as f64;
    let mut columns = vec![[0.0; 3]; side];
    for wavelength in wavelengths() {
        let n = sf11(wavelength);
        let slit = [0.44539, 0.44939].map(|height| landing(height, n));
        let [Some((a, share)), Some((b, _))] = slit else {
            continue;
        };
        let (low, high) = (a.min(b), a.max(b));
        // Through each metre of the slit's length.
        let flux = 1000.0 * sun().x * 0.004 * share;
        let channels = response(wavelength);
        for (column, sum) in columns.iter_mut().enumerate() {
            let left = -0.075 + width * column as f64;
            let inside = (high.min(left + width) - low.max(left)).max(0.0) / (high - low);
            for c in 0..3 {
                sum[c] += STEP * channels[c] / white[c] * flux * inside / width;
            }
        }
    }
    columns
}

/// The chance that a right program fails.
const ALPHA: f64 = 1e-4;

#[test]
fn the_rainbow_has_its_closed_form_colours_on_every_texel() {
    const SIDE: usize = 20;
    // Rows that the slit, 6 cm long, lights as a whole: 5 mm each, from -3 cm to 3 cm.
    let rows = 4..16;
    let scene = rainbow(SIDE);
    let estimate = Photons::new(1 << 23).estimate(&scene);
    let expected = columns(SIDE);
    let judged: Vec<usize> = (0..SIDE * SIDE)
        .filter(|texel| rows.contains(&(texel / SIDE)) && estimate.counts[*texel] >= 300)
        .collect();
    assert!(judged.len() >= 12 * 12, "{} texels", judged.len());
    let limit = two_sided_quantile(ALPHA / (3 * judged.len()) as f64, 31);
    let (mut negative, mut squares, mut bar, mut light) = (0, 0.0, 0.0, 0.0);
    for c in 0..3 {
        let (values, errors) = layer(&estimate, "LTTD", c);
        let truths: Vec<f64> = expected.iter().map(|channels| channels[c]).collect();
        for texel in &judged {
            let (value, error) = (values[*texel], errors[*texel]);
            let truth = truths[texel % SIDE];
            let z = (value - truth) / error;
            assert!(
                z.abs() < limit,
                "texel {texel}, channel {c}: {value} ± {error}, not {truth}"
            );
            negative += u32::from(value < -limit * error);
            squares += z * z;
            bar += error * error;
            light += truth * truth;
        }
    }
    let count = (3 * judged.len()) as f64;
    println!(
        "{} texels, mean z² {:.3}, bar {:.2e}, {negative} channels below zero",
        judged.len(),
        squares / count,
        (bar / light).sqrt()
    );
    // Bars tell how far off values are; the three channels of a texel count as one value.
    let moments = moments(31);
    let most = moments.variance + 4.0 * moments.deviation_of_square / (judged.len() as f64).sqrt();
    assert!(
        squares / count < most,
        "mean z² {} is above {most}",
        squares / count
    );
    // Spectral colours are beyond sRGB: red is below zero in the green.
    assert!(negative > 12, "{negative} channels are below zero");
    // The bar is worth something.
    assert!((bar / light).sqrt() < 0.03);
}
