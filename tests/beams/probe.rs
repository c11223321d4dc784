//! Probes of round and mirroring scenes find the light of the closed forms' own formulas, path by path.
//!
//! The formulas are those of `closed_form::GlassBall` and `MirrorCup`, taken at a point: one root on a line
//! for each preimage, found by bisection, and the sheet's width by differentiating the formula by hand.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::reference::closed_form::{GlassBall, KnownPath};

use crate::support;
use crate::support::probes::{of, probe_at, sign_changes, sum};
use crate::support::{Photons, bundled};

/// Generic directions: no symmetry of the cells.
fn around(radius: f64, number: u32) -> DVec2 {
    DVec2::from_angle(0.37 + 2.399963 * f64::from(number)) * radius
}

/// One preimage of a point at a distance from the ball's axis.
struct Preimage {
    irradiance: f64,
    /// |dr/di|
    slope: f64,
}

/// r(i), dr/di and dΦ/di of light that meets the ball at the incidence i and is reflected `inside` times
/// within it, or once from outside (`None`); `None` where it goes up.
fn ball_map(incidence: f64, inside: Option<u32>) -> Option<[f64; 3]> {
    let (sin, cos) = incidence.sin_cos();
    let ratio = 1.0 / 2.6;
    let theta = (ratio * sin).asin();
    let theta_slope = ratio * cos / theta.cos();
    let flux = TAU * 100.0 * ratio * ratio * sin * cos / theta.cos();
    let reflectance = dielectric_reflectance(cos, 1.5);
    let (place, place_slope, turned, turned_slope, share) = if let Some(k) = inside {
        let refracted = (sin / 1.5).asin();
        let slope = cos / (1.5 * refracted.cos());
        let k = f64::from(k);
        (
            incidence - theta + (k + 1.0) * (PI - 2.0 * refracted),
            1.0 - theta_slope - 2.0 * (k + 1.0) * slope,
            theta - 2.0 * (incidence - refracted) - k * (PI - 2.0 * refracted),
            theta_slope - 2.0 * (1.0 - slope) + 2.0 * k * slope,
            (1.0 - reflectance).powi(2) * reflectance.powf(k),
        )
    } else {
        (
            incidence - theta,
            1.0 - theta_slope,
            theta + PI - 2.0 * incidence,
            theta_slope - 2.0,
            reflectance,
        )
    };
    let (sin_place, cos_place) = place.sin_cos();
    let (sin_turned, cos_turned) = turned.sin_cos();
    if cos_turned < 1e-9 {
        return None;
    }
    let tangent = sin_turned / cos_turned;
    let height = 1.4 + cos_place;
    let radius = sin_place + height * tangent;
    let slope = cos_place * place_slope - sin_place * place_slope * tangent
        + height * turned_slope / (cos_turned * cos_turned);
    Some([radius, slope, flux * share])
}

/// All preimages of a point at `distance` from the axis: r = ±distance, E = dΦ/di / (2π r |dr/di|).
fn ball_preimages(distance: f64, inside: Option<u32>) -> Vec<Preimage> {
    [distance, -distance]
        .into_iter()
        .flat_map(|wanted| {
            sign_changes(1e-9, FRAC_PI_2 - 1e-9, 100_000, 1.0, |i| {
                Some(ball_map(i, inside)?[0] - wanted)
            })
        })
        .map(|i| {
            let [_, slope, flux] = ball_map(i, inside).unwrap();
            Preimage {
                irradiance: flux / (TAU * distance * slope.abs()),
                slope: slope.abs(),
            }
        })
        .collect()
}

/// Roots are right to a few ulp of the scene's size (4), which moves a slope of size s by 4 ulp · r''/s² of
/// itself; with r'' below 10, 1e-15 · 4 · 10 · 4 / s² stays below 1e-10 down to s = 0.04.
const STEEP_ENOUGH: f64 = 0.04;

