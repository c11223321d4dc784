//! Grazing, critical and normal incidence: where formulas of optics divide by what vanishes, or cancel.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Ray, TraversalCounters};
use nephroid::internals::optics::{dielectric_reflectance, reflect, refract};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::{Emitter, Scene};
use nephroid::internals::transport::chain::{Arrival, ChainSettings, ChainSink, ChainTracer};
use nephroid::internals::transport::flux::Flux;
use nephroid::internals::transport::followed::Followed;
use nephroid::internals::transport::ledger::Fate;
use nephroid::internals::transport::scatter::ShadingNormals;
use nephroid::internals::transport::signature::Signature;

use crate::support::chains::light;
use crate::support::extremes::double_double::{Exact, Exact3};
use crate::support::extremes::{U, beams, layer, photons, red, scene};

/// Water, glass, diamond and something optically very dense, entered and left.
const INDICES: [f64; 8] = [
    1.33,
    1.5,
    2.418,
    100.0,
    1.0 / 1.33,
    1.0 / 1.5,
    1.0 / 2.418,
    0.01,
];

/// (cos θᵢ, η) of a family of angles.
type Cases = Vec<(f64, f64)>;

/// Everything from perpendicular to 60 degrees off, in steps.
fn ordinary() -> Cases {
    let cosines = (1..=200).map(|i| f64::from(i) / 200.0);
    pairs(cosines, &INDICES)
}

/// From 84 degrees to 90 − 1e-12.
fn grazing() -> Cases {
    let cosines = (4..=56).map(|i| f64::powf(10.0, -f64::from(i) / 4.0));
    pairs(cosines, &INDICES)
}

/// Within 1e-1 ... 1e-12 rad of the critical angle, on the side where light passes.
fn critical() -> Cases {
    let mut cases = Cases::new();
    for eta in INDICES.into_iter().filter(|eta| *eta < 1.0) {
        for step in 4..=48 {
            let inside = f64::powf(10.0, -f64::from(step) / 4.0);
            cases.push(((eta.asin() - inside).cos(), eta));
        }
    }
    cases.retain(|&(cos, _)| cos <= 1.0);
    cases
}

/// Indices of 1 ± 1e-1 ... 1e-15.
fn nearly_matched() -> Cases {
    let away = (1..=15).flat_map(|i| {
        let step = f64::powi(10.0, -i);
        [1.0 + step, 1.0 - step]
    });
    let etas: Vec<f64> = away.collect();
    pairs((1..=50).map(|i| f64::from(i) / 50.0), &etas)
}

fn pairs(cosines: impl Iterator<Item = f64>, etas: &[f64]) -> Cases {
    cosines
        .flat_map(|cos| etas.iter().map(move |eta| (cos, *eta)))
        .collect()
}

