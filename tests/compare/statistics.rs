//! A comparison's verdicts on noise are true as often as it claims: hundreds of pairs of images with
//! independent normal errors are compared, and the counts of wrong answers judged by the binomial
//! distribution.

use nephroid::internals::film::Image;
use nephroid::internals::metric::{CompareSettings, LayerComparison, Verdict, compare};

use crate::support::images::{Normal, credible, grey, source};

/// Probability that a right program fails one of the assertions about counts: there are nine in this file.
const ALPHA: f64 = 1e-4;

const SIZE: [usize; 2] = [64, 64];
const TEXELS: u64 = 64 * 64;
const TRIALS: u32 = 300;
const LEVEL: f64 = 0.05;

/// A scene with contrast: values from 0.6 to 5.
fn light(x: usize, y: usize) -> f64 {
    let (x, y) = (x as f64, y as f64);
    0.6 + 4.4 / (1.0 + 0.01 * ((x - 20.0).powi(2) + (y - 40.0).powi(2)))
}

/// Errors of 2 to 6 % that are not in proportion to the light.
fn error(x: usize, y: usize) -> f64 {
    0.02 + 0.04 * light(y, x).sqrt()
}

fn settings(margin: f64) -> CompareSettings {
    CompareSettings {
        margin,
        level: LEVEL,
        pixels_per_degree: None,
        ..CompareSettings::default()
    }
}

/// All light of two images whose errors come from so many samples each.
fn compared(
    reference: Image,
    other: Image,
    samples: [Option<u64>; 2],
    margin: f64,
) -> LayerComparison {
    let [mut a, mut b] = [source("a.exr", reference), source("b.exr", other)];
    [a.samples, b.samples] = samples;
    compare(&a, &b, &settings(margin)).unwrap().layers.remove(0)
}

/// The exact image times `factor`, with normal errors of known size.
fn noisy(seed: u64, factor: f64) -> Image {
    let normal = Normal::new(seed);
    let value = |x: usize, y: usize| {
        factor * light(x, y) + error(x, y) * normal.at((x + SIZE[0] * y) as u64)
    };
    grey(SIZE, value, Some(&error))
}

/// The mean of n normal samples a texel, and its standard error from their scatter.
fn sampled(seed: u64, samples: u64) -> Image {
    let normal = Normal::new(seed);
    let n = samples as f64;
    let draw = |x: usize, y: usize| -> [f64; 2] {
        let texel = (x + SIZE[0] * y) as u64;
        let values: Vec<f64> = (0..samples)
            .map(|i| light(x, y) + error(x, y) * n.sqrt() * normal.at(i * TEXELS + texel))
            .collect();
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        [mean, (squares / (n - 1.0) / n).sqrt()]
    };
    grey(SIZE, |x, y| draw(x, y)[0], Some(&|x, y| draw(x, y)[1]))
}

fn assert_credible(what: &str, count: u32, trials: u32, probability: f64) {
    let range = credible(trials, probability, ALPHA);
    assert!(
        range.contains(&count),
        "{what}: {count} of {trials}, credible are {range:?}"
    );
}

#[test]
fn equal_images_are_called_different_as_often_as_the_level_says() {
    let (mut different, mut not_uniform, mut squares) = (0, 0, 0.0);
    for trial in 0..TRIALS {
        let seed = 2 * u64::from(trial);
        let it = compared(noisy(seed, 1.0), noisy(seed + 1, 1.0), [None; 2], 0.01);
        let found = it.significance.unwrap();
        assert_eq!(found.tests, TEXELS);
        different += u32::from(found.family.different);
        not_uniform += u32::from(!found.uniformity.unwrap().uniform);
        squares += found.mean_square_z;
    }
    assert_credible("family", different, TRIALS, LEVEL);
    assert_credible("uniformity", not_uniform, TRIALS, LEVEL);
    // z² has mean 1 and variance 2; values are stored to 6e-8, far below their errors. Six deviations.
    let deviation = (2.0 / (f64::from(TRIALS) * TEXELS as f64)).sqrt();
    let mean = squares / f64::from(TRIALS);
    assert!((mean - 1.0).abs() < 6.0 * deviation, "{mean}");
}

