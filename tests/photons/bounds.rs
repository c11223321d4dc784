//! Bounds by few photons hold as often as they promise, texels that no photon reached included.

use nephroid::internals::numeric::distributions::chi_squared_survival;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::closed_form::{GlassBall, KnownPath, TexelGrid};
use nephroid::internals::reference::photons::bounds::{
    Bounds, CONFIDENCE, ENOUGH, Sum, largest_possible,
};
use nephroid::internals::reference::photons::weights::Largest;
use nephroid::{Budget, CompareImage, CompareSettings, Context, Method, compare};

use crate::random::Random;
use crate::support::scenes::layer;
use crate::support::{Photons, bundled, student};

/// What documents and files say: the code's own must be it.
const STATED: f64 = 0.999;

#[test]
fn the_confidence_is_the_stated_one() {
    assert_eq!(CONFIDENCE, STATED);
}

/// The most misses of `trials` at the stated confidence: four standard deviations of a binomial number.
fn most_misses(trials: f64) -> f64 {
    let expected = (1.0 - STATED) * trials;
    expected + 4.0 * expected.sqrt()
}

/// Of equal weights the bounds are Garwood's of a Poisson mean, which are exact: high is the mean at which n
/// or fewer have the probability α/2, low that at which n or more have it. The formula for quantiles may only
/// be too wide.
#[test]
fn bounds_of_equal_weights_are_no_narrower_than_the_exact_ones() {
    let bounds = Bounds::new(1 << 20);
    let tail = 0.5 * (1.0 - STATED);
    for n in (0_u32..200).chain([1000, 10_000]) {
        let total = f64::from(n);
        let [low, high] = bounds.of(&Sum {
            total,
            variance: total,
            contributions: u64::from(n),
            largest: 1.0,
        });
        // P(N ≤ n; μ) = Q(n + 1, μ), of which the survival function of χ² with 2 (n + 1) degrees is made.
        let above = chi_squared_survival(2.0 * high, 2.0 * (total + 1.0));
        assert!(above <= tail * (1.0 + 1e-9), "{n}: {high}, {above}");
        assert!(low <= total && total <= high, "{n}: {low}, {high}");
        if n > 0 {
            let below = 1.0 - chi_squared_survival(2.0 * low, 2.0 * total);
            assert!(below <= tail * (1.0 + 1e-9), "{n}: {low}, {below}");
        }
        // And not much wider: the mean that has half of that probability is beyond.
        let wider = chi_squared_survival(2.0 * 1.05 * high, 2.0 * (total + 1.0));
        assert!(wider < 0.75 * tail, "{n}: {wider}");
        let exact = (2.0 / (1.0 - STATED)).ln();
        if n == 0 {
            assert!((exact..1.04 * exact).contains(&high), "{high} of {exact}");
        }
    }
}

/// A Poisson number, as arrivals of one process in a time.
fn arrivals(random: &mut Random, mean: f64) -> u64 {
    let (mut time, mut n) = (0.0, 0);
    loop {
        time -= (1.0 - random.uniform()).ln();
        if time > mean {
            return n;
        }
        n += 1;
    }
}

/// Compound Poisson sums of known mean: equal weights, weights from 0 to the largest, and few that are 25
/// times as large as the many, as where glass reflects and transmits.
#[test]
fn bounds_cover_sums_of_any_number_of_contributions() {
    const REPLICATES: usize = 32;
    const TRIALS: usize = 20_000;
    let bounds = Bounds::new(REPLICATES as u32);
    type Weight = fn(&mut Random) -> f64;
    let weights: [(&str, f64, Weight); 3] = [
        ("equal", 1.0, |_| 1.0),
        ("even", 0.5, |random| random.uniform()),
        ("mixed", 0.088, |random| {
            if random.uniform() < 0.05 { 1.0 } else { 0.04 }
        }),
    ];
    let mut random = Random(1);
    for (name, mean, weight) in weights {
        for expected in [0.01, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 160.0, 500.0] {
            let mut misses = [0; 2];
            for _ in 0..TRIALS {
                let n = arrivals(&mut random, expected);
                let mut sums = [0.0; REPLICATES];
                for _ in 0..n {
                    let replicate = (random.uniform() * REPLICATES as f64) as usize;
                    sums[replicate] += weight(&mut random);
                }
                let total: f64 = sums.iter().sum();
                let squares: f64 = sums.iter().map(|sum| sum * sum).sum();
                let r = REPLICATES as f64;
                let [low, high] = bounds.of(&Sum {
                    total,
                    variance: (squares - total * total / r) * r / (r - 1.0),
                    contributions: n,
                    largest: 1.0,
                });
                misses[0] += u32::from(mean * expected < low);
                misses[1] += u32::from(mean * expected > high);
            }
            let all = f64::from(misses[0] + misses[1]);
            println!("{name}, {expected} expected: {misses:?} of {TRIALS} below and above");
            assert!(
                all <= most_misses(TRIALS as f64),
                "{name}, {expected}: {misses:?}"
            );
        }
    }
}

