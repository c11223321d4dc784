//! Distributions of test statistics, which turn an error bar into a probability.
//!
//! Arguments outside a distribution's domain give NaN, as in `f64`'s own functions.

use super::math;
/// The probability that a standard normal variable is below `x`.
///
/// Φ(x) = erfc(−x / √2) / 2: the lower tail keeps its relative precision down to 1e-300.
pub fn normal_cdf(x: f64) -> f64 {
    0.5 * math::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

/// The x with Φ(x) = `probability`; infinite at 0 and 1.
pub fn normal_quantile(probability: f64) -> f64 {
    if probability == 0.5 {
        return 0.0;
    }
    // Exact above one half, by Sterbenz' lemma.
    let tail = probability.min(1.0 - probability);
    let mut x = normal_quantile_estimate(probability).abs();
    // Halley's steps triple the digits: the first leaves less than 1e-9, the second rounding.
    for _ in 0..2 {
        let excess = (normal_cdf(-x) - tail) * SQRT_TAU * math::exp(0.5 * x * x);
        x += excess / (1.0 - 0.5 * x * excess);
    }
    if x.is_finite() {
        if probability < 0.5 { -x } else { x }
    } else {
        // Beyond what a square's exponential can be.
        quantile(probability, |x| normal_cdf(-x))
    }
}

/// √2π.
const SQRT_TAU: f64 = 2.506_628_274_631_000_5;

/// The quantile within 4.5e-4 (Abramowitz and Stegun, 26.2.23); infinite or NaN at 0 and 1.
#[inline]
pub fn normal_quantile_estimate(probability: f64) -> f64 {
    let tail = probability.min(1.0 - probability);
    let t = (-2.0 * math::ln(tail)).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    let x = t - above / below;
    if probability < 0.5 { -x } else { x }
}

/// The probability that a variable of Student's t distribution is below `t`.
///
/// With ν degrees of freedom (any number above 0; infinite: the normal distribution), for t ≤ 0,
///
/// ```text
/// P = I_x(ν/2, 1/2) / 2,    x = ν / (ν + t²)
/// ```
///
/// (Abramowitz and Stegun, 26.7.1 and 26.5.27).
pub fn student_t_cdf(t: f64, degrees_of_freedom: f64) -> f64 {
    if t > 0.0 {
        return 1.0 - student_t_cdf(-t, degrees_of_freedom);
    }
    if degrees_of_freedom == f64::INFINITY {
        return normal_cdf(t);
    }
    if t.is_nan() || degrees_of_freedom.is_nan() || degrees_of_freedom <= 0.0 {
        return f64::NAN;
    }
    // Both x and 1 - x, without cancellation and without overflow of t².
    let ratio = t / degrees_of_freedom.sqrt();
    let squared = ratio * ratio;
    let (x, complement) = if squared.is_finite() {
        (1.0 / (1.0 + squared), squared / (1.0 + squared))
    } else {
        (0.0, 1.0)
    };
    0.5 * incomplete_beta(0.5 * degrees_of_freedom, 0.5, x, complement)
}

/// The t below which a Student variable lies with `probability`; infinite at 0 and 1.
pub fn student_t_quantile(probability: f64, degrees_of_freedom: f64) -> f64 {
    quantile(probability, |t| student_t_cdf(-t, degrees_of_freedom))
}

/// The number of standard errors that a two-sided interval of a given confidence extends each way.
///
/// For a mean of n normal values, with ν = n − 1: mean ± t s/√n covers the truth with probability
/// `confidence`. An infinite ν stands for a known standard deviation.
///
/// ```
/// # use nephroid::internals::numeric::distributions::critical_value;
/// assert!((critical_value(0.95, f64::INFINITY) - 1.959964).abs() < 1e-6);
/// assert!((critical_value(0.95, 7.0) - 2.364624).abs() < 1e-6);
/// ```
pub fn critical_value(confidence: f64, degrees_of_freedom: f64) -> f64 {
    // The upper tail itself, not 1 minus it: confidences near 1 keep their digits.
    -student_t_quantile(0.5 * (1.0 - confidence), degrees_of_freedom)
}

/// The probability that a χ² variable exceeds `x`: a goodness-of-fit test's p-value.
///
/// Q(ν/2, x/2), the upper regularised incomplete gamma function (Abramowitz and Stegun, 26.4.19).
pub fn chi_squared_survival(x: f64, degrees_of_freedom: f64) -> f64 {
    if x.is_nan() || degrees_of_freedom.is_nan() || degrees_of_freedom <= 0.0 {
        return f64::NAN;
    }
    if x <= 0.0 {
        return 1.0;
    }
    if x == f64::INFINITY {
        return 0.0;
    }
    upper_incomplete_gamma(0.5 * degrees_of_freedom, 0.5 * x)
}

/// The quantile of a symmetric distribution from its upper tail, P(X > x) for x ≥ 0.
fn quantile(probability: f64, upper_tail: impl Fn(f64) -> f64) -> f64 {
    if probability.is_nan() || !(0.0..=1.0).contains(&probability) || upper_tail(0.0).is_nan() {
        return f64::NAN;
    }
    if probability == 0.5 {
        return 0.0;
    }
    // Exact above one half, by Sterbenz' lemma.
    let tail = if probability < 0.5 {
        probability
    } else {
        1.0 - probability
    };
    let sign = if probability < 0.5 { -1.0 } else { 1.0 };
    if tail == 0.0 {
        return sign * f64::INFINITY;
    }
    // Positive doubles are ordered as their bits are. So halving the distance in bits finds the quantile in
    // 63 steps, for 1e-300 as for 1e300, without a derivative.
    let (mut below, mut above) = (0, f64::INFINITY.to_bits());
    while above - below > 1 {
        let middle = below + (above - below) / 2;
        if upper_tail(f64::from_bits(middle)) > tail {
            below = middle;
        } else {
            above = middle;
        }
    }
    sign * f64::from_bits(above)
}

/// The largest number of terms of a continued fraction or series: far more than any needs. It takes about √a
/// of them, and a ≤ 10⁸ here is more replicates than anyone will run.
const MAX_TERMS: usize = 100_000;

/// The value that Lentz's method puts in place of a denominator of zero.
const TINY: f64 = 1e-300;

/// The regularised incomplete beta function Iₓ(a, b), given that `complement` is 1 − x.
///
/// The continued fraction (Abramowitz and Stegun, 26.5.8) is used if it converges fast; else Iₓ(a, b) = 1 −
/// I₁₋ₓ(b, a) (26.5.2).
fn incomplete_beta(a: f64, b: f64, x: f64, complement: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if complement <= 0.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, complement, x);
    }
    // The logarithm of the smaller of x and 1 - x is accurate as it is; that of the other needs help.
    let ln_x = if x < 0.5 {
        math::ln(x)
    } else {
        math::ln_1p(-complement)
    };
    let ln_complement = if complement < 0.5 {
        math::ln(complement)
    } else {
        math::ln_1p(-x)
    };
    let ln_beta = math::ln_gamma(a) + math::ln_gamma(b) - math::ln_gamma(a + b);
    let front = math::exp(a * ln_x + b * ln_complement - ln_beta) / a;
    // d_1, d_2, ... of 1 / (1 + d_1 x / (1 + d_2 x / (1 + ...
    let terms = (1..MAX_TERMS).map(|n| {
        let m = (n / 2) as f64;
        if n % 2 == 0 {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        }
    });
    front / continued_fraction(1.0, terms.map(|numerator| (numerator, 1.0)))
}

