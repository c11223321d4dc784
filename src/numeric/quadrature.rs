//! Integrals of functions of one variable.

use super::math;
use std::collections::BinaryHeap;

/// Nodes and weights of the Gauss-Legendre rule on [-1, 1].
///
/// With n nodes it is exact for polynomials of degree up to 2n − 1.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussLegendre {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

impl GaussLegendre {
    /// The largest number of nodes.
    pub const MAX_NODES: usize = 128;

    /// The rule with `count` nodes, ascending; `None` unless 1 ≤ `count` ≤ [`Self::MAX_NODES`].
    ///
    /// The nodes are the roots of the Legendre polynomial Pₙ, found by Newton's method from cos(π (i − 1/4) /
    /// (n + 1/2)) (Abramowitz and Stegun, 22.16.6, leading order). The weights are 2 / ((1 − x²) Pₙ'(x)²)
    /// (25.4.29).
    pub fn new(count: usize) -> Option<Self> {
        if !(1..=Self::MAX_NODES).contains(&count) {
            return None;
        }
        let mut nodes = vec![0.0; count];
        let mut weights = vec![0.0; count];
        // The rule is symmetric: the upper half gives the lower one.
        for i in 0..count.div_ceil(2) {
            let is_middle = 2 * i + 1 == count;
            let start = if is_middle {
                0.0
            } else {
                math::cos(std::f64::consts::PI * (i as f64 + 0.75) / (count as f64 + 0.5))
            };
            let node = polished_root(count, start);
            let (_, derivative) = legendre(count, node);
            let weight = 2.0 / ((1.0 - node) * (1.0 + node) * derivative * derivative);
            (nodes[i], nodes[count - 1 - i]) = (-node, node);
            (weights[i], weights[count - 1 - i]) = (weight, weight);
        }
        Some(Self { nodes, weights })
    }

    /// The nodes in [-1, 1], ascending.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// The weights, in the nodes' order; they sum to 2.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The nodes and weights on [a, b].
    pub fn on(&self, a: f64, b: f64) -> impl Iterator<Item = (f64, f64)> {
        let (center, half) = (0.5 * (a + b), 0.5 * (b - a));
        self.nodes
            .iter()
            .zip(&self.weights)
            .map(move |(x, w)| (center + half * x, half * w))
    }

    /// The rule's estimate of the integral of `f` over [a, b], without an error.
    pub fn integrate(&self, a: f64, b: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
        self.on(a, b).map(|(x, weight)| weight * f(x)).sum()
    }
}

/// A root of Pₙ near `start` by Newton's method, which converges quadratically. From the starting points
/// above four steps reach rounding for all n here; the others are to spare.
fn polished_root(degree: usize, start: f64) -> f64 {
    (0..8).fold(start, |x, _| {
        let (value, derivative) = legendre(degree, x);
        x - value / derivative
    })
}

/// Pₙ(x) and Pₙ'(x) for n ≥ 1 and |x| < 1, by Bonnet's recurrence.
fn legendre(degree: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut value) = (1.0, x);
    for n in 2..=degree {
        let n = n as f64;
        (previous, value) = (
            value,
            ((2.0 * n - 1.0) * x * value - (n - 1.0) * previous) / n,
        );
    }
    let derivative = degree as f64 * (previous - x * value) / ((1.0 - x) * (1.0 + x));
    (value, derivative)
}

/// Conditions on which an adaptive integral stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// An error estimate below this is good enough.
    pub absolute: f64,
    /// An error estimate below this fraction of the integral is good enough, too.
    pub relative: f64,
    /// The largest number of times that intervals are halved.
    pub max_subdivisions: usize,
}

/// An adaptive integral and its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integral {
    /// The value, in the unit of f times that of x.
    pub value: f64,
    /// The sum over intervals of |K₁₅ − G₇| and of the rounding of their sums. It is far above the true error
    /// of K₁₅ if f is smooth at the intervals' size. An estimate, not a bound: f is only known at its nodes.
    pub error: f64,
    /// Number of calls of f.
    pub evaluations: usize,
    /// True if `error` met the tolerance. Also false if any value of f was not finite.
    pub converged: bool,
}

/// Nodes of Kronrod's rule of 15 points, from the outermost to the middle; every second one is a node of
/// Gauss' rule of 7 (QUADPACK's `qk15`, Piessens et al., 1983).
const KRONROD_NODES: [f64; 8] = [
    0.9914553711208126,
    0.9491079123427585,
    0.8648644233597691,
    0.7415311855993945,
    0.5860872354676911,
    0.4058451513773972,
    0.20778495500789848,
    0.0,
];