/// A glass ball's caustic at so few photons that most texels have none, and at many; the truth is a closed
/// form.
#[test]
fn bounds_cover_the_closed_form_in_texels_of_any_brightness() {
    const SIDE: usize = 48;
    const SEEDS: u64 = 16;
    let scene = bundled("glass-ball", SIDE);
    let path = KnownPath::Through(0);
    let truth = GlassBall::SHIPPED
        .sheet(path)
        .map(&TexelGrid::square(2.0, SIDE));
    // By the number of photons of all layers that a texel gets on average: none, ..., many.
    let mut classes = [[0.0_f64; 2]; 6];
    let class = |expected: f64| match expected {
        0.0 => 0,
        it if it <= 0.3 => 1,
        it if it <= 3.0 => 2,
        it if it <= 30.0 => 3,
        it if it <= 300.0 => 4,
        _ => 5,
    };
    let mut dark = 0;
    for photons in [1 << 11, 1 << 14, 1 << 18] {
        let runs: Vec<_> = (0..SEEDS)
            .map(|seed| Photons::new(photons).seed(100 + seed).estimate(&scene))
            .collect();
        for (texel, &true_value) in truth.iter().enumerate() {
            let counts: u64 = runs.iter().map(|run| run.counts[texel]).sum();
            let class = &mut classes[class(counts as f64 / SEEDS as f64)];
            for run in &runs {
                let layer = run
                    .layers
                    .iter()
                    .find(|layer| layer.name.to_string() == path.signature())
                    .unwrap();
                let bounds = layer.sampling.as_ref().unwrap();
                let [low, high] = [bounds.low[texel].0[0], bounds.high[texel].0[0]];
                let value = layer.values[texel].0[0];
                assert!(low <= value && value <= high);
                // Nothing is known to be dark: not 0 ± 0.
                assert!(high > 0.0);
                dark += u32::from(true_value > 0.0 && value == 0.0);
                class[0] += 1.0;
                class[1] += f64::from(u8::from(true_value < low || true_value > high));
            }
        }
    }
    println!("{dark} lit texels that no photon reached");
    assert!(dark > 1000);
    for (name, [texels, misses]) in [
        "no photon",
        "up to 0.3",
        "up to 3",
        "up to 30",
        "up to 300",
        "more",
    ]
    .iter()
    .zip(classes)
    {
        println!("{name}: {misses} of {texels} texels are not covered");
        assert!(texels >= 1000.0, "{name}");
        assert!(misses <= most_misses(texels), "{name}");
    }
}

/// Where photons are many, bounds are as wide as the standard error's interval of the same confidence.
#[test]
fn bounds_of_many_photons_are_those_of_the_standard_error() {
    let scene = bundled("glass-ball", 16);
    let estimate = Photons::new(1 << 20).seed(3).estimate(&scene);
    let (_, errors) = layer(&estimate, "LTTD", 0);
    let found = estimate
        .layers
        .iter()
        .find(|it| it.name.to_string() == "LTTD")
        .unwrap();
    let bounds = found.sampling.as_ref().unwrap();
    let quantile = student::two_sided_quantile(1.0 - STATED, 31);
    let mut judged = 0;
    for (texel, error) in errors.iter().enumerate() {
        if estimate.counts[texel] < 20_000 {
            continue;
        }
        judged += 1;
        let width = 0.5 * (bounds.high[texel].0[0] - bounds.low[texel].0[0]);
        let ratio = width / (quantile * error);
        // One more photon, of 20,000.
        assert!((0.999..1.02).contains(&ratio), "{ratio}");
    }
    assert!(judged >= 4, "{judged}");
}