/// The upper regularised incomplete gamma function Q(a, x).
///
/// Below a + 1 by the series of 1 − Q (Abramowitz and Stegun, 6.5.29), above by Legendre's continued fraction
/// (6.5.31, its even part).
fn upper_incomplete_gamma(a: f64, x: f64) -> f64 {
    let front = math::exp(a * math::ln(x) - x - math::ln_gamma(a));
    if x < a + 1.0 {
        let mut term = 1.0 / a;
        let mut sum = term;
        for n in 1..MAX_TERMS {
            term *= x / (a + n as f64);
            sum += term;
            if term < sum * f64::EPSILON {
                break;
            }
        }
        return 1.0 - front * sum;
    }
    let terms = (1..MAX_TERMS).map(|n| {
        let n = n as f64;
        (-n * (n - a), x + 2.0 * n + 1.0 - a)
    });
    front / continued_fraction(x + 1.0 - a, terms)
}

/// The value of b₀ + a₁ / (b₁ + a₂ / (b₂ + ...)) from pairs (aᵢ, bᵢ), by Lentz's method as changed by
/// Thompson and Barnett (J. Comput. Phys. 64, 1986).
fn continued_fraction(first: f64, terms: impl Iterator<Item = (f64, f64)>) -> f64 {
    let away_from_zero = |x: f64| if x == 0.0 { TINY } else { x };
    let mut value = away_from_zero(first);
    let (mut c, mut d) = (value, 0.0);
    for (numerator, denominator) in terms {
        d = 1.0 / away_from_zero(denominator + numerator * d);
        c = away_from_zero(denominator + numerator / c);
        let change = c * d;
        value *= change;
        if (change - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(got: f64, expected: f64, relative: f64) {
        let error = (got / expected - 1.0).abs();
        assert!(
            error <= relative,
            "{got:e} is off {expected:e} by {error:e} > {relative:e}"
        );
    }

    #[test]
    fn normal_probabilities_keep_their_relative_precision_in_the_tail() {
        // mpmath, 40 digits. The argument x/√2 has a rounding or two, which the tail's slope x
        // turns into 2 x² ε; erfc itself is good to an ulp or so.
        let cases = [
            (-37.0, 5.725571222524577e-300),
            (-10.0, 7.619853024160525e-24),
            (-3.0, 0.0013498980316300946),
            (-1.0, 0.15865525393145705),
            (0.0, 0.5),
            (2.0, 0.9772498680518208),
        ];
        for (x, expected) in cases {
            assert_close(normal_cdf(x), expected, (4.0 + 2.0 * x * x) * f64::EPSILON);
        }
    }

    #[test]
    fn student_probabilities_are_those_of_mpmath() {
        let cases = [
            (-1e-3, 0.5, 0.4997303238342438),
            (-30.0, 0.5, 0.058546841490053445),
            (-0.5, 1.0, 0.35241638234956674),
            (-0.5, 2.0, 0.3333333333333333),
            (-2.5, 2.0, 0.0648058601107554),
            (-30.0, 7.0, 5.89423444036657e-09),
            (-1e-3, 31.0, 0.4996042615732482),
            (-2.5, 31.0, 0.00896011340669311),
            (-30.0, 1000.0, 7.687343722021741e-142),
            (-1e-3, 1e6, 0.49960105788582454),
            (-2.5, 1e6, 0.006209744751081623),
            (-30.0, 1e6, 6.010047116831719e-198),
        ];
        for (t, nu, expected) in cases {
            // The largest terms of the exponent are logarithms of gamma functions, about
            // (ν/2) ln(ν/2) each, with an ulp or two of error; two of them, plus some hundred
            // operations elsewhere.
            let half: f64 = 0.5 * nu;
            let exponent = half * math::ln(1.0 + half);
            assert_close(
                student_t_cdf(t, nu),
                expected,
                (100.0 + 4.0 * exponent) * f64::EPSILON,
            );
        }
    }

    #[test]
    fn an_infinite_number_of_degrees_of_freedom_is_the_normal_distribution() {
        assert_eq!(student_t_cdf(-1.5, f64::INFINITY), normal_cdf(-1.5));
        assert_eq!(student_t_cdf(f64::NEG_INFINITY, 3.0), 0.0);
        assert_eq!(student_t_cdf(f64::INFINITY, 3.0), 1.0);
    }

    #[test]
    fn quantiles_invert_probabilities() {
        for p in [1e-280, 1e-9, 0.01, 0.3, 0.499, 0.501, 0.9, 0.999_999] {
            for nu in [1.0, 2.0, 7.0, 1000.0] {
                let t = student_t_quantile(p, nu);
                // The function jumps between two neighbouring doubles: the neighbour towards zero is on the
                // other side.
                let tail = |t: f64| student_t_cdf(-t.abs(), nu);
                let wanted = if p < 0.5 { p } else { 1.0 - p };
                assert!(
                    tail(t) <= wanted && tail(t.abs().next_down()) > wanted,
                    "{p} {nu} {t}"
                );
                assert_eq!(t > 0.0, p > 0.5);
            }
        }
        // t = tan(π (p - 1/2)) for one degree of freedom.
        assert_close(student_t_quantile(0.75, 1.0), 1.0, 100.0 * f64::EPSILON);
        assert_eq!(normal_quantile(0.5), 0.0);
        assert_eq!(normal_quantile(0.0), f64::NEG_INFINITY);
        assert_eq!(normal_quantile(1.0), f64::INFINITY);
    }

    #[test]
    fn normal_quantiles_are_those_that_halving_finds() {
        let even = (1..1000).map(|k| f64::from(k) / 1000.0);
        let tails = (1..=308).map(|k| math::powi(10.0, -k));
        let above = [0.5 + 1e-12, 0.5 - 1e-12, 1.0 - f64::EPSILON];
        for p in even.chain(tails).chain(above) {
            let (found, expected) = (normal_quantile(p), quantile(p, |x| normal_cdf(-x)));
            // The density is steep in the tails: x is as uncertain as the rounding of erfc's argument, and
            // near the middle as that of a probability near one half.
            let allowed = 8.0 * f64::EPSILON * (1.0 + expected.abs());
            assert!(
                (found - expected).abs() <= allowed,
                "{p}: {found} is not {expected}"
            );
            let estimate = normal_quantile_estimate(p);
            assert!(
                p < 1e-300 || (estimate - expected).abs() < 4.6e-4,
                "{p}: {estimate}"
            );
        }
    }

    #[test]
    fn chi_squared_tails_are_those_of_mpmath() {
        let cases = [
            (0.1, 1.0, 0.7518296340458492),
            (3.84, 1.0, 0.0500435212487051),
            (5.0, 10.0, 0.8911780189141513),
            (900.0, 1023.0, 0.9976115659324613),
            (1023.0, 1023.0, 0.494120089867273),
            (1200.0, 1023.0, 9.87060595616737e-05),
            (50.0, 2.0, 1.3887943864964021e-11),
        ];
        for (x, nu, expected) in cases {
            // As above: a ln x, x and ln Γ(a) of some a ln a, and some hundred operations.
            let half: f64 = 0.5 * nu;
            let scale = half * math::ln(1.0 + half) + x;
            assert_close(
                chi_squared_survival(x, nu),
                expected,
                (100.0 + 4.0 * scale) * f64::EPSILON,
            );
        }
    }

    #[test]
    fn nonsense_is_nan_and_ends() {
        for nu in [0.0, -1.0, f64::NAN] {
            assert!(student_t_cdf(-1.0, nu).is_nan());
            assert!(student_t_quantile(0.1, nu).is_nan());
            assert!(chi_squared_survival(1.0, nu).is_nan());
        }
        for p in [-0.1, 1.1, f64::NAN] {
            assert!(normal_quantile(p).is_nan());
        }
        assert!(normal_cdf(f64::NAN).is_nan());
        assert!(student_t_cdf(f64::NAN, 3.0).is_nan());
    }
}
