use std::f64::consts::TAU;

use super::*;
use crate::numeric::math;
use crate::numeric::rotation;
use crate::reference::closed_form::circle::{circle_fraction, corner_radii};
use crate::reference::closed_form::quadrature::integrate;

/// The bundled scene `coffee-cup`.
const CUP: MirrorCup = MirrorCup {
    radius: 0.04,
    height: 0.08,
    reflectance: 1.0,
    light: CupLight::Parallel {
        tan_angle: 0.6,
        irradiance: 1000.0,
    },
};

/// The bundled scene `mirror-ring`.
const RING: MirrorCup = MirrorCup {
    radius: 0.01,
    height: 0.006,
    reflectance: 1.0,
    light: CupLight::Point {
        distance: 0.01,
        height: 0.01,
        intensity: 0.001,
    },
};

/// Lights inside, on and outside of the circle, and parallel light.
fn cups() -> [MirrorCup; 4] {
    let point = |distance| CupLight::Point {
        distance,
        height: 0.01,
        intensity: 0.001,
    };
    [
        CUP,
        RING,
        MirrorCup {
            light: point(0.004),
            ..RING
        },
        MirrorCup {
            light: point(0.03),
            ..RING
        },
    ]
}

#[test]
fn what_enters_is_spread_over_the_reflections() {
    for cup in cups() {
        let bottom: f64 = (0..100).map(|k| cup.bottom_flux(k)).sum();
        // Only light that nearly grazes the wall is reflected more often: chords below 1/100 of the way
        // inside (here at most 4.2 R), so cos φ < 0.021, and ∫ R cos φ c dφ is 4/(3π) cos³ φ < 4e-6 of the
        // opening's, times up to 2 for the unevenness of a near point light.
        let entering = cup.entering_flux();
        assert!(
            bottom < entering * (1.0 + 1e-9) && bottom > entering * (1.0 - 8e-6),
            "{cup:?} {bottom} {entering}"
        );
    }
    let exact = PI * 0.0016 * 1000.0 / 1.36_f64.sqrt();
    assert!((CUP.entering_flux() / exact - 1.0).abs() < 1e-14);
}

#[test]
fn texels_over_the_bottom_sum_to_its_flux() {
    for cup in cups() {
        let grid = TexelGrid::square(cup.radius, 24);
        let texel_area = grid.texel(0, 0).area();
        for k in 1..4 {
            let sum: f64 = cup.map(KnownPath::Reflected(k), &grid).iter().sum::<f64>() * texel_area;
            let flux = cup.bottom_flux(k);
            let scale = cup.unshaded_irradiance() * cup.radius * cup.radius;
            // At most some 50 windows a texel with 1e-9 of its unshaded flux each.
            assert!(
                (sum - flux).abs() < 1e-6 * scale,
                "{cup:?} {k}: {sum} {flux}"
            );
        }
    }
}

#[test]
fn after_one_reflection_the_irradiance_is_the_spreading_of_a_pencil() {
    // E = E0 cos α · R cos φ / |R cos φ - 2 τ| at the point τ behind the hit at φ, away from the nephroid,
    // where no other sheet lands.
    let (azimuth, behind) = (0.9_f64, 0.004);
    let point =
        0.04 * rotation::direction(azimuth) + rotation::direction(PI + 2.0 * azimuth) * behind;
    let half = 1e-6;
    let texel = TexelRect::new(
        point.x - half,
        point.y - half,
        point.x + half,
        point.y + half,
    );
    let width = 0.04 * math::cos(azimuth);
    let exact = 1000.0 / 1.36_f64.sqrt() * width / (width - 2.0 * behind).abs();
    let irradiance = CUP.texel_irradiance(KnownPath::Reflected(1), &texel);
    // The mean over the texel differs at second order: (half / 0.01)² ~ 1e-8.
    assert!(
        (irradiance / exact - 1.0).abs() < 1e-6,
        "{irradiance} {exact}"
    );
}

