//! All light in one place, or almost none: foci, folds on texel edges, grazing and touching receivers
//! (docs/accuracy.md, 8).

use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write as _;
use std::fs;

use nephroid::internals::numeric::quadrature::GaussLegendre;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::reference::closed_form::{
    AxialLight, GlassBall, KnownPath, ParabolicMirror, TexelGrid,
};
use nephroid::internals::run::{Estimate, Layer, LayerName};
use nephroid::internals::scene::Scene;

use crate::support::beams::{beams, held};
use crate::support::bundled_file;
use crate::support::scenes::{Photons, loaded, over_floor};

fn layer<'a>(estimate: &'a Estimate, name: &str) -> &'a Layer {
    let name = LayerName::Path(name.parse().unwrap());
    let found = estimate.layers.iter().find(|layer| layer.name == name);
    found.unwrap_or_else(|| panic!("there is no layer {name:?}"))
}

/// The dish's focus.
const FOCUS: f64 = 0.5;
/// Photons sent to the dish.
const PHOTONS: u64 = 1 << 18;
/// Half the receiver's width \[m\].
const HALF_WIDTH: f64 = 0.08;

/// The scene `parabolic-mirror` with its receiver right in the focus.
fn focus(side: usize) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("focus.xml");
    let text = fs::read_to_string(bundled_file("parabolic-mirror")).unwrap();
    let moved = text.replace(r#"<translate z="0.45"/>"#, r#"<translate z="0.5"/>"#);
    assert_ne!(text, moved);
    fs::write(&file, moved).unwrap();
    let mesh = "parabolic-mirror.ply";
    fs::copy(
        bundled_file("parabolic-mirror").with_file_name(mesh),
        folder.path().join(mesh),
    )
    .unwrap();
    loaded(&file, side)
}

/// The flux \[W\] in the brightest texels, and in all others, of the light that the dish mirrors, in red.
fn gathered(side: usize, layer: &Layer, brightest: &[usize]) -> (f64, f64) {
    let texel = (2.0 * HALF_WIDTH / side as f64).powi(2);
    let flux = |chosen: bool| {
        (0..side * side)
            .filter(|texel| brightest.contains(texel) == chosen)
            .map(|at| layer.values[at].0[0] * texel)
            .sum()
    };
    (flux(true), flux(false))
}

/// Flux that a perfect dish sends to its focus. Ours is a mesh: its rim is a polygon of n = 168 sides, which
/// has (2π/n)²/6 less area than its circle, and its faces reflect at slightly other angles (of an aluminium's
/// reflectance that changes by 1e-3 over all angles here, so by less than a tenth of that).
fn gathered_in_closed_form() -> (f64, f64) {
    let dish = ParabolicMirror {
        focal_length: FOCUS,
        aperture: 0.5,
        receiver_height: 0.45,
        irradiance: 1000.0,
        shade_half_width: HALF_WIDTH,
        eta: 1.66,
        k: 9.22,
    };
    let flux = dish.received_flux();
    (flux, flux * ((TAU / 168.0).powi(2) / 6.0 + 1e-4))
}