/// Of a layer with few contributions the largest is not known by them; on a surface no contribution is larger
/// than a photon at its start, on a camera nothing is known but other layers'.
#[test]
fn the_largest_contribution_of_a_dim_layer_is_not_taken_from_the_few_it_got() {
    let with = |flux: f64, contributions: u64| Largest {
        flux: Rgb::grey(flux),
        emitted: Rgb::grey(5.0),
        contributions,
    };
    let all = with(3.0, ENOUGH + 10);
    let of = |layer: &Largest, is_camera| largest_possible(layer, &all, is_camera).0[0];
    assert_eq!(of(&with(2.0, ENOUGH), false), 2.0);
    assert_eq!(of(&with(2.0, ENOUGH - 1), false), 5.0);
    // Shading normals may add to what sets out.
    assert_eq!(of(&with(6.0, 10), false), 6.0);
    assert_eq!(of(&with(2.0, 10), true), 3.0);
    let nothing = with(0.0, 0);
    assert!(largest_possible(&nothing, &nothing, true).0[0].is_nan());
}

/// A film of few photons against one of many: texels of few take part by their bounds, others by their
/// standard errors, and no scatter counts twice.
#[test]
fn films_of_photons_are_compared_by_bounds_where_photons_are_few_and_by_standard_errors_elsewhere()
{
    let scene = bundled("glass-ball", 32);
    let sensor = crate::support::scenes::meter(&scene);
    let film = |photons: u64, seed: u64| {
        let given = [("seed".to_owned(), seed.to_string())].into();
        let method = Method::new("photons", &given).unwrap();
        let budget = Budget::work(photons);
        let rendering = method
            .run(&scene, sensor, &budget, &Context::default())
            .unwrap();
        CompareImage::new(format!("{seed}.exr"), rendering.image(&scene))
    };
    let [few, many] = [film(1 << 18, 1), film(1 << 21, 2)];
    assert!(few.image.channel("LTTD.lo.R").is_some() && few.image.channel("LTTD.hi.R").is_some());
    assert!(
        few.image
            .metadata("confidence")
            .unwrap()
            .starts_with("0.999")
    );
    let report = compare(&many, &few, &CompareSettings::default()).unwrap();
    let layer = report.layers.iter().find(|it| it.layer == "LTTD").unwrap();
    let tests = layer.significance.as_ref().unwrap();
    println!("{tests:?}");
    assert!(!tests.has_bounds && tests.untested == 0);
    assert!(
        tests.few > 500 && tests.tests > 30,
        "{} {}",
        tests.few,
        tests.tests
    );
    assert!(!tests.family.different);
    // ν/(ν − 2) of 31 degrees of freedom is 1.07, and 3/100 more at most; four standard deviations of a mean
    // of χ².
    let off = 4.0 * (2.0 / tests.tests as f64).sqrt();
    assert!(
        (tests.mean_square_z - 1.08).abs() < 1.1 * off,
        "{}",
        tests.mean_square_z
    );
}

/// Sums over replicates of contributions that arrive by chance, as many as `expected` in the mean: T, the
/// square of its standard error, and whether there is one.
fn simulated(
    random: &mut Random,
    expected: f64,
    weight: fn(&mut Random) -> f64,
) -> Option<[f64; 2]> {
    const REPLICATES: usize = 32;
    let mut sums = [0.0; REPLICATES];
    for _ in 0..arrivals(random, expected) {
        let replicate = (random.uniform() * REPLICATES as f64) as usize;
        sums[replicate] += weight(random);
    }
    let r = REPLICATES as f64;
    let total: f64 = sums.iter().sum();
    let squares: f64 = sums.iter().map(|sum| sum * sum).sum();
    let variance = (squares - total * total / r) * r / (r - 1.0);
    (variance > 0.0).then_some([total, variance])
}