fn families() -> [(&'static str, Cases); 4] {
    [
        ("ordinary angles", ordinary()),
        ("grazing, to 90° − 1e-12", grazing()),
        ("critical angle − 1e-12", critical()),
        ("η = 1 ± 1e-15", nearly_matched()),
    ]
}

/// F and cos² θₜ by the textbook's formula with twice the digits; `None` where light is reflected totally.
fn exact_reflectance(cos: f64, eta: f64) -> Option<(Exact, Exact)> {
    let (c, eta) = (Exact::from(cos), Exact::from(eta));
    let squared = (eta - Exact::ONE) * (eta + Exact::ONE) + c * c;
    if squared.value() <= 0.0 {
        return None;
    }
    let w = squared.sqrt();
    // (c − w)/(c + w), but for η = 1 ± 1e-15 that would lose 15 digits of 31.
    let s = (Exact::ONE - eta) * (Exact::ONE + eta) / ((c + w) * (c + w));
    let p = (eta * eta * c - w) / (eta * eta * c + w);
    Some((Exact::from(0.5) * (s * s + p * p), squared / (eta * eta)))
}

/// Most error of F, as a fraction of itself, for η from 1e-3 on: what single roundings took is given
/// back but for the last one, u, and for products of two. Those are some dozen u² of the terms, and a
/// hundredth of u covers them: where the terms of w² = (η − 1)(η + 1) + c² cancel down to u of themselves, w
/// is off by as many u, but F only by that times w/η², some 1e-8/η².
const LAST_ROUNDING: f64 = 1.01 * U;

/// The same formula, each operation rounded: what giving roundings back is good for.
fn plain_reflectance(cos: f64, eta: f64) -> f64 {
    let w = ((eta - 1.0) * (eta + 1.0) + cos * cos).sqrt();
    let s = (eta - 1.0) * (eta + 1.0) / ((cos + w) * (cos + w));
    let (along, across) = (w * cos, 1.0 - cos * cos);
    let p = s * (along - across) / (along + across);
    0.5 * (s * s + p * p)
}

#[test]
fn fresnels_reflectance_keeps_its_digits_at_every_angle_and_index() {
    println!("relative error of F: worst, in u; times cos² θt, in u; of the plain formula, in u");
    for (name, cases) in families() {
        let (mut worst, mut by_cos, mut of_plain) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (cos, eta) in cases {
            let found = dielectric_reflectance(cos, eta);
            let Some((exact, cos_squared)) = exact_reflectance(cos, eta) else {
                assert_eq!(found, 1.0, "{name}: cos {cos:e}, η {eta:e}");
                continue;
            };
            let off = exact.relative_error_of(found);
            assert!(
                off <= LAST_ROUNDING,
                "{name}: cos {cos:e}, η {eta:e}: {found:e} is off by {} u",
                off / U
            );
            worst = worst.max(off / U);
            by_cos = by_cos.max(off / U * cos_squared.value());
            of_plain = of_plain.max(exact.relative_error_of(plain_reflectance(cos, eta)) / U);
        }
        println!("  {name:26} {worst:9.3} {by_cos:9.3} {of_plain:9.3e}");
        // Near the critical angle the plain formula has lost half of all digits: giving roundings back is
        // needed.
        assert!(!name.starts_with("critical") || of_plain > 1e6);
    }
}

/// Within 40 last digits of the cosine's critical value: what is refracted, and only that, has its share.
#[test]
fn fresnels_reflectance_keeps_its_digits_to_the_last_light_that_passes() {
    let (mut passed, mut worst) = (0, 0.0_f64);
    for eta in INDICES.into_iter().filter(|eta| *eta < 1.0) {
        let critical = ((1.0 - eta) * (1.0 + eta)).sqrt();
        let (mut below, mut above) = (critical, critical);
        for _ in 0..40 {
            (below, above) = (below.next_down(), above.next_up());
            for cos in [below, critical, above] {
                let found = dielectric_reflectance(cos, eta);
                let direction = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, -cos);
                let is_refracted = refract(direction, DVec3::Z, eta).is_some();
                let exact = exact_reflectance(cos, eta);
                assert_eq!(is_refracted, exact.is_some(), "cos {cos:e}, η {eta:e}");
                let Some((exact, _)) = exact else {
                    assert_eq!(found, 1.0, "cos {cos:e}, η {eta:e}");
                    continue;
                };
                passed += 1;
                let off = exact.relative_error_of(found);
                assert!(off <= LAST_ROUNDING, "cos {cos:e}, η {eta:e}: {off:e}");
                worst = worst.max(off / U);
            }
        }
    }
    println!("within 40 last digits of the critical cosine: {passed} pass, worst {worst:.3} u");
    assert!(passed > 100, "{passed}");
}

/// The share of flux that is transmitted, by the amplitudes that are: T = (w/c) (t_s² + t_p²)/2 with w = η
/// cos θₜ, t_s = 2c/(c + w) and t_p = 2ηc/(η²c + w) (Born and Wolf, 1.5.2 (20a)), with twice the digits.
fn exact_transmittance(cos: f64, eta: f64) -> Option<Exact> {
    let (c, eta) = (Exact::from(cos), Exact::from(eta));
    let squared = (eta - Exact::ONE) * (eta + Exact::ONE) + c * c;
    if squared.value() <= 0.0 {
        return None;
    }
    let (w, two) = (squared.sqrt(), Exact::from(2.0));
    let s = two * c / (c + w);
    let p = two * eta * c / (eta * eta * c + w);
    Some(w / c * Exact::from(0.5) * (s * s + p * p))
}

/// What is transmitted is never computed but as 1 − F: here it is, by itself. F ≤ 1 is off by its last
/// rounding, which is half of u at most, and by what [`LAST_ROUNDING`] has more.
#[test]
fn what_is_not_reflected_is_transmitted() {
    println!("R + T − 1 with T from transmitted amplitudes: worst, in u");
    for (name, cases) in families() {
        let mut worst = 0.0_f64;
        for (cos, eta) in cases {
            let Some(transmitted) = exact_transmittance(cos, eta) else {
                continue;
            };
            let off = (Exact::ONE - transmitted).error_of(dielectric_reflectance(cos, eta));
            let allowed = LAST_ROUNDING - 0.5 * U;
            assert!(off <= allowed, "{name}: cos {cos:e}, η {eta:e}: {off:e}");
            worst = worst.max(off / U);
        }
        println!("  {name:26} {worst:9.3}");
    }
}

