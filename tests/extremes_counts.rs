//! Very many, very few, very large, very small: sums, photons, texels, bounces (docs/accuracy.md, 7).

mod support;

use nephroid::film::Accumulator;
use nephroid::numeric::{ExactSum, FixedPoint};
use nephroid::reference::photons::PhotonSettings;
use nephroid::reference::photons::run::Setup;
use nephroid::reference::{Estimate, LayerName, Progress};
use nephroid::scene::Scene;
use nephroid::transport::chain::ChainSettings;
use rayon::prelude::*;
use support::beams::beams;
use support::scenes::{Photons, bundled, meter, sensor_area};

/// A weight of 24 decades and its exact value in units of 2⁻⁵¹: twelve bits, shifted by up to 79.
fn weight(index: u64) -> (f64, i128) {
    // SplitMix64: any 64 bits will do, as long as all exponents come up.
    let mut bits = index.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits ^= bits >> 27;
    let mantissa = 0x800 | (bits & 0x7ff);
    let shift = (bits >> 16) % 80;
    let value = mantissa as f64 * 2f64.powi(shift as i32 - 51);
    (value, i128::from(mantissa) << shift)
}

/// Weights from 2⁻⁴⁰ to 2⁴⁰, 1e-12 to 1e12, are summed by integers beside: 2³⁴ of them below 2⁴⁰⁺⁵¹ stay below 2¹²⁵.
/// An `i128` converts to `f64` with one rounding to nearest, and 2⁻⁵¹ of it is exact: no tolerance.
fn assert_sum_is_exact(count: u64) {
    const TASK: u64 = 1 << 20;
    let (sum, exact) = (0..count.div_ceil(TASK))
        .into_par_iter()
        .map(|task| {
            let (mut sum, mut exact) = (ExactSum::new(), 0i128);
            for index in task * TASK..((task + 1) * TASK).min(count) {
                let (value, integer) = weight(index);
                sum.add(value);
                exact += integer;
            }
            (sum, exact)
        })
        .reduce(
            || (ExactSum::new(), 0),
            |(mut sum, exact), (other, more)| {
                sum.merge(&other);
                (sum, exact + more)
            },
        );
    assert_eq!(
        sum.value(),
        exact as f64 * 2f64.powi(-51),
        "{count} weights"
    );
}

#[test]
fn ten_million_weights_of_24_decades_are_summed_to_the_last_bit() {
    assert_sum_is_exact(10_000_000);
}

#[test]
#[ignore = "two minutes"]
fn ten_thousand_million_weights_of_24_decades_are_summed_to_the_last_bit() {
    assert_sum_is_exact(10_000_000_000);
}

/// A film's quantum is 2⁻⁶⁰ of the flux that it is made for, rounded up to a power of two: each deposit is off by half a
/// quantum at most, and their sum by n halves, whatever the weights are. That, and one rounding of the mean, is all.
#[test]
fn a_film_is_off_by_half_a_quantum_a_deposit_and_nothing_else() {
    const COUNT: u64 = 1 << 20;
    let exact: i128 = (0..COUNT).map(|index| weight(index).1).sum();
    let total = exact as f64 * 2f64.powi(-51);
    let scale = FixedPoint::for_total(total).unwrap();
    let mut film = Accumulator::new(1, 1, scale);
    (0..COUNT).into_par_iter().for_each(|index| {
        let quanta = scale.quantise(weight(index).0).unwrap();
        assert!(film.deposit(0, [quanta]));
    });
    film.flush().unwrap();
    let mean = film.estimate(0, 0).unwrap().mean;
    let allowed = total * (COUNT as f64 * 2f64.powi(-60) + f64::EPSILON);
    assert!(
        (mean - total).abs() <= allowed,
        "{mean:e} against {total:e}: off by {:e}, allowed {allowed:e}",
        mean - total
    );
}

/// All that arrives on the receiver \[W\].
fn received(estimate: &Estimate) -> f64 {
    let sum = estimate.ledger.sum();
    sum.received.mean() + sum.direct.mean()
}

