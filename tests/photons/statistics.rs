//! Tests that error bars mean what they say, and that settings change what they should and no more.
//!
//! All on the scene `glass-ball`, whose every texel is known in closed form. Seeds are fixed.

use nephroid::internals::numeric::StreamKind;
use nephroid::internals::reference::closed_form::{GlassBall, KnownPath, TexelGrid};
use nephroid::internals::run::{Estimate, LayerName};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::ledger::FluxByFate;
use nephroid::internals::transport::scatter::ShadingNormals;
use nephroid::internals::transport::signature::Signature;

use crate::support::scenes::{layer, sensor_area};
use crate::support::{Compared, Photons, bundled, student};

/// The probability that a right program fails this file, and more than its comparisons.
const ALPHA: f64 = 1e-6;
const COMPARISONS: usize = 1000;

const STREAMS: [StreamKind; 2] = [StreamKind::Sobol, StreamKind::Random];

fn truth(path: KnownPath, side: usize) -> Vec<f64> {
    GlassBall::SHIPPED
        .sheet(path)
        .map(&TexelGrid::square(2.0, side))
}

/// Mean and standard error of independent numbers.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let moments: nephroid::internals::numeric::SampleMoments = values.iter().copied().collect();
    (moments.mean().unwrap(), moments.standard_error().unwrap())
}

/// The truth lies within 1 and 2 error bars as often as Student's t with 15 degrees of freedom does (66.7 %
/// and 93.6 %), on LTTD and LRD, with both kinds of points.
///
/// Texels of one run share its photons, so only runs count as independent: the share of covered texels of
/// each of 16 seeds is one number, and their mean must lie within Student's quantile of its own standard
/// error.
#[test]
fn error_bars_cover_the_truth_as_often_as_they_should() {
    const SEEDS: u64 = 16;
    const REPLICATES: u32 = 16;
    for (path, side, least) in [
        (KnownPath::Through(0), 48, 50),
        (KnownPath::Reflected(1), 2, 4),
    ] {
        let scene = bundled("glass-ball", side);
        let truth = truth(path, side);
        let mut squares = Vec::new();
        for stream in STREAMS {
            let runs: Vec<Compared> = (0..SEEDS)
                .map(|seed| {
                    let photons = Photons::new(1 << 18)
                        .replicates(REPLICATES)
                        .stream(stream)
                        .seed(seed);
                    let estimate = photons.estimate(&scene);
                    Compared::new(&scene, &photons, &estimate, &path.signature(), &truth)
                })
                .collect();
            squares.extend(runs.iter().map(|run| run.agreement().variance));
            for bars in [1.0, 2.0] {
                let covered: Vec<f64> = runs
                    .iter()
                    .map(|run| {
                        let judged: Vec<usize> = run.judged().collect();
                        assert!(judged.len() >= least, "{} judged", judged.len());
                        let inside = judged.iter().filter(|texel| run.z(**texel).abs() <= bars);
                        inside.count() as f64 / judged.len() as f64
                    })
                    .collect();
                let expected = 1.0 - student::two_sided_tail(bars, REPLICATES - 1);
                let (mean, error) = mean_and_error(&covered);
                let quantile =
                    student::two_sided_quantile(ALPHA / COMPARISONS as f64, SEEDS as u32 - 1);
                println!("{path:?} {stream:?} ±{bars}: {mean:.4} ± {error:.4} of {expected:.4}");
                assert!(
                    (mean - expected).abs() <= quantile * error,
                    "{path:?} {stream:?}: {mean} ± {error} within ±{bars}, expected {expected}"
                );
            }
        }
        // Bars that are 15 % too small have scores whose squares are 1 / 0.85² = 1.38 times too large. The mean of
        // squares over the seeds, fixed as they are, is within four of its standard errors of Student's variance;
        // where texels are many, that is less than the factor.
        let variance = student::moments(REPLICATES - 1).variance;
        let (mean, error) = mean_and_error(&squares);
        println!("{path:?}: mean z² {mean:.4} ± {error:.4} of {variance:.4}");
        assert!(
            (mean - variance).abs() <= 4.0 * error,
            "{path:?}: {mean} ± {error}"
        );
        let narrow = 1.0 / (0.85 * 0.85);
        assert!(
            least < 50 || narrow * mean - variance > 4.0 * narrow * error,
            "{error}"
        );
    }
}