/// 1e-1 ... 1e-12 rad beyond the critical angle: cos θᵢ changes by sin θᵢ times that, many times its
/// rounding.
#[test]
fn beyond_the_critical_angle_all_is_reflected() {
    let normal = DVec3::new(0.48, -0.6, 0.64);
    let across = normal.any_orthonormal_vector();
    let mut tried = 0;
    for eta in INDICES.into_iter().filter(|eta| *eta < 1.0) {
        for step in 4..=48 {
            let incidence = eta.asin() + f64::powf(10.0, -f64::from(step) / 4.0);
            // (1 − η²) − cos² = sin² − η² = 2 η away: u of their roundings is as much at η = 0.01.
            let away = incidence.sin().powi(2) - eta * eta;
            if incidence > PI / 2.0 || away < 16.0 * U {
                continue;
            }
            tried += 1;
            let (sin, cos) = incidence.sin_cos();
            assert_eq!(dielectric_reflectance(cos, eta), 1.0, "η {eta}, {step}");
            let direction = across * sin - normal * cos;
            assert_eq!(refract(direction, normal, eta), None, "η {eta}, {step}");
        }
    }
    assert!(tried > 150, "{tried}");
}

#[test]
fn matched_media_reflect_nothing_and_bend_nothing_at_any_angle() {
    // Down to cosines whose squares, and theirs, are nothing.
    for cos in [1e-80, 1e-150, 3e-155, 1e-160, 2e-162, 5e-324] {
        assert_eq!(dielectric_reflectance(cos, 1.0), 0.0, "{cos:e}");
    }
    for (cos, _) in grazing().into_iter().chain(ordinary()) {
        assert_eq!(dielectric_reflectance(cos, 1.0), 0.0);
        let direction = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, -cos);
        assert_eq!(refract(direction, DVec3::Z, 1.0), Some(direction));
    }
}

/// d = −n: c = 1 exactly, so that t = −n (1 + (w − 1) − 1 ...)/η with w = η to 2 roundings and the root's
/// half; then the difference, the sum and the quotient: 6 u.
#[test]
fn at_normal_incidence_light_goes_straight_on() {
    for normal in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Z] {
        for (_, eta) in nearly_matched().into_iter().chain(grazing()) {
            let through = refract(-normal, normal, eta).expect("nothing is critical here");
            assert_eq!(through.cross(normal), DVec3::ZERO, "η {eta:e}");
            // For η < 1 the roundings are of numbers near 1, and divided by η.
            let allowed = 6.0 * U * eta.recip().max(1.0).powi(2);
            assert!(
                (through.dot(normal) + 1.0).abs() <= allowed,
                "η {eta:e}: {through}"
            );
            assert_eq!(reflect(-normal, normal), normal);
        }
    }
}

/// The refracted direction of the formula with twice the digits, from the same `f64` vectors.
fn exact_refraction(d: DVec3, n: DVec3, eta: f64) -> Option<Exact3> {
    let (d, n, eta) = (Exact3::from(d), Exact3::from(n), Exact::from(eta));
    let cos = -d.dot(n);
    let squared = (eta - Exact::ONE) * (eta + Exact::ONE) + cos * cos;
    if squared.value() <= 0.0 {
        return None;
    }
    let bent = d + n.scaled(cos - squared.sqrt());
    Some(bent.scaled(Exact::ONE / eta))
}

/// c = −d·n is off by up to 3 u (absolutely: at grazing incidence it is a difference), w by its own roundings
/// and by c/w times that; difference 1, product 1, sum 1 and quotient 1 of their results.
fn refraction_bound(cos: f64, eta: f64) -> f64 {
    let a = ((eta - 1.0) * (eta + 1.0)).abs();
    let w = ((eta - 1.0) * (eta + 1.0) + cos * cos).sqrt();
    let in_w = U * (1.5 * w + 0.5 * (3.0 * a + cos * cos) / w) + 3.0 * U * cos / w;
    1.01 * ((3.0 * U + in_w + 3.0 * U * (cos - w).abs() + U) / eta + 2.0 * U)
}