/// The sum over texels of irradiance times area \[W\], direct light left out.
fn caustic_flux(scene: &Scene, estimate: &Estimate) -> f64 {
    let texels = estimate.total.irradiance.len();
    let sum: ExactSum = estimate
        .layers
        .iter()
        .filter(|layer| !matches!(layer.name, LayerName::Path(path) if path.is_empty()))
        .flat_map(|layer| layer.irradiance.iter().map(|value| value.mean()))
        .collect();
    sum.value() * sensor_area(scene) / texels as f64
}

#[test]
fn one_photon_is_a_result_without_an_error_bar() {
    let scene = bundled("glass-ball", 8);
    let estimate = Photons::new(1).replicates(1).estimate(&scene);
    assert_eq!(estimate.paths, 1);
    assert_eq!(estimate.relative_error, None);
    // Where it is said at all, the error is not known; it is never said to be zero.
    for layer in estimate
        .layers
        .iter()
        .filter(|layer| layer.name != LayerName::Path("LD".parse().unwrap()))
    {
        let errors = &layer.standard_error;
        assert!(
            errors.iter().all(|error| error.0[0].is_nan()),
            "{:?}",
            layer.name
        );
    }
    // Its flux is all there is, and it is somewhere: 1 photon of at most 32 branches, rounded 2⁻⁶⁰ each; and u for each of eight rows
    // that are added up.
    let closure = estimate.ledger.closure_error().unwrap();
    assert!(
        closure <= 32.0 * 2f64.powi(-60) + 4.0 * f64::EPSILON,
        "{closure:e}"
    );
}

/// Texels share the receiver exactly: beams of one tolerance deal the same light to one texel or to 64 x 64. Both know it to
/// their bounds.
#[test]
fn one_texel_gets_what_four_thousand_get() {
    let [one, many] = [1, 64].map(|side| {
        let scene = bundled("glass-ball", side);
        let (estimate, _) = beams(&scene, 1e-3);
        let area = sensor_area(&scene) / (side * side) as f64;
        let bounds = estimate.total.interval.as_ref().unwrap();
        let flux = |values: &[nephroid::radiometry::Rgb]| {
            area * values.iter().map(|value| value.mean()).sum::<f64>()
        };
        [
            flux(&bounds.low),
            flux(&estimate.total.irradiance),
            flux(&bounds.high),
        ]
    });
    println!("one texel {one:?} W, 64 x 64 texels {many:?} W");
    assert!(
        one[0] <= many[2] && many[0] <= one[2],
        "{one:?} against {many:?}"
    );
    // One texel's value is not sharper than asked, nor is the sum of many.
    assert!(
        (one[1] / many[1] - 1.0).abs() < 2e-3,
        "{one:?} against {many:?}"
    );
}

/// The film of 2²⁶ texels: what its texels sum to is what the ledger says it received. Each photon is in one texel, rounded to a
/// quantum by both; the mean of a texel is rounded once: n 2⁻⁶⁰ + 2⁻⁵³, and the sum here is exact.
#[test]
#[ignore = "a minute, and 16 GB of memory"]
fn a_film_of_8192_x_8192_texels_sums_to_what_it_received() {
    let count = 1 << 22;
    let scene = bundled("glass-ball", 8192);
    let settings = PhotonSettings {
        replicates: 2,
        max_layers: 0,
        ..PhotonSettings::default()
    };
    let estimate = Photons { settings, count }.estimate(&scene);
    let (texels, ledger) = (
        caustic_flux(&scene, &estimate),
        estimate.ledger.sum().received.mean(),
    );
    println!(
        "{texels} W in texels, {ledger} W in the ledger: {:.1e}",
        texels / ledger - 1.0
    );
    assert!((texels / ledger - 1.0).abs() <= count as f64 * 2f64.powi(-60) + 0.5 * f64::EPSILON);
}

