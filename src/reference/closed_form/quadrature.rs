//! Integrals of one variable: of functions that are smooth inside an interval, and of such with kinks.

use std::f64::consts::PI;
use std::sync::LazyLock;

use crate::numeric::math;

const NODES: usize = 16;

/// ∫ f over [a, b], for f analytic inside, with at most square-root behaviour at either end.
///
/// Gauss-Legendre of 16 nodes in v after u = a + (b − a)(1 − cos πv)/2: near an end u − a ∝ v², so √(u − a)
/// is analytic in v. The interval is cut into `panels` first.
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

/// The parts of [from, to] in which `near(middle, half width)` may hold, cut to 1/1024 of it and neighbours
/// joined.
pub(super) fn windows(from: f64, to: f64, near: &impl Fn(f64, f64) -> bool) -> Vec<(f64, f64)> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut open = vec![(from, to, 0)];
    while let Some((a, b, depth)) = open.pop() {
        let middle = f64::midpoint(a, b);
        if !near(middle, 0.5 * (b - a)) {
            continue;
        }
        if depth < 10 {
            open.push((middle, b, depth + 1));
            open.push((a, middle, depth + 1));
        } else {
            found.push((a, b));
        }
    }
    found
}

/// Adaptive Simpson quadrature: the error is about `tolerance` for continuous f with kinks.
pub(super) fn simpson(a: f64, b: f64, tolerance: f64, f: &impl Fn(f64) -> f64) -> f64 {
    // Four starts, so that no symmetry of f about the middle hides its ends.
    let width = 0.25 * (b - a);
    (0..4)
        .map(|i| {
            let (from, to) = (a + width * f64::from(i), a + width * f64::from(i + 1));
            let (start, middle, end) = (f(from), f(f64::midpoint(from, to)), f(to));
            halved(
                &Panel {
                    from,
                    to,
                    start,
                    middle,
                    end,
                },
                0.25 * tolerance,
                30,
                f,
            )
        })
        .sum()
}

struct Panel {
    from: f64,
    to: f64,
    start: f64,
    middle: f64,
    end: f64,
}

impl Panel {
    pub(super) fn simpson(&self) -> f64 {
        (self.to - self.from) / 6.0 * (self.start + 4.0 * self.middle + self.end)
    }
}

fn halved(panel: &Panel, tolerance: f64, depth: u32, f: &impl Fn(f64) -> f64) -> f64 {
    let middle = f64::midpoint(panel.from, panel.to);
    let left = Panel {
        from: panel.from,
        to: middle,
        start: panel.start,
        middle: f(f64::midpoint(panel.from, middle)),
        end: panel.middle,
    };
    let right = Panel {
        from: middle,
        to: panel.to,
        start: panel.middle,
        middle: f(f64::midpoint(middle, panel.to)),
        end: panel.end,
    };
    let (whole, parts) = (panel.simpson(), left.simpson() + right.simpson());
    let difference = parts - whole;
    if depth == 0 || difference.abs() <= 15.0 * tolerance {
        return parts + difference / 15.0;
    }
    halved(&left, 0.5 * tolerance, depth - 1, f) + halved(&right, 0.5 * tolerance, depth - 1, f)
}

/// (place in 0..1, weight), the substitution included.
static RULE: LazyLock<[(f64, f64); NODES]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let (node, weight) = gauss_legendre(i);
        let angle = PI * f64::midpoint(1.0, node);
        let half_sin = math::sin(0.5 * angle);
        (half_sin * half_sin, 0.25 * PI * weight * math::sin(angle))
    })
});

/// The i-th node and weight of Gauss-Legendre quadrature on [−1, 1], by Newton's method on the Legendre
/// polynomial P of degree 16, with w = 2 / ((1 − x²) P'(x)²).
fn gauss_legendre(i: usize) -> (f64, f64) {
    let n = NODES as f64;
    let mut x = -math::cos(PI * (i as f64 + 0.75) / (n + 0.5));
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
                .map(|(x, w)| w * math::powi(x, power))
                .sum::<f64>()
        };
        assert!((sum(0) - 2.0).abs() < 16.0 * f64::EPSILON);
        assert!(sum(7).abs() < 16.0 * f64::EPSILON);
        assert!((sum(30) - 2.0 / 31.0).abs() < 16.0 * f64::EPSILON);
    }

    #[test]
    fn kinks_and_square_roots_inside_are_found() {
        let kinked = |x: f64| (x - 0.3).abs() + (x - 0.7).abs().sqrt();
        let exact =
            0.5 * (0.09 + 0.49) + 2.0 / 3.0 * (math::powf(0.7_f64, 1.5) + math::powf(0.3_f64, 1.5));
        let sum = simpson(0.0, 1.0, 1e-9, &kinked);
        // The estimate is good to a small factor at a kink.
        assert!((sum - exact).abs() < 1e-8, "{sum} {exact}");
    }

    #[test]
    fn square_roots_at_both_ends_are_integrated_to_rounding() {
        // The half disc: ∫ √(1 − x²) = π/2. In v the integrand is sin² πv (π/2), whose Gauss error
        // at 16 nodes is (π)^32 · 2^... / 32!-like, far below rounding.
        let area = integrate(-1.0, 1.0, 1, |x: f64| (1.0 - x * x).sqrt());
        assert!((area - PI / 2.0).abs() < 32.0 * f64::EPSILON, "{area}");
    }
}