/// The errors of two seeds are uncorrelated: the mean product of their z-scores over n texels is 0 to
/// within ν/(ν−2)/√n, the product's standard deviation.
#[test]
fn different_seeds_err_independently() {
    const SIDE: usize = 64;
    let scene = bundled("glass-ball", SIDE);
    let truth = truth(KnownPath::Through(0), SIDE);
    for stream in STREAMS {
        let run = |seed: u64| {
            let photons = Photons::new(1 << 19).stream(stream).seed(seed);
            let estimate = photons.estimate(&scene);
            Compared::new(&scene, &photons, &estimate, "LTTD", &truth)
        };
        let (one, other) = (run(1), run(2));
        let products: Vec<f64> = one
            .judged()
            .map(|texel| one.z(texel) * other.z(texel))
            .collect();
        assert!(products.len() >= 80, "{}", products.len());
        let mean = products.iter().sum::<f64>() / products.len() as f64;
        let limit = student::normal_quantile(ALPHA / COMPARISONS as f64)
            * student::moments(31).variance
            / (products.len() as f64).sqrt();
        println!("{stream:?}: correlation {mean:.4}, allowed {limit:.4}");
        assert!(mean.abs() <= limit, "{stream:?}: {mean}, allowed {limit}");
        assert_ne!(one.estimate, other.estimate);
    }
}

/// Sixteen times as many photons make the error of random points four times smaller, and that of Sobol'
/// points at least as much; with many photons Sobol' points are far ahead.
///
/// Measured on 24 texels of the caustic: Sobol' points gain 6.6, and are then 2.65 times ahead. A root mean
/// square over n texels is known to 1/√(2 n) of itself and a quotient of two to 1/√n, 20 % here; texels that
/// share photons may be worth half as many. So random points' factor is tested to five of these, and Sobol'
/// points' lead to one half of what was measured, which still is more than none.
#[test]
fn sobol_points_beat_random_ones_and_gain_more_from_more() {
    const SIDE: usize = 32;
    let scene = bundled("glass-ball", SIDE);
    let truth = truth(KnownPath::Through(0), SIDE);
    let bright = |texel: usize| truth[texel] > 20.0;
    let rmse = |stream: StreamKind, count: u64| {
        let photons = Photons::new(count).stream(stream);
        let estimate = photons.estimate(&scene);
        let it = Compared::new(&scene, &photons, &estimate, "LTTD", &truth).agreement_of(bright);
        println!("{stream:?} {count}: {it:?}");
        (it.relative_rmse, it.texels as f64)
    };
    let [few, many] = [1 << 17, 1 << 21];
    let (sobol_few, texels) = rmse(StreamKind::Sobol, few);
    let (sobol_many, _) = rmse(StreamKind::Sobol, many);
    let (random_few, _) = rmse(StreamKind::Random, few);
    let (random_many, _) = rmse(StreamKind::Random, many);
    // Of a quotient of two, relative.
    let unsure = 1.0 / texels.sqrt();
    let gain = random_few / random_many;
    let sobol_gain = sobol_few / sobol_many;
    let ahead = random_many / sobol_many;
    println!("gains {gain:.2} and {sobol_gain:.2}; Sobol' is ahead by {ahead:.2}");
    assert!(
        (gain / 4.0 - 1.0).abs() <= 5.0 * unsure,
        "random points gain {gain}, not 4"
    );
    assert!(
        sobol_gain >= gain,
        "Sobol' points gain {sobol_gain}, random ones {gain}"
    );
    assert!(ahead >= 1.3, "Sobol' points are ahead by {ahead} only");
}

/// Which branches are followed and which are chosen by chance changes the noise, not the expected value; nor
/// does the number of replicates.
#[test]
fn split_depth_and_replicates_do_not_move_the_estimate() {
    let scene = bundled("glass-ball", 2);
    let paths = [
        KnownPath::Through(0),
        KnownPath::Reflected(1),
        KnownPath::Through(3),
    ];
    let truths = paths.map(|path| truth(path, 2));
    let check = |photons: Photons| {
        let estimate = photons.estimate(&scene);
        for (path, truth) in paths.iter().zip(&truths) {
            // By chance alone a photon keeps all of its flux, and few take a rare path: LTRRRTD's flux is
            // that of 0.16 % of the photons, 400 in each quarter of the floor: enough for a normal sum.
            let mut it = Compared::new(&scene, &photons, &estimate, &path.signature(), truth);
            it.photons = vec![f64::INFINITY; truth.len()];
            it.assert_every_texel_agrees(4, ALPHA, COMPARISONS);
        }
    };
    for split_depth in [0, 1, 2, 4] {
        let mut photons = Photons::new(1 << 20);
        photons.settings.chains.split_depth = split_depth;
        check(photons);
    }
    for replicates in [8, 16, 64, 128] {
        check(Photons::new(1 << 20).replicates(replicates));
    }
}

/// All fates of the ledger's rows with so many events, or fewer.
fn rows_up_to(estimate: &Estimate, events: usize) -> Vec<(Signature, FluxByFate)> {
    let rows = estimate.ledger.rows.iter();
    rows.filter(|(signature, _)| signature.len() <= events)
        .map(|(signature, row)| (*signature, *row))
        .collect()
}