/// The photons of a stone in which light goes on and on, followed to this many events.
fn diamond(max_depth: u32, max_layers: usize) -> Estimate {
    let scene = bundled("diamond", 16);
    let settings = PhotonSettings {
        replicates: 4,
        max_layers,
        chains: ChainSettings {
            max_depth,
            ..ChainSettings::default()
        },
        ..PhotonSettings::default()
    };
    Photons {
        settings,
        count: 1 << 16,
    }
    .estimate(&scene)
}

/// At each facet some light leaves; what is cut off falls from depth to depth, and never below what is cut off later. Each ledger
/// closes to the rounding of its photons: 2¹⁶ with some three ends each, half a quantum of 2⁻⁶⁰ each.
#[test]
fn light_is_followed_through_a_diamond_for_more_than_64_bounces() {
    let mut before = f64::INFINITY;
    for depth in [8, 16, 32, 64, 96, 127] {
        let estimate = diamond(depth, 8);
        let ledger = &estimate.ledger;
        let cut_off = ledger.sum().cut_off.mean() / ledger.emitted.mean();
        let longest = ledger.rows.keys().map(|path| path.len()).max().unwrap();
        println!(
            "depth {depth}: {cut_off:.2e} of the light is cut off, {:.6} W received",
            received(&estimate)
        );
        assert!(
            cut_off < before || cut_off == 0.0,
            "depth {depth}: {cut_off:e} after {before:e}"
        );
        before = cut_off;
        let closure = ledger.closure_error().unwrap();
        assert!(
            closure <= 4.0 * 65536.0 * 2f64.powi(-60),
            "depth {depth}: {closure:e}"
        );
        assert!(longest <= depth as usize);
    }
    // What light there is after 64 bounces is small but there.
    assert!(before < 1e-3, "{before:e}");
}

#[test]
fn a_depth_that_no_signature_holds_is_refused_with_what_is_allowed() {
    let scene = bundled("diamond", 4);
    let settings = PhotonSettings {
        chains: ChainSettings {
            max_depth: 128,
            ..ChainSettings::default()
        },
        ..PhotonSettings::default()
    };
    let progress = Progress::default();
    let refusal = Setup::new(&scene, meter(&scene), settings, &progress);
    let message = refusal.err().expect("128 events are too many").to_string();
    assert!(
        message.contains("128") && message.contains("0 to 127"),
        "{message}"
    );
}

/// The same photons, however many of their signatures have a layer of their own: what has none is in `other`, to the last quantum.
/// Each of up to 66 rows of the ledger, and each texel of as many layers, is rounded once: 66 u.
#[test]
fn signatures_past_the_limit_are_in_the_ledger_and_in_the_last_layer() {
    let (few, many) = (diamond(32, 2), diamond(32, 64));
    let named = |estimate: &Estimate| {
        estimate
            .layers
            .iter()
            .filter(|layer| matches!(layer.name, LayerName::Path(path) if !path.is_empty()))
            .count()
    };
    assert_eq!(named(&few), 2);
    assert!(named(&many) > 16, "{}", named(&many));
    assert!(
        few.layers
            .iter()
            .any(|layer| layer.name == LayerName::Other)
    );
    let [a, b] = [&few, &many].map(|estimate| estimate.ledger.sum().received.mean());
    assert!((a / b - 1.0).abs() < 33.0 * f64::EPSILON, "{a} against {b}");
    let scene = bundled("diamond", 16);
    let [a, b] = [&few, &many].map(|estimate| caustic_flux(&scene, estimate));
    assert!((a / b - 1.0).abs() < 33.0 * f64::EPSILON, "{a} against {b}");
    for estimate in [&few, &many] {
        let (texels, ledger) = (
            caustic_flux(&scene, estimate),
            estimate.ledger.sum().received.mean(),
        );
        assert!(
            (texels / ledger - 1.0).abs() < 1e-12,
            "{texels} W in texels, {ledger} W in the ledger"
        );
    }
}