#[test]
fn on_the_nephroid_a_texel_is_the_brighter_the_smaller_it_is() {
    let azimuth = 0.5;
    let point = MirrorCup::parallel_caustic(0.04, 1, azimuth);
    let expected = DVec2::new(
        3.0 * math::cos(azimuth) - math::cos(3.0 * azimuth),
        3.0 * math::sin(azimuth) - math::sin(3.0 * azimuth),
    ) * 0.01;
    assert!(point.distance(expected) < 1e-16);
    let at = |half: f64| {
        let texel = TexelRect::new(
            point.x - half,
            point.y - half,
            point.x + half,
            point.y + half,
        );
        CUP.texel_irradiance(KnownPath::Reflected(1), &texel)
    };
    // A fold: E ~ 1/√distance, so a quarter of the size doubles the mean, up to the regular part beside it:
    // here about 10 % of the brighter one.
    let ratio = at(2.5e-6) / at(1e-5);
    assert!((1.8..2.05).contains(&ratio), "{ratio}");
}

#[test]
fn light_goes_past_a_cup_of_no_height() {
    for cup in cups() {
        let flat = MirrorCup { height: 0.0, ..cup };
        let texel = TexelRect::new(
            0.3 * cup.radius,
            -0.2 * cup.radius,
            0.5 * cup.radius,
            0.1 * cup.radius,
        );
        let irradiance = flat.texel_irradiance(KnownPath::Direct, &texel);
        let exact = match cup.light {
            CupLight::Parallel { .. } => cup.unshaded_irradiance(),
            CupLight::Point {
                distance,
                height,
                intensity,
            } => {
                let angle = |x: f64, y: f64| {
                    let x = x + distance;
                    math::atan(x * y / (height * (height * height + x * x + y * y).sqrt()))
                };
                let (min, max) = (texel.min, texel.max);
                let solid = angle(max.x, max.y) - angle(min.x, max.y) - angle(max.x, min.y)
                    + angle(min.x, min.y);
                intensity * solid / texel.area()
            }
        };
        assert!(
            (irradiance / exact - 1.0).abs() < 1e-6,
            "{cup:?} {irradiance} {exact}"
        );
    }
}

#[test]
fn direct_light_agrees_with_tracing_points_back() {
    for cup in cups() {
        for centre in [
            DVec2::new(0.9, 0.5),
            DVec2::new(1.6, 0.2),
            DVec2::new(-0.3, 1.3),
            DVec2::new(-1.2, 0.1),
        ] {
            let (centre, half) = (centre * cup.radius, 0.2 * cup.radius);
            let texel = TexelRect::new(
                centre.x - half,
                centre.y - half,
                centre.x + half,
                centre.y + half,
            );
            let side = 500;
            let grid = TexelGrid {
                bounds: texel,
                columns: side,
                rows: side,
            };
            let brute = grid
                .map(|small| lit(&cup, 0.5 * (small.min + small.max)))
                .iter()
                .sum::<f64>()
                / (side * side) as f64;
            let irradiance = cup.texel_irradiance(KnownPath::Direct, &texel);
            // A border of light crosses at most some 4 · 500 of the 250,000 cells; their errors of up to half
            // a cell have either sign, so an ordinary border errs by less than 1e-3.
            assert!(
                (irradiance - brute).abs() < 1e-3 * cup.unshaded_irradiance(),
                "{cup:?} {centre}"
            );
        }
    }
}

