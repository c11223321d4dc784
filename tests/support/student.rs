//! Student's t distribution: how far an estimate may lie from the truth, in units of its own
//! standard error, when that error comes from few replicates.

use std::f64::consts::FRAC_PI_2;

/// The probability that |t| exceeds `t` with `freedom` degrees of freedom.
///
/// With t = √ν tan θ the density becomes cos^(ν−1) θ, so the tail is a quotient of two smooth
/// integrals; both by Simpson's rule, the upper one over the tail alone, so that small
/// probabilities keep their relative accuracy.
pub fn two_sided_tail(t: f64, freedom: u32) -> f64 {
    let power = i32::try_from(freedom).unwrap() - 1;
    let density = |angle: f64| angle.cos().max(0.0).powi(power);
    let from = (t.abs() / f64::from(freedom).sqrt()).atan();
    simpson(from, FRAC_PI_2, density) / simpson(0.0, FRAC_PI_2, density)
}

/// The t that |t| exceeds with probability `probability`.
pub fn two_sided_quantile(probability: f64, freedom: u32) -> f64 {
    let (mut low, mut high) = (0.0, 1e6);
    for _ in 0..100 {
        let middle: f64 = 0.5 * (low + high);
        if two_sided_tail(middle, freedom) > probability {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

fn simpson(from: f64, to: f64, value: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 2000;
    let step = (to - from) / f64::from(STEPS);
    let inner: f64 = (1..STEPS)
        .map(|i| value(from + step * f64::from(i)) * if i % 2 == 1 { 4.0 } else { 2.0 })
        .sum();
    (value(from) + inner + value(to)) * step / 3.0
}

/// Moments of t, which exist for more than six degrees of freedom.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    /// E t² = ν / (ν − 2): the variance of z-scores.
    pub variance: f64,
    /// The standard deviation of t².
    pub deviation_of_square: f64,
    /// The skewness of t².
    pub skewness_of_square: f64,
}

/// E t² = ν/(ν−2), E t⁴ = 3ν²/((ν−2)(ν−4)), E t⁶ = 15ν³/((ν−2)(ν−4)(ν−6)).
pub fn moments(freedom: u32) -> Moments {
    let n = f64::from(freedom);
    let second = n / (n - 2.0);
    let fourth = 3.0 * n * n / ((n - 2.0) * (n - 4.0));
    let sixth = 15.0 * n.powi(3) / ((n - 2.0) * (n - 4.0) * (n - 6.0));
    let variance = fourth - second * second;
    let third_central = sixth - 3.0 * second * fourth + 2.0 * second.powi(3);
    Moments {
        variance: second,
        deviation_of_square: variance.sqrt(),
        skewness_of_square: third_central / variance.powf(1.5),
    }
}

/// The standard normal x that |x| exceeds with probability `probability`.
pub fn normal_quantile(probability: f64) -> f64 {
    // With a million degrees of freedom t is normal to 1e-6 of the quantile.
    two_sided_quantile(probability, 1_000_000)
}