/// The faces' sag, h²/8R with edges h of 1.8 cm on a radius of 1 m, is 4e-5 m: so large is the spot, and a
/// texel is 2.5 mm. A single texel, the middle one of 65, the four about a corner of 64: they have it all,
/// and nobody else has any.
#[test]
fn a_dish_gathers_all_its_light_in_one_texel() {
    let (expected, allowed) = gathered_in_closed_form();
    for side in [1, 64, 65] {
        let scene = focus(side);
        let middle = side / 2;
        let brightest: Vec<usize> = if side == 64 {
            [middle - 1, middle]
                .iter()
                .flat_map(|row| [middle - 1, middle].map(|column| row * side + column))
                .collect()
        } else {
            vec![middle * side + middle]
        };
        let (by_beams, _) = beams(&scene, 1e-3);
        let by_photons = Photons::new(PHOTONS).estimate(&scene);
        for (method, estimate) in [("beams", &by_beams), ("photons", &by_photons)] {
            let (there, elsewhere) = gathered(side, layer(estimate, "LRD"), &brightest);
            println!(
                "{side} x {side}, {method}: {there:.6} W in the focus, {elsewhere:.1e} W elsewhere; {expected:.6} W expected"
            );
            assert_eq!(elsewhere, 0.0, "{side} {method}");
            // Photons are drawn by lot: four standard errors of random points, √((1 − p)/(p n)) with the
            // quarter p of the light that arrives. Sobol' points do better.
            let drawn = if method == "photons" {
                4.0 * expected * (3.0 / PHOTONS as f64).sqrt()
            } else {
                0.0
            };
            assert!(
                (there - expected).abs() <= allowed + drawn,
                "{side} {method}: {there} against {expected} ± {allowed}"
            );
        }
        // The bounds know it, and know the dark.
        let bounds = layer(&by_beams, "LRD").interval.as_ref().unwrap();
        let area = (2.0 * HALF_WIDTH / side as f64).powi(2);
        let sum = |values: &[nephroid::internals::radiometry::Rgb]| {
            values.iter().map(|value| value.0[0] * area).sum::<f64>()
        };
        let (low, high) = (sum(&bounds.low), sum(&bounds.high));
        assert!(
            low - allowed <= expected && expected <= high + allowed,
            "{low}..{high} against {expected}"
        );
    }
}