#[test]
fn errors_from_few_samples_are_judged_by_students_distribution() {
    // Against exact values: t with 7 degrees of freedom, exactly.
    let trials = 60;
    let (mut different, mut not_uniform) = (0, 0);
    for trial in 0..trials {
        let exact = grey(SIZE, light, None);
        let found = compared(exact, sampled(u64::from(trial), 8), [None, Some(8)], 0.01);
        let found = found.significance.unwrap();
        // σ⁴ / (σ⁴ / 7): three roundings.
        let freedom = found.extreme.unwrap().freedom.unwrap();
        assert!((freedom - 7.0).abs() < 1e-14, "{freedom}");
        different += u32::from(found.family.different);
        not_uniform += u32::from(!found.uniformity.unwrap().uniform);
    }
    assert_credible("family", different, trials, LEVEL);
    assert_credible("uniformity", not_uniform, trials, LEVEL);
    // The same taken for normal numbers: the largest of 4096 is beyond in nearly every image.
    let found = compared(grey(SIZE, light, None), sampled(1, 8), [None; 2], 0.01);
    assert!(found.significance.unwrap().family.different);
}

#[test]
fn welchs_degrees_of_freedom_make_p_values_uniform_for_unequal_samples() {
    // Welch's distribution is not Student's exactly; for 8 and 24 samples it is so to some 1e-3 in the
    // probability, where a bin's share of 1/20 is known to 3e-3 here.
    let trials = 60;
    let mut not_uniform = 0;
    for trial in 0..trials {
        let seed = 2 * u64::from(trial) + 1000;
        let samples = [Some(8), Some(24)];
        let it = compared(sampled(seed, 8), sampled(seed + 1, 24), samples, 0.01);
        not_uniform += u32::from(!it.significance.unwrap().uniformity.unwrap().uniform);
    }
    assert_credible("uniformity", not_uniform, trials, LEVEL);
}

#[test]
fn a_bias_as_large_as_the_margin_is_called_equivalent_as_often_as_the_level_says() {
    // The mean has a standard error of some 0.05 %: the other of both one-sided tests has no say.
    let margin = 0.01;
    let (mut equivalent, mut different, mut covered) = (0, 0, 0);
    for trial in 0..TRIALS {
        let exact = grey(SIZE, light, None);
        let other = noisy(u64::from(trial) + 5000, 1.0 + margin);
        let bias = compared(exact, other, [None; 2], margin).equivalence.bias;
        match bias.verdict {
            Verdict::Equivalent => equivalent += 1,
            Verdict::Different => different += 1,
            Verdict::Undecided => {}
        }
        let [low, high] = bias.interval.unwrap();
        covered += u32::from((low..=high).contains(&margin));
    }
    assert_credible("equivalent", equivalent, TRIALS, LEVEL);
    assert_credible("different", different, TRIALS, LEVEL);
    assert_credible("covered", covered, TRIALS, 1.0 - LEVEL);
}

#[test]
fn equal_images_are_shown_to_be_equivalent_and_far_ones_different() {
    for trial in 0..20u64 {
        let seed = 2 * trial + 9000;
        // 1 % is some ten standard errors of the mean here, 2 % twenty.
        let it = compared(noisy(seed, 1.0), noisy(seed + 1, 1.0), [None; 2], 0.01);
        assert_eq!(it.equivalence.bias.verdict, Verdict::Equivalent);
        let it = compared(noisy(seed, 1.0), noisy(seed + 1, 1.02), [None; 2], 0.01);
        assert_eq!(it.equivalence.bias.verdict, Verdict::Different);
        assert_eq!(it.equivalence.verdict, Verdict::Different);
    }
}