/// Of a skewed variable T and its error σ from n replicates, E z² = ν/(ν − 2) + 2 γ², with γ the skewness of
/// T, to first order in γ² (Hall 1992, *The Bootstrap and Edgeworth Expansion*, section 2.6). A compound
/// Poisson sum has γ² = s/k, k = (E T)²/σ² and s = (E w)² (E w³)²/(E w²)⁴: 1 for equal weights, 9/4 for
/// exponential ones.
#[test]
fn squares_of_z_are_too_large_by_the_skewness_of_few_contributions() {
    const TRIALS: u32 = 60_000;
    type Weight = fn(&mut Random) -> f64;
    let cases: [(&str, f64, f64, Weight); 2] = [
        ("equal", 1.0, 1.0, |_| 1.0),
        ("exponential", 2.0, 2.25, |random| {
            -(1.0 - random.uniform()).ln()
        }),
    ];
    let mut random = Random(7);
    for (name, square, skew, weight) in cases {
        for k in [50.0, 100.0] {
            let expected = k * square;
            let squares: Vec<f64> = (0..TRIALS)
                .filter_map(|_| simulated(&mut random, expected, weight))
                .map(|[total, variance]| (total - expected) * (total - expected) / variance)
                .collect();
            let count = squares.len() as f64;
            let mean = squares.iter().sum::<f64>() / count;
            let scatter = squares
                .iter()
                .map(|it| (it - mean) * (it - mean))
                .sum::<f64>();
            let off = (scatter / count / count).sqrt();
            let said = student::moments(31).variance + 2.0 * skew / k;
            println!("{name}, k = {k}: {mean:.3} ± {off:.3}, {said:.3} by the skewness");
            // The next order is (γ²)², with a factor of a few.
            let next = 4.0 * (skew / k) * (skew / k);
            assert!(
                (mean - said).abs() < 4.0 * off + next,
                "{name}, {k}: {mean}, {said}"
            );
        }
    }
}

/// Texels are chosen by (T/σ)² with σ as it is found. Where texels of k thin out as 1/k from one size of k to
/// the next, those that are chosen have σ too small more often than too large: E z² = ν/(ν − 4), whatever the
/// threshold.
#[test]
fn squares_of_z_are_too_large_where_texels_are_chosen_by_their_own_errors() {
    const TRIALS: u32 = 150_000;
    let mut random = Random(11);
    for threshold in [60.0, 120.0] {
        let (mut count, mut sum, mut fourth) = (0.0, 0.0, 0.0);
        for _ in 0..TRIALS {
            // From far below the threshold, so that all that may be chosen are there.
            let k = 0.25 * threshold / (1.0 - 0.98 * random.uniform());
            let Some([total, variance]) = simulated(&mut random, k, |_| 1.0) else {
                continue;
            };
            if total * total >= threshold * variance {
                let square = (total - k) * (total - k) / variance;
                (count, sum, fourth) = (count + 1.0, sum + square, fourth + square * square);
            }
        }
        let mean: f64 = sum / count;
        let off = ((fourth / count - mean * mean) / count).sqrt();
        let said = 31.0 / 27.0;
        println!("from {threshold}: {mean:.3} ± {off:.3} of {count}, {said:.3} by the choice");
        // T takes part in the choice, too, and is skewed: a few times 1/k.
        assert!(
            (mean - said).abs() < 4.0 * off + 3.0 / threshold,
            "{mean}, {said}"
        );
        assert!(mean - 4.0 * off > student::moments(31).variance, "{mean}");
    }
}

/// One photon in each of 32 replicates has no scatter among them, by chance or since Sobol' points are even.
/// Up to four a replicate, bounds are those of as many photons that scatter as chance has it; of more, the
/// scatter counts.
#[test]
fn contributions_that_replicates_share_evenly_have_the_bounds_of_their_number() {
    let bounds = Bounds::new(32);
    let of = |n: u32, variance: f64| {
        bounds.of(&Sum {
            total: f64::from(n),
            variance,
            contributions: u64::from(n),
            largest: 1.0,
        })
    };
    for n in [1, 8, 32, 128] {
        assert_eq!(of(n, 0.0), of(n, f64::from(n)), "{n}");
    }
    let [even, scattered] = [0.0, 160.0].map(|variance| of(160, variance));
    assert!(even[0] > scattered[0] && even[1] < scattered[1]);
}