/// Weights of [`KRONROD_NODES`].
const KRONROD_WEIGHTS: [f64; 8] = [
    0.022935322010529224,
    0.06309209262997856,
    0.10479001032225019,
    0.14065325971552592,
    0.1690047266392679,
    0.19035057806478542,
    0.20443294007529889,
    0.20948214108472782,
];

/// Weights of Gauss' rule for the nodes 1, 3, 5 and 7 of [`KRONROD_NODES`].
const GAUSS_WEIGHTS: [f64; 4] = [
    0.1294849661688697,
    0.27970539148927664,
    0.3818300505051189,
    0.4179591836734694,
];

/// An interval with its estimate, ordered by error.
#[derive(Clone, Copy, Debug)]
struct Subinterval {
    a: f64,
    b: f64,
    value: f64,
    error: f64,
}

impl Subinterval {
    fn new(a: f64, b: f64, f: &mut impl FnMut(f64) -> f64) -> Self {
        let (center, half) = (0.5 * (a + b), 0.5 * (b - a));
        let (mut kronrod, mut gauss, mut magnitude) = (0.0, 0.0, 0.0);
        for (i, (&node, &weight)) in KRONROD_NODES.iter().zip(&KRONROD_WEIGHTS).enumerate() {
            let offset = half * node;
            let (sum, absolute) = if node == 0.0 {
                let value = f(center);
                (value, value.abs())
            } else {
                let (left, right) = (f(center - offset), f(center + offset));
                (left + right, left.abs() + right.abs())
            };
            kronrod += weight * sum;
            magnitude += weight * absolute;
            if i % 2 == 1 {
                gauss += GAUSS_WEIGHTS[i / 2] * sum;
            }
        }
        // Sums of 8 rounded products of sums of 2: fewer than 16 roundings of at most half an epsilon of the
        // magnitudes.
        let rounding = 8.0 * f64::EPSILON * magnitude;
        Self {
            a,
            b,
            value: half * kronrod,
            error: half.abs() * ((kronrod - gauss).abs() + rounding),
        }
    }
}

