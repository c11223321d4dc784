//! A scene has no size: in other units it has the same light.
//!
//! Lengths are scaled by s and radiant intensities by s², so that irradiance [W/m²] stays as it is.

mod extremes_support;

use extremes_support::{
    BALL, DIAMOND, Placement, RING, Template, WATER, beams, distance, photons, red,
};
use nephroid::reference::Estimate;

/// Each kind of shape, emitter and mesh is in one of them.
const SCENES: [Template; 4] = [BALL, RING, DIAMOND, WATER];

/// Texels a side.
const SIDE: usize = 16;

/// Every number that two runs deliver about every texel.
fn assert_same_bits(name: &str, home: &Estimate, scaled: &Estimate) {
    assert_eq!(home.layers.len(), scaled.layers.len(), "{name}");
    assert_eq!(home.counters, scaled.counters, "{name}");
    for (a, b) in home.layers.iter().zip(&scaled.layers) {
        assert_eq!(a.name, b.name, "{name}");
        let at = |a: &[nephroid::radiometry::Rgb], b: &[nephroid::radiometry::Rgb]| {
            let bits = |value: &nephroid::radiometry::Rgb| value.0.map(f64::to_bits);
            a.iter().zip(b).position(|(a, b)| bits(a) != bits(b))
        };
        assert_eq!(at(&a.irradiance, &b.irradiance), None, "{name} {}", a.name);
        assert_eq!(
            at(&a.standard_error, &b.standard_error),
            None,
            "{name} {}: error",
            a.name
        );
        assert_eq!(
            a.interval.is_some(),
            b.interval.is_some(),
            "{name} {}",
            a.name
        );
        if let (Some(a_bounds), Some(b_bounds)) = (&a.interval, &b.interval) {
            assert_eq!(at(&a_bounds.low, &b_bounds.low), None, "{name} {}", a.name);
            assert_eq!(
                at(&a_bounds.high, &b_bounds.high),
                None,
                "{name} {}",
                a.name
            );
        }
    }
}

/// A scene's map by both methods, scaled.
fn maps(template: &Template, scale: f64) -> [(&'static str, Estimate); 2] {
    let scene = template.scene(Placement::scaled(scale), SIDE);
    [
        ("beams", beams(&scene, 1e-2, 4)),
        ("photons", photons(&scene, 1 << 14, 4)),
    ]
}

/// A power of two rounds nothing, so nothing may change: not a bit of any value or error, not a ray.
#[test]
fn scaled_by_powers_of_two_maps_have_the_same_bits() {
    for template in SCENES {
        let home = maps(&template, 1.0);
        for exponent in [-60, -20, 3, 40] {
            let scaled = maps(&template, f64::powi(2.0, exponent));
            for ((method, a), (_, b)) in home.iter().zip(&scaled) {
                assert_same_bits(
                    &format!("{} by {method}, 2^{exponent}", template.name),
                    a,
                    b,
                );
            }
        }
    }
}

/// A scene in millimetres or kilometres has other roundings. They count as often as a path amplifies them: by hundreds at most
/// here, of some 1e-16 each. What decides where beams are divided does not flip.
#[test]
fn in_other_units_maps_are_the_same_to_a_billionth() {
    println!("scaled by s: largest change of a texel, relative to the brightest");
    for template in SCENES {
        let home = maps(&template, 1.0);
        for scale in [1e-6, 1e-3, 1e3, 1e6] {
            let scaled = maps(&template, scale);
            for ((method, a), (_, b)) in home.iter().zip(&scaled) {
                let apart = distance(&red(&a.total), &red(&b.total));
                println!("  {:10} {method:8} x {scale:e}: {apart:.1e}", template.name);
                assert!(
                    apart <= 1e-9,
                    "{} by {method} x {scale:e}: {apart:e}",
                    template.name
                );
            }
        }
    }
}

/// Where cubes of lengths (determinants) underflow, or their fourth powers overflow, the scene is refused.
#[test]
fn scenes_too_small_or_large_for_f64_are_refused() {
    for (scale, why) in [
        (1e-130, "the matrix cannot be inverted"),
        (
            1e80,
            "gives the sphere a size of 1e80; allowed is 1e-120 to 1e70",
        ),
    ] {
        let message = BALL.error(Placement::scaled(scale));
        assert!(message.contains(why), "{message}");
    }
}