/// With a depth of 2, paths of up to two events are what they are with a depth of 16, bit for bit, and the
/// flux of all longer ones is cut off: none is lost, none arrives.
///
/// Whole flux: sums of 2^18 exact quanta agree but for the final conversion, 1e-12 is generous.
#[test]
fn the_depth_only_moves_flux_from_longer_paths_to_cut_off() {
    let scene = bundled("glass-ball", 16);
    let run = |max_depth: u32| {
        let mut photons = Photons::new(1 << 18);
        photons.settings.chains.max_depth = max_depth;
        photons.settings.max_layers = 64;
        photons.estimate(&scene)
    };
    let (shallow, deep) = (run(2), run(16));
    for signature in ["LRD", "LTTD"] {
        assert_eq!(layer(&shallow, signature, 0), layer(&deep, signature, 0));
    }
    assert_eq!(shallow.ledger.emitted, deep.ledger.emitted);
    let emitted = deep.ledger.emitted.0[0];
    let ended = |estimate: &Estimate| -> f64 {
        let rows = rows_up_to(estimate, 2);
        rows.iter()
            .map(|(_, row)| (row.total() - row.cut_off).0[0])
            .sum()
    };
    assert!((ended(&shallow) - ended(&deep)).abs() <= 1e-12 * emitted);
    let cut_off = shallow.ledger.sum().cut_off.0[0];
    let longer = emitted - ended(&deep);
    assert!(
        (cut_off - longer).abs() <= 1e-12 * emitted,
        "{cut_off} {longer}"
    );
    assert!(cut_off > 0.01 * emitted);
    let received: f64 = shallow.layers[1..].iter().map(|it| it.range().mean).sum();
    let of_short: f64 = ["LRD", "LTTD"]
        .iter()
        .map(|signature| layer(&deep, signature, 0).0.iter().sum::<f64>() / 256.0)
        .sum();
    assert!((received - of_short).abs() <= 1e-12 * received);
}

/// Adjoint shading normals scale flux where normals are interpolated, and only there: the ball's mesh is
/// changed; flat facets and the analytic ball are not, in any bit.
#[test]
fn the_adjoint_convention_differs_only_on_interpolated_normals() {
    let run = |name: &str, shading_normals: ShadingNormals| {
        let scene = bundled(name, 16);
        let mut photons = Photons::new(1 << 16);
        photons.settings.chains.shading_normals = shading_normals;
        photons.estimate(&scene)
    };
    for (name, differs) in [
        ("glass-ball-mesh", true),
        ("glass-ball", false),
        ("prism", false),
    ] {
        let [flux, adjoint] =
            [ShadingNormals::Flux, ShadingNormals::Adjoint].map(|it| run(name, it));
        assert_eq!(
            layer(&flux, "LTTD", 0) != layer(&adjoint, "LTTD", 0),
            differs,
            "{name}"
        );
        assert!(flux.ledger.shading_gain.is_black());
        assert_eq!(adjoint.ledger.shading_gain.is_black(), !differs, "{name}");
        assert!(
            flux.ledger.closure_error().unwrap() < 1e-12
                && adjoint.ledger.closure_error().unwrap() < 1e-12
        );
    }
}

/// What a scene's layers hold is what its ledger says was received, signature by signature, and all flux is
/// accounted for.
///
/// Both are sums of the same exact quanta: they differ by the roundings of the texels' areas and their sum.
#[test]
fn layers_and_ledger_tell_of_the_same_flux() {
    let check = |scene: &Scene| {
        let estimate = Photons::new(1 << 15).estimate(scene);
        let name = scene.path().display();
        let closure = estimate.ledger.closure_error().unwrap();
        assert!(closure < 1e-12, "{name}: {closure}");
        let texel_area = sensor_area(scene) / estimate.counts.len() as f64;
        let mut received = 0;
        for found in &estimate.layers[1..] {
            let row = match found.name {
                LayerName::Path(signature) => estimate.ledger.rows[&signature],
                _ => estimate.ledger.other,
            };
            for channel in 0..3 {
                let flux: f64 = found
                    .values
                    .iter()
                    .map(|it| it.0[channel] * texel_area)
                    .sum();
                let expected = row.received.0[channel];
                assert!(
                    (flux - expected).abs() <= 1e-11 * expected,
                    "{name} {}",
                    found.name
                );
            }
            received += 1;
        }
        assert!(received > 0, "{name}");
    };
    for name in [
        "glass-ball",
        "coffee-cup",
        "cornell-glass",
        "cornell-caustics",
        "diamond",
        "water",
        "pool",
        "parabolic-mirror",
        "turntable-bumpy",
    ] {
        check(&bundled(name, 8));
    }
}