#[test]
fn a_probe_of_the_ball_finds_every_preimage_and_its_irradiance() {
    let scene = bundled("glass-ball", 16);
    let fold = GlassBall::SHIPPED.sheet(KnownPath::Through(0)).fold_radii()[0];
    let mut three = 0;
    let mut one = 0;
    for number in 0..12 {
        let radius = 0.03 + 0.155 * f64::from(number);
        let probed = probe_at(&scene, 2.0, around(radius, number), 4);
        assert_eq!(probed.unresolved, 0, "r = {radius}");
        for (signature, inside) in [
            ("LRD", None),
            ("LTTD", Some(0)),
            ("LTRTD", Some(1)),
            ("LTRRTD", Some(2)),
        ] {
            let exact = ball_preimages(radius, inside);
            let paths = of(&probed, signature);
            assert_eq!(paths.len(), exact.len(), "{signature} at r = {radius}");
            if exact.iter().any(|preimage| preimage.slope < STEEP_ENOUGH) {
                continue;
            }
            let expected: f64 = exact.iter().map(|preimage| preimage.irradiance).sum();
            let found = sum(&paths);
            assert!(
                exact.is_empty() || (found / expected - 1.0).abs() < 1e-10,
                "{signature} at r = {radius}: {found} for {expected}"
            );
            if signature == "LTTD" {
                three += u32::from(paths.len() == 3 && radius < fold);
                one += u32::from(paths.len() == 1 && radius > fold);
                // The sheet turns over at the fold: with three preimages, one is of the other side.
                let turned = paths.iter().filter(|path| path.folded).count();
                assert!(paths.len() < 3 || turned == 1, "{turned} of 3 are folded");
            }
        }
    }
    assert!(three >= 1 && one >= 1, "{three} inside, {one} outside");
}

#[test]
fn the_balls_shadow_is_dark_and_direct_light_obeys_the_inverse_square() {
    let scene = bundled("glass-ball", 16);
    let shadow = GlassBall::SHIPPED.shadow_radius();
    for (radius, lit) in [(shadow * 0.999, false), (shadow * 1.001, true)] {
        let probed = probe_at(&scene, 2.0, around(radius, 3), 0);
        let direct = of(&probed, "LD");
        assert_eq!(direct.len(), usize::from(lit), "r = {radius}");
        if lit {
            let expected = 100.0 * 4.0 / (16.0 + radius * radius).powf(1.5);
            // A dozen roundings.
            assert!((sum(&direct) / expected - 1.0).abs() < 1e-14);
            assert!(!direct[0].folded);
        }
    }
}

#[test]
fn across_the_balls_fold_two_preimages_are_born_and_the_distance_to_it_is_known() {
    let scene = bundled("glass-ball", 16);
    let fold = GlassBall::SHIPPED.sheet(KnownPath::Through(0)).fold_radii()[0];
    for distance in [1e-2, 1e-4, 1e-6, 1e-8] {
        let inside = probe_at(&scene, 2.0, around(fold - distance, 5), 2);
        let outside = probe_at(&scene, 2.0, around(fold + distance, 5), 2);
        let (three, one) = (of(&inside, "LTTD"), of(&outside, "LTTD"));
        assert_eq!((three.len(), one.len()), (3, 1), "{distance} from the fold");
        let mut near: Vec<f64> = three.iter().filter_map(|path| path.fold_distance).collect();
        near.sort_by(f64::total_cmp);
        for found in &near[..2] {
            // r(i) = r_f + r''/2 (i − i_f)² + r'''/6 (i − i_f)³: the estimate is off by r''' (i − i_f) / r''
            // of itself, with i − i_f = √(2 d / r''); r'' is about 2 and r''' about 5 here, so by some 2.5
            // √d. The point's own place is rounded to 1e-15 of d.
            let bound = 5.0 * distance.sqrt() + 1e-15 / distance;
            assert!(
                (found / distance - 1.0).abs() < bound,
                "{found} for {distance}"
            );
        }
    }
}

/// (tan α, R, H, E cos α) of the scene `coffee-cup`, as its file says.
const TAN: f64 = 0.6;
const RADIUS: f64 = 4.0;
const HEIGHT: f64 = 8.0;

