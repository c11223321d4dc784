//! All light in one place, or almost none: foci, folds on texel edges, grazing receivers (docs/accuracy.md, 8).

mod support;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;

use nephroid::reference::closed_form::{GlassBall, ParabolicMirror, Path, TexelGrid};
use nephroid::reference::{Estimate, Layer, LayerName};
use nephroid::scene::Scene;
use support::beams::{beams, held};
use support::bundled_file;
use support::scenes::{Photons, loaded, over_floor};

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
            .map(|at| layer.irradiance[at].0[0] * texel)
            .sum()
    };
    (flux(true), flux(false))
}

/// What a perfect dish sends to its focus. Ours is a mesh: its rim is a polygon of n = 168 sides, which has (2π/n)²/6 less area
/// than its circle, and its faces reflect at slightly other angles (of an aluminium's reflectance that changes by 1e-3 over
/// all angles here, so by less than a tenth of that).
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

/// The faces' sag, h²/8R with edges h of 1.8 cm on a radius of 1 m, is 4e-5 m: so large is the spot, and a texel is 2.5 mm. A single
/// texel, the middle one of 65, the four about a corner of 64: they have it all, and nobody else has any.
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
            // Photons are drawn by lot: four standard errors of random points, √((1 − p)/(p n)) with the quarter p of the light
            // that arrives. Sobol' points do better.
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
        let sum = |values: &[nephroid::radiometry::Rgb]| {
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

/// Where light folds, irradiance is infinite: on circles, here, which four lines between texels touch, to the last bit and
/// 1e-9 m on either side. Bounds must hold in every texel, and the true error be what was asked for.
///
/// A sheet of the ball is known to 1e-9 of its brightest texel (`tests/support/oracles.rs`).
#[test]
fn bounds_hold_where_a_fold_touches_a_line_between_texels() {
    const SIDE: usize = 64;
    let mut faults = String::new();
    let mut judged = 0;
    for (path, line) in [(Path::Through(0), 9), (Path::Through(0), 23)] {
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

/// Sunlight that comes in at this elevation \[rad\] above the floor, through a pane that it meets at right angles.
///
/// Four facts make it a closed form: at normal incidence each side of the pane (n = 1.5) lets 24/25 through, the light goes on straight,
/// the pane's light covers the whole floor, and E = E0 sin α.
fn grazing(elevation: f64) -> Scene {
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
    over_floor(folder.path(), &things, 8)
}

/// Of a thin pane, reflections within included: (1 − R)/(1 + R) with R = 1/25.
const THIN_PANE: f64 = 24.0 / 26.0;

/// Each texel gets the same, E0 T sin α. Beams drop polygons below 1e-15 of the pane, which is 36 m²: each takes 36e-15/(1/16) of E0
/// from a texel, and a texel has no more than four corners for such. A height is rounded some 64 times by u of the pane's 6 m, of
/// the 2 m sin α that the floor is high, seen from the sun: 64 · 3 u E0. All other error is relative.
#[test]
fn a_floor_almost_edge_on_to_the_light_gets_its_sine_by_beams() {
    let absolute = 1000.0 * (4.0 * 36e-15 * 16.0 + 64.0 * 3.0 * f64::EPSILON / 2.0);
    for elevation in [0.3, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        let (estimate, _) = beams(&grazing(elevation), 1e-3);
        let expected = 1000.0 * elevation.sin() * THIN_PANE;
        let worst = estimate
            .total
            .irradiance
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

/// Direct light is no sample's matter: each point of a texel has E0 sin α, at any elevation down to none. The sine is that of
/// a normalised direction (four roundings), averaged over points of a texel.
#[test]
fn direct_light_on_a_floor_edge_on_is_its_sine_to_rounding() {
    for elevation in [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0] {
        let (estimate, _) = beams(&sun(elevation), 1e-2);
        let expected = 1000.0 * elevation.sin();
        for value in &estimate.total.irradiance {
            assert!(
                (value.0[0] - expected).abs() <= 8.0 * f64::EPSILON * expected,
                "{elevation:e}: {} against {expected}",
                value.0[0]
            );
        }
    }
}