#[test]
fn refracted_directions_are_as_good_as_their_conditioning() {
    println!("refracted direction: worst error, and the worst share of what is allowed");
    // A normal along no axis.
    let normal = DVec3::new(0.48, -0.6, 0.64);
    let across = normal.any_orthonormal_vector();
    for (name, cases) in families() {
        let (mut worst, mut of_bound) = (0.0_f64, 0.0_f64);
        for (cos, eta) in cases {
            let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
            let direction = across * sin - normal * cos;
            let squared = (eta - 1.0) * (eta + 1.0) + cos * cos;
            // So near the critical angle that c's own rounding decides on which side it is.
            if squared <= 64.0 * U {
                continue;
            }
            let exact = exact_refraction(direction, normal, eta).expect("light passes");
            let found = refract(direction, normal, eta).expect("light passes");
            let error = (exact - Exact3::from(found)).value().abs().max_element();
            let bound = refraction_bound(cos, eta);
            assert!(
                error <= bound,
                "{name}: cos {cos:e}, η {eta:e}: off by {error:e}, allowed {bound:e}"
            );
            worst = worst.max(error);
            of_bound = of_bound.max(error / bound);
        }
        println!("  {name:26} {worst:9.1e} {of_bound:6.2}");
    }
}

/// Flux that ended, whatever became of it.
#[derive(Default)]
struct Ended {
    flux: f64,
}

impl ChainSink<1> for Ended {
    fn arrived(&mut self, _: &Arrival<1>, _: &mut TraversalCounters) -> Fate {
        Fate::Absorbed
    }
    fn ended(&mut self, _: Signature, _: Fate, flux: Flux<1>) {
        self.flux += flux.0[0];
    }
    fn gained(&mut self, _: Flux<1>) {}
}

/// Each of two interfaces splits F and 1 − F, one rounding each, and the products take one more; the sum of
/// at most four ends takes one each: 8 u in all.
#[test]
fn what_is_reflected_and_what_is_transmitted_is_all_to_8_u() {
    let pane = |index: f64| {
        scene(
            &format!(
                r#"
<emitter type="point"><point name="position" x="0" y="0" z="9"/><rgb name="intensity" value="1"/></emitter>
<shape type="rectangle">
  <transform name="to_world"><scale value="1e30"/></transform>
  <bsdf type="dielectric"><float name="int_ior" value="{index:?}"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="rectangle">
  <transform name="to_world"><translate z="-100"/></transform><bsdf type="diffuse"/>{{meter}}
</shape>"#
            ),
            None,
            1,
        )
    };
    let mut worst = 0.0_f64;
    for index in [1.0 + 1e-12, 1.33, 2.418, 100.0] {
        let scene = pane(index);
        let settings = ChainSettings {
            max_depth: 1,
            split_depth: 1,
            shading_normals: ShadingNormals::Flux,
            followed: Followed::All,
        };
        let mut tracer = ChainTracer::<1>::new(&scene, settings);
        for (cos, _) in grazing().into_iter().chain(ordinary()).chain(critical()) {
            let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
            for side in [1.0, -1.0] {
                let turned = DVec2::from_angle(0.7) * sin;
                let ray = Ray::new(DVec3::Z * side, turned.extend(-side * cos));
                let mut ended = Ended::default();
                tracer.trace(&light(ray), &mut ended);
                let off = (ended.flux - 1.0).abs();
                assert!(off <= 8.0 * U, "n {index}, cos {cos:e}: {:e}", ended.flux);
                worst = worst.max(off);
            }
        }
    }
    println!("R + T − 1: at most {:.2} u", worst / U);
}

/// Sunlight that meets water `elevation` over the horizon, and the bottom below it.
///
/// Parallel light stays parallel in flat water: all of the bottom has E = E₀ sin(elevation) (1 − F). The
/// water reaches beyond the bottom by more than any ray is shifted: 0.5 tan(48.8°) < 0.6 in water.
fn pool(direction: DVec3, int_ior: f64, depth: f64) -> Scene {
    scene(
        &format!(
            r#"
<emitter type="directional">
  <vector name="direction" x="{:?}" y="0" z="{:?}"/><rgb name="irradiance" value="1000"/>
</emitter>
<shape type="rectangle">
  <transform name="to_world"><scale value="3"/><translate z="{depth:?}"/></transform>
  <bsdf type="dielectric"><float name="int_ior" value="{int_ior:?}"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="rectangle"><bsdf type="diffuse"/>{{meter}}</shape>"#,
            direction.x, direction.z
        ),
        None,
        8,
    )
}