/// The direct irradiance at a point, by walking from it back to the light.
fn lit(cup: &MirrorCup, point: DVec2) -> f64 {
    let (towards, rise, irradiance) = match cup.light {
        CupLight::Parallel { tan_angle, .. } => (
            DVec2::NEG_X * (cup.height * tan_angle),
            cup.height,
            cup.unshaded_irradiance(),
        ),
        CupLight::Point {
            distance,
            height,
            intensity,
        } => {
            let back = DVec2::new(-distance, 0.0) - point;
            (
                back,
                height,
                intensity * height / math::powi(math::hypot(back.length(), height), 3),
            )
        }
    };
    // Roots of |point + s towards|² = R², each blocking below the rim.
    let (a, b) = (towards.length_squared(), point.dot(towards));
    let root = (b * b - a * (point.length_squared() - cup.radius * cup.radius)).sqrt();
    let blocked = [(-b - root) / a, (-b + root) / a]
        .iter()
        .any(|&s| s > 1e-12 && s < 1.0 - 1e-12 && s * rise < cup.height);
    if blocked { 0.0 } else { irradiance }
}

/// Texels of which a rim's shadow leaves a corner lit, ever less of it. The rim's shadow is the circle about
/// (d h/(h − H) − d, 0) of radius R h/(h − H). The corner's light is, independently, the sum over circles
/// beyond that one of what the texel holds of each.
#[test]
fn a_corner_that_a_shadow_leaves_lit_is_found_however_small() {
    let factor = 0.01 / (0.01 - RING.height);
    let (middle, rim) = (factor * 0.01 - 0.01, factor * RING.radius);
    let side = 8e-5;
    for (azimuth, depth) in [
        (1.9, 0.1),
        (2.3, 1e-2),
        (2.0, 3e-3),
        (2.6, 1e-3),
        (2.1, 1e-4),
    ] {
        let out = rotation::direction(azimuth);
        let corner = DVec2::new(middle, 0.0) + out * (rim + depth * side);
        // The corner of least x and largest y is the farthest from the circle's centre.
        let texel = TexelRect::new(corner.x, corner.y - side, corner.x + side, corner.y);
        let part = TexelRect::new(
            middle - texel.max.x,
            texel.min.y,
            middle - texel.min.x,
            texel.max.y,
        );
        let [near, .., far] = corner_radii(&part);
        let area = integrate(near.max(rim), far, 8, |radius| {
            TAU * radius * circle_fraction(radius, &part)
        });
        let distance = DVec2::new(corner.x + 0.01, corner.y).length();
        let unshaded = 0.001 * 0.01 / math::powi(math::hypot(distance, 0.01), 3);
        let exact = unshaded * area / texel.area();
        let found = RING.texel_irradiance(KnownPath::Direct, &texel);
        // The unshaded light varies by 3 side/distance over the texel, by less over the corner. The rest is
        // what the quadrature claims.
        let off = (found - exact).abs();
        assert!(
            off < 0.03 * depth * exact + 1e-8 * RING.unshaded_irradiance(),
            "{azimuth} {depth}: {found} {exact}"
        );
    }
}

/// The lamp is at 45° from the middle of these texels, two corners of which it therefore sees in one line.
/// The sum over the solid angle is exact.
#[test]
fn a_texel_that_is_seen_along_its_diagonal_has_all_of_its_light() {
    let side = 4.0 * RING.radius / 512.0;
    for (column, row) in [(173, 46), (174, 45), (82, 46), (81, 45), (150, 20)] {
        let low = DVec2::new(f64::from(column) - 256.0, f64::from(row)) * side;
        let texel = TexelRect::new(low.x, low.y, low.x + side, low.y + side);
        let found = RING.texel_irradiance(KnownPath::Direct, &texel);
        let angle = |x: f64, y: f64| {
            let x = x + 0.01;
            math::atan(x * y / (0.01 * (1e-4 + x * x + y * y).sqrt()))
        };
        let (min, max) = (texel.min, texel.max);
        let solid =
            angle(max.x, max.y) - angle(min.x, max.y) - angle(max.x, min.y) + angle(min.x, min.y);
        let exact = 0.001 * solid / texel.area();
        // What the quadrature claims; differences of angles lose 1e-16 of one over the texel's, 1e-5.
        assert!(
            (found - exact).abs() < 1e-8 * RING.unshaded_irradiance() + 1e-10 * exact,
            "{column} {row}: {found} {exact}"
        );
    }
}