#[test]
fn differences_below_the_noise_are_measured_and_covered_by_their_interval() {
    // Every other texel is brighter, every other darker, by 3 % of the light's root mean square; noise is
    // about 3 %, too.
    let mean_square = (0..TEXELS as usize)
        .map(|i| light(i % SIZE[0], i / SIZE[0]).powi(2))
        .sum::<f64>()
        / TEXELS as f64;
    let size = mean_square.sqrt();
    let truth = 0.03;
    let board = |x: usize, y: usize| if (x + y).is_multiple_of(2) { 1.0 } else { -1.0 };
    let (mut below, mut above, mut different) = (0, 0, 0);
    for trial in 0..TRIALS {
        let normal = Normal::new(u64::from(trial) + 20000);
        let value = |x: usize, y: usize| {
            let noise = error(x, y) * normal.at((x + SIZE[0] * y) as u64);
            light(x, y) + truth * size * board(x, y) + noise
        };
        let other = grey(SIZE, value, Some(&error));
        let it = compared(grey(SIZE, light, None), other, [None; 2], truth);
        let texels = it.equivalence.texels;
        let [low, high] = texels.interval.unwrap();
        below += u32::from(high < truth);
        above += u32::from(low > truth);
        different += u32::from(texels.verdict == Verdict::Different);
        // The mean is the same in both, up to the noise.
        assert_eq!(it.equivalence.bias.verdict, Verdict::Equivalent);
    }
    assert_eq!(different, above);
    assert_credible("above", above, TRIALS, LEVEL);
    assert_credible("below", below, TRIALS, LEVEL);
}

#[test]
fn bars_that_are_too_small_or_shared_noise_show_in_the_scores() {
    let half = |image: Image| {
        let mut image = image;
        let errors = image
            .channels
            .iter_mut()
            .find(|c| c.name == "stderr.Y")
            .unwrap();
        errors.samples.iter_mut().for_each(|error| *error *= 0.5);
        image
    };
    let it = compared(half(noisy(1, 1.0)), half(noisy(2, 1.0)), [None; 2], 0.01);
    let found = it.significance.unwrap();
    // Four times too large: mean 4, deviation 4 √(2 / 4096) = 0.09.
    assert!(
        (found.mean_square_z - 4.0).abs() < 0.5,
        "{}",
        found.mean_square_z
    );
    assert!(!found.uniformity.unwrap().uniform);
    let shared = compared(noisy(3, 1.0), noisy(3, 1.0), [None; 2], 0.01);
    assert_eq!(shared.significance.unwrap().mean_square_z, 0.0);
}

#[test]
fn bounds_explain_what_lies_within_and_p_values_are_then_not_called_uniform() {
    let with_bounds = |half: f64| {
        let mut image = grey(SIZE, light, None);
        let texels = || (0..TEXELS as usize).map(|i| light(i % SIZE[0], i / SIZE[0]));
        image.add_scalar("lo.Y", texels().map(|value| value - half));
        image.add_scalar("hi.Y", texels().map(|value| value + half));
        image
    };
    // Errors up to 0.12: bounds of ± 0.6 are five of them.
    let it = compared(with_bounds(0.6), noisy(7, 1.0), [None; 2], 0.01);
    let found = it.significance.unwrap();
    assert!(found.has_bounds && found.uniformity.is_none() && !found.family.different);
    assert_eq!(it.equivalence.texels.unexplained, Some(0.0));
    // A texel beyond its bound by a tenth of its value, exactly known: a contradiction.
    let wrong = grey(
        SIZE,
        |x, y| light(x, y) * if (x, y) == (5, 6) { 1.2 } else { 1.0 },
        None,
    );
    let found = compared(with_bounds(0.01), wrong, [None; 2], 0.01)
        .significance
        .unwrap();
    let extreme = found.extreme.unwrap();
    assert!(found.family.different);
    assert_eq!((extreme.x, extreme.y), (5, 6));
}