/// The cosine at which a scene's sun meets the plane z = const, as the scene has it: normalised.
fn sun_cosine(scene: &Scene) -> f64 {
    match scene.emitters()[0] {
        Emitter::Directional { direction, .. } => -direction.z,
        _ => unreachable!("a sun"),
    }
}

/// Irradiance [W/m²] that LTD should have, and the most that it may be off, as a fraction: F's error as a
/// part of 1 − F, and what a texel's area may be off: it is found from four corners, by products of
/// coordinates of up to 24 texels (the water's) and of 1, with four roundings each.
fn bottom(scene: &Scene, eta: f64) -> Option<(f64, f64)> {
    let cos = sun_cosine(scene);
    let (reflectance, _) = exact_reflectance(cos, eta)?;
    let passed = (Exact::ONE - reflectance).value();
    let allowed = LAST_ROUNDING / passed + 4.0 * 24.0 * 4.0 * U;
    Some((1000.0 * cos * passed, allowed))
}

/// The worst texel of LTD by beams, as a fraction of what it should be; `None` where they do not follow it.
///
/// To a relative error of 1e-9: light below a thousandth of the error asked for, of all that meets the water,
/// is not followed.
fn worst_texel(scene: &Scene, truth: f64) -> Option<f64> {
    let found = beams(scene, 1e-9, 1);
    let map = red(layer(&found, "LTD")?);
    let off = map.iter().map(|e| (e / truth - 1.0).abs());
    Some(off.fold(0.0, f64::max))
}

#[test]
fn water_is_lit_by_a_sun_that_all_but_sets() {
    println!(
        "sun over water, radians over the horizon: worst texel of LTD by beams, relative, and what is allowed; \
         by photons, and their standard error"
    );
    for elevation in [1e-1, 1e-3, 1e-5, 1e-7, 1e-9_f64] {
        let direction = DVec3::new(elevation.cos(), 0.0, -elevation.sin());
        let scene = pool(direction, 1.33, 0.5);
        let (truth, allowed) = bottom(&scene, 1.33).expect("nothing is critical from outside");
        // Beams follow a branch with 1e-7 of the light that arrives, or more (`beams/discovery`); 1 − F is 5 times the elevation here.
        let by_beams = worst_texel(&scene, truth).map_or_else(
            || {
                assert!(elevation < 2e-8, "{elevation:e}: beams find the bottom");
                "not followed".to_owned()
            },
            |off| {
                assert!(off <= allowed, "{elevation:e}: {off:e}");
                format!("{off:.1e}")
            },
        );
        let found = photons(&scene, 1 << 16, 1);
        let by_photons = layer(&found, "LTD").expect("photons find the bottom");
        // The mean over texels is no less certain than the texels are on average.
        let mean = |values: &[Rgb]| {
            values.iter().map(|it| it.0[0]).sum::<f64>() / values.len() as f64 / truth
        };
        let (away, error) = (
            mean(&by_photons.values) - 1.0,
            mean(&by_photons.standard_error),
        );
        assert!(error > 0.0 && away.abs() <= 5.0 * error, "{elevation:e}");
        println!(
            "  {elevation:.0e}: {by_beams} (allowed {allowed:.1e}); {away:+.1e} ± {error:.1e}"
        );
    }
}

#[test]
fn light_about_to_be_reflected_totally_is_known_to_its_conditioning() {
    println!(
        "from glass into air, radians before the critical angle: worst texel of LTD by beams, relative, and what is allowed"
    );
    let eta = 1.0 / 1.5;
    let critical = f64::asin(eta);
    for inside in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12_f64] {
        let direction = |angle: f64| DVec3::new(angle.sin(), 0.0, -angle.cos());
        // Light leaves at √(2 · inside · tan θc) over the interface: from this near it is shifted by less
        // than 1.
        let depth = 0.5 * inside.sqrt();
        let scene = pool(direction(critical - inside), eta, depth);
        let (truth, allowed) = bottom(&scene, eta).expect("before the critical angle");
        let off = worst_texel(&scene, truth).expect("beams find the bottom");
        println!("  {inside:.0e}: {off:.1e} (allowed {allowed:.1e})");
        assert!(off <= allowed, "{inside:e}: {off:e}");
        let beyond = pool(direction(critical + inside), eta, depth);
        let found = beams(&beyond, 1e-9, 1);
        assert!(
            layer(&found, "LTD").is_none_or(|layer| red(layer).iter().all(|e| *e == 0.0)),
            "{inside:e} beyond the critical angle nothing passes"
        );
    }
}
