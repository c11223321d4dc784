//! Beams from area lights: they agree with photons, within bounds that hold, whatever the threads.

use nephroid::internals::numeric::distributions::critical_value;
use nephroid::internals::reference::beams;
use nephroid::internals::reference::beams::{BeamReport, BeamSettings};
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, Progress};
use nephroid::internals::scene::Scene;

use crate::support;
use crate::support::scenes::meter;

/// Texels a side: few, so that each gets photons enough to judge bounds by.
const SIDE: usize = 32;

fn scene() -> Scene {
    support::bundled("cornell-glass", SIDE)
}

fn by_beams(scene: &Scene, relative_error: f64) -> (Estimate, BeamReport) {
    let budget = Budget {
        relative_error: Some(relative_error),
        ..Budget::default()
    };
    let settings = BeamSettings::default();
    beams::run(scene, meter(scene), settings, &budget, &Progress::default()).unwrap()
}

#[test]
fn beams_from_an_area_light_agree_with_photons_within_their_bounds() {
    let scene = scene();
    let (beams, report) = by_beams(&scene, 0.3);
    let lamps = report.area_lights.unwrap();
    assert_eq!(lamps.replicates, 16);
    // 99.9 % of Student's t with 15 degrees of freedom: 4.073, in any table.
    assert!((lamps.standard_errors - 4.073).abs() < 1e-3);
    let progress = Progress::default();
    let setup = Setup::new(&scene, meter(&scene), PhotonSettings::default(), &progress).unwrap();
    let budget = Budget {
        work: Some(1 << 22),
        ..Budget::default()
    };
    let photons = setup.run(&budget).unwrap();
    // Photons' own error is taken off both ends, with the same confidence.
    let of_photons = critical_value(lamps.confidence, 31.0);
    for name in ["LTTD", "LRD"] {
        let of = |estimate: &Estimate| {
            let layers = &estimate.layers;
            layers
                .iter()
                .find(|layer| layer.name.to_string() == name)
                .cloned()
                .unwrap()
        };
        let (ours, theirs) = (of(&beams), of(&photons));
        let interval = ours.interval.as_ref().unwrap();
        let (mut judged, mut missed, mut squares, mut all_squares) = (0, 0, 0.0, 0.0);
        let (mut sum, mut other) = (0.0, 0.0);
        for texel in 0..SIDE * SIDE {
            let (value, truth) = (ours.values[texel].mean(), theirs.values[texel].mean());
            let error = ours.standard_error[texel].mean();
            let their_error = theirs.standard_error[texel].mean();
            (sum, other) = (sum + value, other + truth);
            if truth == 0.0 || their_error > 0.1 * truth {
                continue;
            }
            judged += 1;
            let (low, high) = (interval.low[texel].mean(), interval.high[texel].mean());
            let slack = of_photons * their_error;
            missed += u32::from(truth + slack < low || truth - slack > high);
            if error > 0.0 {
                let variance = error * error + their_error * their_error;
                // What cells are likely to misplace is no scatter: a quarter of what bounds hold beside it.
                let cells = 0.5 * (high - low) - lamps.standard_errors * error;
                let with_cells = variance + (0.25 * cells.max(0.0)).powi(2);
                squares += (value - truth).powi(2) / with_cells;
                all_squares += (value - truth).powi(2) / variance;
            }
        }
        println!(
            "{name}: {judged} texels, {missed} out of bounds, mean z² {:.2} (by scatter alone {:.2}), {sum} of {other}",
            squares / f64::from(judged),
            all_squares / f64::from(judged)
        );
        assert!(judged >= 60, "{name}: {judged} texels judged");
        // Two intervals of 99.9 % that both hold overlap: on average fewer than 1 in 500 do not. Texels share
        // places on the lamp, so misses come in groups: one, and five times as many, are allowed.
        assert!(
            missed <= 1 + judged / 100,
            "{name}: {missed} of {judged} out of bounds"
        );
        // z² of Student variables with 15 degrees of freedom has mean 15/13 = 1.15 and standard deviation
        // 1.9; as texels share 128 places, no more than those tell of each other: 5 x 1.9 / √128 = 0.84.
        assert!(
            squares / f64::from(judged) < 2.0,
            "{name}: {squares} over {judged}"
        );
    }
}

#[test]
fn the_same_bits_come_from_any_number_of_threads() {
    let scene = scene();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| by_beams(&scene, 1.0))
    };
    let (one, _) = run(1);
    for threads in [2, 5] {
        let (other, _) = run(threads);
        assert_eq!(one.ledger, other.ledger);
        for (a, b) in one.layers.iter().zip(&other.layers) {
            assert_eq!(a.name, b.name);
            let interval = |layer: &nephroid::internals::run::Layer| {
                let interval = layer.interval.clone().unwrap();
                (interval.low, interval.high)
            };
            assert!(a.values == b.values && a.standard_error == b.standard_error);
            assert_eq!(interval(a), interval(b));
        }
    }
}

/// What n = replicates · places may have missed of the lamp, 1 − 0.0005^(1/n) of it, with the light of the
/// brightest texel of any replicate: as much on each texel that none lit, and never nothing.
#[test]
fn texels_that_no_place_on_the_lamp_lit_have_an_upper_bound() {
    let scene = scene();
    let (estimate, report) = by_beams(&scene, 1.0);
    let lamps = report.area_lights.unwrap();
    let places = f64::from(lamps.replicates) * lamps.points as f64;
    let missed = 1.0 - 0.0005_f64.powf(1.0 / places);
    let mut unlit = 0;
    for layer in estimate.layers.iter().skip(1) {
        let interval = layer.interval.as_ref().unwrap();
        let brightest = layer
            .values
            .iter()
            .map(|value| value.0[0])
            .fold(0.0, f64::max);
        for texel in 0..SIDE * SIDE {
            let is_lit = layer.values[texel].0[0] > 0.0 || layer.standard_error[texel].0[0] > 0.0;
            if is_lit || brightest == 0.0 {
                continue;
            }
            unlit += 1;
            assert_eq!(interval.low[texel].0[0], 0.0);
            // A replicate's brightest texel is no darker than that of their mean. 1e-9: rounding of the
            // power.
            assert!(
                interval.high[texel].0[0] >= missed * brightest * (1.0 - 1e-9),
                "{} texel {texel}",
                layer.name
            );
        }
    }
    println!("{unlit} texels that no place lit");
    assert!(unlit > 0);
}

#[test]
fn all_signatures_of_an_area_light_share_out_the_same_light() {
    let scene = scene();
    let (estimate, report) = by_beams(&scene, 1.0);
    // Each signature's cells hold the same light, summed up with middles of edges: 256 cells a ball
    // at least, each of angle 1/16 of a half turn, leave (π/16)⁴ / 24 of it at most.
    let emitted: Vec<f64> = report.signatures.iter().map(|one| one.emitted).collect();
    for one in &emitted {
        assert!((one / emitted[0] - 1.0).abs() < 1e-3, "{emitted:?}");
    }
    // What each cell booked is on the film: of sums of integers, each of 10⁶ deposits rounded once to 2⁻⁶² of
    // 64 times the flux, 1e-12 is asked for, as in `tests/beams/method.rs`.
    for one in &report.signatures {
        assert!(
            one.balance_error <= 1e-12,
            "{}: {:e}",
            one.name,
            one.balance_error
        );
    }
    // The rest of the ledger is known by difference: it has no say in this.
    assert_eq!(estimate.ledger.closure_error(), None);
}