/// All preimages by one reflection of a point of the cup's bottom: E = E₀ cos α · R cos φ / |R cos φ − 2τ|.
fn cup_preimages(at: DVec2) -> Vec<Preimage> {
    let wall = |azimuth: f64| RADIUS * DVec2::from_angle(azimuth);
    let along = |azimuth: f64| -DVec2::from_angle(2.0 * azimuth);
    let beside = |azimuth: f64| Some(along(azimuth).perp_dot(at - wall(azimuth)));
    sign_changes(-FRAC_PI_2, FRAC_PI_2, 100_000, 1.0, beside)
        .into_iter()
        .filter_map(|azimuth| {
            let left = (at - wall(azimuth)).dot(along(azimuth));
            let chord = 2.0 * RADIUS * azimuth.cos();
            // The horizontal length of light from the opening, H tan α, ends here; it began within the
            // opening.
            let inside = HEIGHT * TAN - left;
            let is_lit = left > 0.0 && left < chord && inside > 0.0 && inside < chord;
            let width = RADIUS * azimuth.cos();
            let slope = (width - 2.0 * left).abs();
            let irradiance = 1000.0 / 1.0_f64.hypot(TAN) * width / slope;
            is_lit.then_some(Preimage { irradiance, slope })
        })
        .collect()
}

#[test]
fn a_probe_of_the_cup_finds_the_nephroids_one_or_three_preimages() {
    let scene = bundled("coffee-cup", 16);
    let mut counts = [0; 4];
    for number in 0..48 {
        let at = around(3.9 * ((f64::from(number) + 0.5) / 48.0).sqrt(), number);
        let exact = cup_preimages(at);
        let probed = probe_at(&scene, RADIUS, at, 2);
        let paths = of(&probed, "LRD");
        assert_eq!(paths.len(), exact.len(), "{at}");
        counts[paths.len()] += 1;
        let expected: f64 = exact.iter().map(|preimage| preimage.irradiance).sum();
        // Lengths of 8 are right to 1e-15 of themselves, slopes to 1e-14 / slope.
        if exact.iter().all(|preimage| preimage.slope > 1e-3) && !exact.is_empty() {
            let found = sum(&paths);
            assert!(
                (found / expected - 1.0).abs() < 1e-10,
                "{at}: {found} for {expected}"
            );
        }
    }
    // No point has more than three; the sample holds points of both sides of the nephroid.
    assert!(counts[1] > 5 && counts[3] > 2, "{counts:?}");
}

#[test]
fn a_texel_of_photons_agrees_with_the_mean_of_probes() {
    const SIDE: usize = 128;
    let scene = bundled("glass-ball", SIDE);
    // Within the fold, away from it and from the axis: three sheets, all of them smooth over the texel.
    let (column, row) = (68, 67);
    let estimate = Photons::new(1 << 22).estimate(&scene);
    // Gauss's points of a texel, on [−1, 1]; the rule is exact for polynomials of degree 5 in each direction.
    let gauss = [
        (-0.6_f64.sqrt(), 5.0 / 18.0),
        (0.0, 4.0 / 9.0),
        (0.6_f64.sqrt(), 5.0 / 18.0),
    ];
    let size = 4.0 / SIDE as f64;
    for signature in ["LTTD"] {
        let mut mean = 0.0;
        for (x, wx) in gauss {
            for (y, wy) in gauss {
                let middle = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                let at = (middle + 0.5 * DVec2::new(x, y)) * size - 2.0;
                mean += wx * wy * sum(&of(&probe_at(&scene, 2.0, at, 2), signature));
            }
        }
        let (values, errors) = support::scenes::layer(&estimate, signature, 0);
        let (value, error) = (values[row * SIDE + column], errors[row * SIDE + column]);
        // Student's t of 31 degrees of freedom exceeds 5 once in 50 000 tries; the quadrature's error is
        // below 1e-4 of the mean (the irradiance changes by a few percent over the texel, its fifth power is
        // 1e-7).
        assert!(
            (value - mean).abs() < 5.0 * error + 1e-4 * mean,
            "{signature}: {value} ± {error}, probes say {mean}"
        );
        assert!(
            mean > 0.0 && error < 0.1 * mean,
            "{signature}: {mean} ± {error} decides nothing"
        );
    }
}