/// The scene `glass-ball` over a receiver of another half width \[m\].
fn ball_over(half_width: f64, side: usize) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.xml");
    let text = fs::read_to_string(bundled_file("glass-ball")).unwrap();
    let wider = format!(r#"<scale x="{half_width:e}" y="{half_width:e}"/>"#);
    let changed = text.replace(r#"<scale x="2" y="2"/>"#, &wider);
    assert_ne!(text, changed);
    fs::write(&file, changed).unwrap();
    loaded(&file, side)
}

/// Where light folds, irradiance is infinite: on circles, here, which four lines between texels touch, to the
/// last bit and 1e-9 m on either side. Bounds must hold in every texel, and the true error be what was asked
/// for.
///
/// A sheet of the ball is known to 1e-9 of its brightest texel (`tests/support/oracles.rs`).
#[test]
fn bounds_hold_where_a_fold_touches_a_line_between_texels() {
    const SIDE: usize = 64;
    let mut faults = String::new();
    let mut judged = 0;
    for (path, line) in [(KnownPath::Through(0), 9), (KnownPath::Through(0), 23)] {
        let sheet = GlassBall::SHIPPED.sheet(path);
        for fold in sheet.fold_radii() {
            for beside in [0.0, 1e-9, -1e-9] {
                let half_width = (SIDE / 2) as f64 * (fold + beside) / f64::from(line);
                let scene = ball_over(half_width, SIDE);
                let map = sheet.map(&TexelGrid::square(half_width, SIDE));
                let accuracy = 1e-9 * map.iter().copied().fold(0.0, f64::max);
                let [low, high] = [-accuracy, accuracy]
                    .map(|by| map.iter().map(|value| value + by).collect::<Vec<_>>());
                for error in [1e-2, 1e-3] {
                    let (estimate, _) = beams(&scene, error);
                    let held = held(layer(&estimate, &path.signature()), &low, &high);
                    judged += held.lit;
                    println!(
                        "{path:?} folds at {fold:.6} m {beside:+.0e}, on line {line}; asked {error:e}: {} of {} texels out of bounds, by {:.1e} of the mean; true {:.1e}",
                        held.missed, held.lit, held.worst, held.rmse
                    );
                    assert!(
                        held.rmse <= error,
                        "{path:?} {fold} {beside:e} {error:e}: {held:?}"
                    );
                    if held.missed > 0 {
                        writeln!(faults, "{path:?} {fold} {beside:e} {error:e}: {held:?}").unwrap();
                    }
                }
            }
        }
    }
    assert!(judged > 10_000, "{judged}");
    assert!(faults.is_empty(), "{faults}");
}

/// Light straight down on a glass rod of this radius along y, whose axis is 1.4 radii above the floor: E0 =
/// 1000 W/m².
///
/// In the plane across the rod, a ray that meets it at the incidence i (i > 0: x > 0) is bent by i − t there
/// and again where it leaves, at π − (i + π − 2t) from below. It lands at
///
/// ```text
/// x = R sin(2t − i) − (h − R cos(2t − i)) tan 2(i − t),   sin t = sin i / n
/// ```
///
/// with (1 − F)² E0 R cos i di of the flux for a unit of length.
struct Rod {
    radius: f64,
}

impl Rod {
    const INDEX: f64 = 1.5;
    const IRRADIANCE: f64 = 1000.0;

    fn landing(&self, incidence: f64) -> f64 {
        let inside = (incidence.sin() / Self::INDEX).asin();
        let (sin, cos) = (2.0 * inside - incidence).sin_cos();
        let height = self.radius * (1.4 - cos);
        self.radius * sin - height * (2.0 * (incidence - inside)).tan()
    }

    /// The incidence where light folds: where dx/di = 0, by golden sections.
    fn fold(&self) -> f64 {
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        // Far out, light leaves upward or flat; the sign says which end the fold is.
        let (mut low, mut high) = (0.0, 1.2);
        while high - low > 1e-9 {
            let [a, b] = [high - golden * (high - low), low + golden * (high - low)];
            if self.landing(a) > self.landing(b) {
                high = b;
            } else {
                low = a;
            }
        }
        0.5 * (low + high)
    }

    /// Irradiance of columns of texels between the lines `x`, averaged.
    fn columns(&self, lines: &[f64]) -> Vec<f64> {
        let rule = GaussLegendre::new(24).unwrap();
        let share = |incidence: f64| {
            let passed = 1.0 - dielectric_reflectance(incidence.cos(), Self::INDEX);
            Self::IRRADIANCE * self.radius * incidence.cos() * passed * passed
        };
        let fold = self.fold();
        // To the fold it goes one way, and back beyond it; light that leaves upward does not land.
        let flat = FRAC_PI_2 - 1e-12;
        let branches = [(0.0, fold), (fold, self.last_down(fold, flat))];
        let flux_between = |low: f64, high: f64| {
            let of_branch = |&(from, to): &(f64, f64)| {
                let [a, b] = [low, high].map(|line| self.incidence_at(line, from, to));
                let (a, b) = (a.min(b), a.max(b));
                // In tenths: F has its whole rise in the last few degrees.
                (0..10)
                    .map(|part| {
                        let at = |part: f64| a + (b - a) * part / 10.0;
                        rule.integrate(at(f64::from(part)), at(f64::from(part) + 1.0), share)
                    })
                    .sum::<f64>()
            };
            branches.iter().map(of_branch).sum::<f64>()
        };
        // Of light that meets the other half of the rod, the mirror image.
        lines
            .windows(2)
            .map(|pair| {
                let flux = flux_between(pair[0], pair[1]) + flux_between(-pair[1], -pair[0]);
                flux / (pair[1] - pair[0])
            })
            .collect()
    }

    /// Up to where light leaves downward: 2(i − t) < π/2.
    fn last_down(&self, from: f64, to: f64) -> f64 {
        let is_down = |incidence: f64| {
            2.0 * (incidence - (incidence.sin() / Self::INDEX).asin()) < FRAC_PI_2 - 1e-9
        };
        bisected(from, to, is_down)
    }

    /// Where on a branch light lands at x, or the end of the branch that is nearer to it.
    fn incidence_at(&self, x: f64, from: f64, to: f64) -> f64 {
        let rises = self.landing(to) > self.landing(from);
        bisected(from, to, |incidence| (self.landing(incidence) < x) == rises)
    }
}

/// Where something ends that holds from `low` on, or `high`.
fn bisected(low: f64, high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (low, high);
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Two straight lines where irradiance is infinite run along columns of texels: on the line between two, to
/// the last bit, and 1e-9 m on either side: there the light of the fold's own strip, 1e-9 m wide, is in the
/// next column.
///
/// Incidences are known to 1e-9 at the fold, where light does not move with them, and to 1e-16 elsewhere; the
/// rule is exact to 1e-12 of a column.
#[test]
fn bounds_hold_where_a_fold_runs_along_a_line_between_texels() {
    const SIDE: usize = 32;
    let unit = Rod { radius: 1.0 };
    let reach = unit.landing(unit.fold()).abs();
    let (mut judged, mut faults) = (0, String::new());
    for line in [3, 10] {
        for beside in [0.0, 1e-9, -1e-9] {
            let at = f64::from(line) * 2.0 / SIDE as f64 + beside;
            let rod = Rod { radius: at / reach };
            let (radius, height) = (rod.radius, 1.4 * rod.radius);
            let things = format!(
                r#"<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/>
            <rgb name="irradiance" value="1000"/></emitter>
          <shape type="cylinder"><point name="p0" x="0" y="-2" z="{height:e}"/><point name="p1" x="0" y="2" z="{height:e}"/>
            <float name="radius" value="{radius:e}"/><ref id="glass"/></shape>"#
            );
            let folder = tempfile::tempdir().unwrap();
            let scene = over_floor(folder.path(), &things, SIDE);
            let lines: Vec<f64> = (0..=SIDE)
                .map(|line| 2.0 * line as f64 / SIDE as f64 - 1.0)
                .collect();
            let columns = rod.columns(&lines);
            let map: Vec<f64> = (0..SIDE * SIDE)
                .map(|texel| columns[texel % SIDE])
                .collect();
            let accuracy = 1e-9 * columns.iter().copied().fold(0.0, f64::max);
            let [low, high] = [-accuracy, accuracy]
                .map(|by| map.iter().map(|value| value + by).collect::<Vec<_>>());
            // Beside the line at one error only: time.
            for &error in &[1e-2, 1e-3][..if beside == 0.0 { 2 } else { 1 }] {
                let (estimate, _) = beams(&scene, error);
                let held = held(layer(&estimate, "LTTD"), &low, &high);
                judged += held.lit;
                println!(
                    "a rod's fold on line {line} {beside:+.0e}; asked {error:e}: {} of {} texels out of bounds, by {:.1e} of the mean; true {:.1e}",
                    held.missed, held.lit, held.worst, held.rmse
                );
                // All rows are alike, and so are their errors: they do not average out. What is said of an
                // error is right within a factor of two (`docs/beams.md`).
                let said = estimate.relative_error.unwrap();
                assert!(said <= error, "{line} {beside:e} {error:e}: {said}");
                assert!(
                    held.rmse <= 2.0 * said,
                    "{line} {beside:e} {error:e}: {held:?}, said {said}"
                );
                if held.missed > 0 {
                    writeln!(faults, "{line} {beside:e} {error:e}: {held:?}").unwrap();
                }
            }
        }
    }
    assert!(judged > 2000, "{judged}");
    assert!(faults.is_empty(), "{faults}");
}

/// Gaps below a refractor \[m\].
const GAPS: [f64; 5] = [1e-12, 1e-9, 1e-6, 1e-3, 1e-1];

/// A sheet of the ball is known to 1e-9 of its brightest texel (`tests/support/oracles.rs`). At no gap at all
/// ball and floor share one point, and the closed form of a gap of 1e-12 is as good.
#[test]
fn a_floor_that_a_ball_touches_gets_the_balls_light() {
    const SIDE: usize = 32;
    for gap in [0.0, GAPS[0], GAPS[2], GAPS[4]] {
        let center = 1.0 + gap;
        let things = format!(
            r#"<emitter type="point"><point name="position" x="0" y="0" z="4"/><rgb name="intensity" value="100"/></emitter>
          <shape type="sphere"><point name="center" x="0" y="0" z="{center:?}"/><float name="radius" value="1"/><ref id="glass"/></shape>"#
        );
        let folder = tempfile::tempdir().unwrap();
        let scene = over_floor(folder.path(), &things, SIDE);
        let ball = GlassBall {
            radius: 1.0,
            center_height: 1.0 + gap.max(1e-12),
            ior: 1.5,
            light: AxialLight::Point {
                height: 4.0,
                intensity: 100.0,
            },
        };
        let map = ball
            .sheet(KnownPath::Through(0))
            .map(&TexelGrid::square(1.0, SIDE));
        let accuracy = 1e-9 * map.iter().copied().fold(0.0, f64::max);
        let [low, high] =
            [-accuracy, accuracy].map(|by| map.iter().map(|e| e + by).collect::<Vec<_>>());
        let (estimate, _) = beams(&scene, 1e-3);
        let held = held(layer(&estimate, "LTTD"), &low, &high);
        println!(
            "gap {gap:e}: {} of {} texels out of bounds; true error {:.1e}, asked 1e-3",
            held.missed, held.lit, held.rmse
        );
        assert!(held.lit > 100, "{gap:e}: {held:?}");
        assert_eq!(held.missed, 0, "{gap:e}: {held:?}");
        assert!(held.rmse <= 1e-3, "{gap:e}: {held:?}");
    }
}

/// Straight down through a slab wider than the floor: (1 − F)² F^k E0 in every texel, F = 1/25, whatever the
/// gap. Polygons are the whole slab's (16 m²), and a texel's corners are products of a few of its
/// coordinates: 64 roundings of u times 16 texels' widths. A film's quantum is 2^-60 of at most 2^14 W.
/// Deposits are off by half of it, 1.1e-13 W/m² in a texel of 1/16 m², which gets some dozens.
#[test]
fn a_floor_under_a_slab_gets_its_light_whatever_the_gap() {
    for gap in GAPS {
        let things = format!(
            r#"<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/><rgb name="irradiance" value="1000"/></emitter>
          <shape type="cube"><transform name="to_world"><translate z="1"/><scale x="2" y="2" z="0.25"/><translate z="{gap:?}"/></transform>
            <ref id="glass"/></shape>"#
        );
        let folder = tempfile::tempdir().unwrap();
        let scene = over_floor(folder.path(), &things, 8);
        let (estimate, _) = beams(&scene, 1e-3);
        let mut worst = 0.0_f64;
        for (name, reflections) in [("LTTD", 0), ("LTRRTD", 2)] {
            let expected = 1000.0 * 0.96 * 0.96 * 0.04_f64.powi(reflections);
            for value in &layer(&estimate, name).values {
                let off = (value.0[0] - expected).abs();
                worst = worst.max(off / expected);
                let allowed = 64.0 * 16.0 * f64::EPSILON * expected + 64.0 * 1.1e-13;
                assert!(off <= allowed, "{gap:e} {name}: {off:e}");
            }
        }
        println!("a slab {gap:e} m above the floor: off by {worst:.1e} at most");
    }
}

/// Sunlight that comes in at this elevation \[rad\] above the floor, through a pane that it meets at right
/// angles.
///
/// Four facts make it a closed form: at normal incidence each side of the pane (n = 1.5) lets 24/25 through,
/// the light goes on straight, the pane's light covers the whole floor, and E = E0 sin α.
fn grazing(elevation: f64, side: usize) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let (sin, cos) = elevation.sin_cos();
    let things = format!(
        r#"<emitter type="directional"><vector name="direction" x="{cos:e}" y="0" z="{:e}"/>
            <rgb name="irradiance" value="1000"/></emitter>
          <shape type="rectangle"><transform name="to_world">
            <scale x="3" y="3"/><lookat origin="{:e}, 0, {:e}" target="0, 0, 0" up="0, 1, 0"/></transform>
            <bsdf type="thindielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>"#,
        -sin,
        -6.0 * cos,
        6.0 * sin,
    );
    over_floor(folder.path(), &things, side)
}

/// Of a thin pane, reflections within included: (1 − R)/(1 + R) with R = 1/25.
const THIN_PANE: f64 = 24.0 / 26.0;

/// Each texel gets the same, E0 T sin α. Beams drop polygons below 1e-15 of the pane, which is 36 m²: each
/// takes 36e-15/(1/16) of E0 from a texel, and a texel has no more than four corners for such. A height is
/// rounded some 64 times by u of the pane's 6 m, of the 2 m sin α that the floor is high, seen from the sun:
/// 64 · 3 u E0. All other error is relative.
#[test]
fn a_floor_almost_edge_on_to_the_light_gets_its_sine_by_beams() {
    let absolute = 1000.0 * (4.0 * 36e-15 * 16.0 + 64.0 * 3.0 * f64::EPSILON / 2.0);
    for elevation in [0.3, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        let (estimate, _) = beams(&grazing(elevation, 8), 1e-3);
        let expected = 1000.0 * elevation.sin() * THIN_PANE;
        let worst = estimate
            .total
            .values
            .iter()
            .map(|value| (value.0[0] - expected).abs())
            .fold(0.0, f64::max);
        println!(
            "elevation {elevation:e}: {expected:.3e} W/m² expected, off by {worst:.1e} at most"
        );
        assert!(
            worst <= absolute + 1e-12 * expected,
            "{elevation:e}: {worst:e}"
        );
    }
}

/// By photons, as many as land: E0 T sin α to 5 standard errors where some dozens do; the floor is 4 sin α of
/// the 36 m² that light is sent to. With 31 degrees of freedom, one run in 50,000 is farther off. Where none
/// lands, the count says that 0 ± 0 is no darkness.
#[test]
fn a_floor_almost_edge_on_to_the_light_gets_its_sine_by_photons_or_says_that_none_came() {
    let (mut measured, mut none) = (0, 0);
    for elevation in [0.3, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        let estimate = Photons::new(PHOTONS).estimate(&grazing(elevation, 1));
        let expected = 1000.0 * elevation.sin() * THIN_PANE;
        let (found, error) = (
            estimate.total.values[0].0[0],
            estimate.total.standard_error[0].0[0],
        );
        let landed = estimate.counts[0];
        let likely = PHOTONS as f64 * THIN_PANE * 4.0 * elevation.sin() / 36.0;
        println!(
            "elevation {elevation:e}: {found:.3e} ± {error:.1e} W/m², {landed} photons; {expected:.3e} expected, of {likely:.0} photons"
        );
        if landed == 0 {
            none += 1;
            assert_eq!((found, error), (0.0, 0.0), "{elevation:e}");
            // e^-20
            assert!(likely < 20.0, "{elevation:e}");
        } else if likely >= 24.0 {
            measured += 1;
            assert!(
                error > 0.0 && (found - expected).abs() <= 5.0 * error,
                "{elevation:e}"
            );
        }
    }
    assert!(measured >= 3 && none >= 3, "{measured} {none}");
}

/// Sunlight on the bare floor.
fn sun(elevation: f64) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let (sin, cos) = elevation.sin_cos();
    let emitter = format!(
        r#"<emitter type="directional"><vector name="direction" x="{cos:e}" y="0" z="{:e}"/>
            <rgb name="irradiance" value="1000"/></emitter>"#,
        -sin
    );
    over_floor(folder.path(), &emitter, 4)
}

/// Direct light is no sample's matter: each point of a texel has E0 sin α, at any elevation down to none. The
/// sine is that of a normalised direction (four roundings), averaged over points of a texel.
#[test]
fn direct_light_on_a_floor_edge_on_is_its_sine_to_rounding() {
    for elevation in [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0] {
        let (estimate, _) = beams(&sun(elevation), 1e-2);
        let expected = 1000.0 * elevation.sin();
        for value in &estimate.total.values {
            assert!(
                (value.0[0] - expected).abs() <= 8.0 * f64::EPSILON * expected,
                "{elevation:e}: {} against {expected}",
                value.0[0]
            );
        }
    }
}