impl PartialEq for Subinterval {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Subinterval {}

impl PartialOrd for Subinterval {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Subinterval {
    /// By error; by place if errors are equal, so that the order is always the same.
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.error
            .total_cmp(&other.error)
            .then(self.a.total_cmp(&other.a))
    }
}

/// The integral of `f` over [a, b] by the Gauss-Kronrod rule of 7 and 15 points, halving the interval with
/// the largest error until the tolerance is met.
///
/// The ends are never evaluated: integrable singularities there are allowed, and cost subdivisions. With b <
/// a the integral changes its sign.
///
/// ```
/// # use nephroid::internals::numeric::quadrature::{Tolerance, integrate};
/// let tolerance = Tolerance { absolute: 0.0, relative: 1e-10, max_subdivisions: 100 };
/// let integral = integrate(0.0, 1.0, tolerance, f64::exp);
/// assert!(integral.converged);
/// assert!((integral.value - (std::f64::consts::E - 1.0)).abs() <= integral.error);
/// ```
pub fn integrate(a: f64, b: f64, tolerance: Tolerance, mut f: impl FnMut(f64) -> f64) -> Integral {
    let mut intervals = BinaryHeap::from([Subinterval::new(a, b, &mut f)]);
    let mut subdivisions = 0;
    loop {
        // Each sum is made anew: running totals would keep the errors of intervals since replaced.
        let value: f64 = intervals.iter().map(|interval| interval.value).sum();
        let error: f64 = intervals.iter().map(|interval| interval.error).sum();
        let converged = error <= tolerance.absolute.max(tolerance.relative * value.abs());
        let done = Integral {
            value,
            error,
            evaluations: 15 * (2 * subdivisions + 1),
            converged: converged && value.is_finite(),
        };
        if converged || !error.is_finite() || subdivisions >= tolerance.max_subdivisions {
            return done;
        }
        let Some(worst) = intervals.pop() else {
            return done;
        };
        let middle = 0.5 * (worst.a + worst.b);
        if middle == worst.a || middle == worst.b {
            // No double lies between the ends: no better result is possible.
            return done;
        }
        subdivisions += 1;
        intervals.push(Subinterval::new(worst.a, middle, &mut f));
        intervals.push(Subinterval::new(middle, worst.b, &mut f));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding error of a sum of n terms whose magnitudes sum to `magnitude`.
    fn rounding(n: usize, magnitude: f64) -> f64 {
        n as f64 * f64::EPSILON * magnitude
    }

    #[test]
    fn rules_are_exact_for_all_degrees_they_promise() {
        for count in (1..=20).chain([63, 64, 127, 128]) {
            let rule = GaussLegendre::new(count).unwrap();
            for power in (0i32..).take(2 * count) {
                // ∫ x^p over [0, 1]. A node off by ε changes x^p by p ε x^p: relative p ε more.
                let expected = 1.0 / f64::from(power + 1);
                let got = rule.integrate(0.0, 1.0, |x| math::powi(x, power));
                let allowed = rounding(count + 2 * power as usize + 8, expected);
                assert!(
                    (got - expected).abs() <= allowed,
                    "n {count}, x^{power}: {got}"
                );
            }
        }
    }

    #[test]
    fn rules_are_not_exact_for_the_next_degree() {
        // The error for x^2n is (n!)^4 2^(2n+1) / ((2n+1) ((2n)!)²) on [-1, 1]: 8/45 for n = 2.
        let got = GaussLegendre::new(2)
            .unwrap()
            .integrate(-1.0, 1.0, |x| math::powi(x, 4));
        assert!((2.0 / 5.0 - got - 8.0 / 45.0).abs() <= rounding(8, 1.0));
    }

    #[test]
    fn nodes_are_ascending_and_inside_for_every_count() {
        for count in 1..=GaussLegendre::MAX_NODES {
            let rule = GaussLegendre::new(count).unwrap();
            assert!(rule.nodes().is_sorted_by(|a, b| a < b));
            assert!(rule.nodes()[0] > -1.0 && rule.nodes()[count - 1] < 1.0);
        }
        assert_eq!(GaussLegendre::new(0), None);
        assert_eq!(GaussLegendre::new(129), None);
    }

    #[test]
    fn kronrod_is_exact_to_degree_23_and_its_gauss_part_is_the_rule_of_7() {
        let gauss = GaussLegendre::new(7).unwrap();
        for i in 0..4 {
            assert!((gauss.nodes()[6 - i] - KRONROD_NODES[2 * i + 1]).abs() <= f64::EPSILON);
            assert!((gauss.weights()[i] - GAUSS_WEIGHTS[i]).abs() <= 4.0 * f64::EPSILON);
        }
        for power in 0..=23 {
            let interval = Subinterval::new(0.0, 1.0, &mut |x: f64| math::powi(x, power));
            let expected = 1.0 / f64::from(power + 1);
            assert!((interval.value - expected).abs() <= rounding(16 + power as usize, expected));
        }
        // The first degree at which the rule is wrong; without it the test above could not fail.
        let wrong = Subinterval::new(-1.0, 1.0, &mut |x: f64| math::powi(x, 24));
        assert!((wrong.value - 2.0 / 25.0).abs() > 1e-9);
    }

    #[test]
    fn adaptive_integrals_are_within_their_error_of_the_truth() {
        type Case = (fn(f64) -> f64, f64, f64, f64);
        let cases: [Case; 5] = [
            (math::exp, 0.0, 1.0, std::f64::consts::E - 1.0),
            (f64::sqrt, 0.0, 1.0, 2.0 / 3.0),
            (|x| 1.0 / x.sqrt(), 0.0, 4.0, 4.0),
            (|x| f64::from(u8::from(x > 0.3)), 0.0, 1.0, 0.7),
            (
                |x| math::cos(50.0 * x),
                1.0,
                0.0,
                -(math::sin(50f64) / 50.0),
            ),
        ];
        let tolerance = Tolerance {
            absolute: 1e-9,
            relative: 0.0,
            max_subdivisions: 300,
        };
        for (i, (f, a, b, truth)) in cases.into_iter().enumerate() {
            let integral = integrate(a, b, tolerance, f);
            assert!(integral.converged, "case {i}: {integral:?}");
            assert!(
                (integral.value - truth).abs() <= integral.error,
                "case {i}: {integral:?}"
            );
        }
    }

    #[test]
    fn what_cannot_converge_says_so() {
        let tolerance = Tolerance {
            absolute: 1e-9,
            relative: 0.0,
            max_subdivisions: 50,
        };
        assert!(!integrate(0.0, 1.0, tolerance, |x| 1.0 / x).converged);
        assert!(!integrate(0.0, 1.0, tolerance, |_| f64::NAN).converged);
        assert!(!integrate(0.0, f64::INFINITY, tolerance, |x| math::exp(-x)).converged);
        let few = Tolerance {
            max_subdivisions: 2,
            ..tolerance
        };
        let integral = integrate(0.0, 1.0, few, f64::sqrt);
        assert!(!integral.converged);
        assert_eq!(integral.evaluations, 75);
    }
}
