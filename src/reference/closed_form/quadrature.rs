//! Integrals of functions that are smooth inside an interval, if not at its ends.

use std::f64::consts::PI;
use std::sync::LazyLock;

const NODES: usize = 16;

/// ∫ f over [a, b], for f analytic inside, with at most square-root behaviour at either end.
///
/// Gauss-Legendre of 16 nodes in v after u = a + (b − a)(1 − cos πv)/2: near an end u − a ∝ v², so √(u − a) is
/// analytic in v. The interval is cut into `panels` first.
pub(super) fn integrate(a: f64, b: f64, panels: usize, mut f: impl FnMut(f64) -> f64) -> f64 {
    let width = (b - a) / panels as f64;
    let mut sum = 0.0;
    for panel in 0..panels {
        let start = a + width * panel as f64;
        for &(place, weight) in RULE.iter() {
            sum += weight * f(start + width * place);
        }
    }
    sum * width
}

/// (place in 0..1, weight), the substitution included.
static RULE: LazyLock<[(f64, f64); NODES]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let (node, weight) = gauss_legendre(i);
        let angle = PI * f64::midpoint(1.0, node);
        let half_sin = (0.5 * angle).sin();
        (half_sin * half_sin, 0.25 * PI * weight * angle.sin())
    })
});

/// The i-th node and weight of Gauss-Legendre quadrature on [−1, 1], by Newton's method on the Legendre
/// polynomial P_n, with w = 2 / ((1 − x²) P_n'(x)²).
fn gauss_legendre(i: usize) -> (f64, f64) {
    let n = NODES as f64;
    let mut x = -(PI * (i as f64 + 0.75) / (n + 0.5)).cos();
    let mut slope = 1.0;
    // The start is within O(n⁻³) of the root and convergence quadratic: 6 steps are plenty.
    for _ in 0..6 {
        let (mut before, mut value) = (1.0, x);
        for degree in 2..=NODES {
            let k = degree as f64;
            (before, value) = (
                value,
                ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k,
            );
        }
        slope = n * (x * value - before) / (x * x - 1.0);
        x -= value / slope;
    }
    (x, 2.0 / ((1.0 - x * x) * slope * slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_sum_to_the_interval_and_odd_powers_cancel() {
        // 16 nodes integrate polynomials of degree 31 exactly; sums of 16 numbers below 1 round by a few ulp.
        let sum = |power: i32| {
            (0..NODES)
                .map(gauss_legendre)
                .map(|(x, w)| w * x.powi(power))
                .sum::<f64>()
        };
        assert!((sum(0) - 2.0).abs() < 16.0 * f64::EPSILON);
        assert!(sum(7).abs() < 16.0 * f64::EPSILON);
        assert!((sum(30) - 2.0 / 31.0).abs() < 16.0 * f64::EPSILON);
    }

    #[test]
    fn square_roots_at_both_ends_are_integrated_to_rounding() {
        // The half disc: ∫ √(1 − x²) = π/2. In v the integrand is sin² πv (π/2), whose Gauss error
        // at 16 nodes is (π)^32 · 2^... / 32!-like, far below rounding.
        let area = integrate(-1.0, 1.0, 1, |x: f64| (1.0 - x * x).sqrt());
        assert!((area - PI / 2.0).abs() < 32.0 * f64::EPSILON, "{area}");
    }
}
