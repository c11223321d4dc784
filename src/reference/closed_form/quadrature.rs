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

/// Number of times that an interval is halved in the search for windows.
const WINDOW_LEVELS: i32 = 10;

/// Number of parts of a window, two for each of the least that an interval has. Functions that are smooth
/// over the interval have no more than two roots in such a part.
pub(super) fn parts_of(window: (f64, f64), (from, to): (f64, f64)) -> usize {
    let least = (to - from) * math::powi(0.5, WINDOW_LEVELS);
    2 * ((window.1 - window.0) / least).round().max(1.0) as usize
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
        if depth < WINDOW_LEVELS {
            open.push((middle, b, depth + 1));
            open.push((a, middle, depth + 1));
        } else {
            found.push((a, b));
        }
    }
    found
}

/// Places at which any of some smooth functions changes its sign, in rising order. Values are compared at
/// the ends of this many parts; where they fall and rise again, at the vertex of a parabola, too. The start
/// of a part counts if a function is zero there and not at the part's end. Functions that are not finite at a
/// place are left out there.
pub(super) fn sign_changes<const N: usize>(
    (from, to): (f64, f64),
    parts: usize,
    functions: impl Fn(f64) -> [f64; N],
) -> Vec<f64> {
    let mut found = Vec::new();
    let step = (to - from) / parts as f64;
    let values: Vec<(f64, [f64; N])> = (0..=parts)
        .map(|index| from + step * index as f64)
        .map(|place| (place, functions(place)))
        .collect();
    for i in 0..N {
        let function = |place: f64| functions(place)[i];
        let mut search = |a: (f64, f64), b: (f64, f64)| {
            if a.1 * b.1 < 0.0 && (a.1 - b.1).is_finite() {
                found.push(root(a, b, function));
            } else if a.1 == 0.0 && b.1 != 0.0 {
                found.push(a.0);
            }
        };
        let at = |index: usize| (values[index].0, values[index].1[i]);
        for index in 0..parts {
            search(at(index), at(index + 1));
        }
        for index in 1..parts {
            let three = [at(index - 1), at(index), at(index + 1)];
            if let Some(vertex) = vertex(three) {
                let vertex = (vertex, function(vertex));
                // A second pair of roots would be in the other half.
                let other = three[usize::from(vertex.0 >= three[1].0) * 2];
                search(three[1], vertex);
                search(vertex, other);
            }
        }
    }
    found.retain(|place| place.is_finite());
    found.sort_unstable_by(f64::total_cmp);
    found
}

/// The place of a parabola's vertex, given three of its points at even distances. `None` unless these are all
/// on one side of zero, and the vertex on the other, give or take a tenth of the second difference.
fn vertex([a, b, c]: [(f64, f64); 3]) -> Option<f64> {
    let step = b.0 - a.0;
    let (slope, bend) = (0.5 * (c.1 - a.1), a.1 - 2.0 * b.1 + c.1);
    let is_one_side = a.1 * b.1 > 0.0 && b.1 * c.1 > 0.0;
    let offset = -slope / bend;
    if !is_one_side || bend * b.1 <= 0.0 || offset.abs() > 1.0 {
        return None;
    }
    let depth = b.1 + 0.5 * slope * offset;
    (depth * b.1.signum() < 0.1 * bend.abs()).then_some(b.0 + offset * step)
}

/// A root between two places with values of opposite sign, by the Illinois variant of the false position:
/// the value at an end that stays is halved.
fn root(
    (mut a, mut at_a): (f64, f64),
    (mut b, mut at_b): (f64, f64),
    function: impl Fn(f64) -> f64,
) -> f64 {
    // Each three steps raise the error to its third power; a root of a higher order takes longer.
    for _ in 0..40 {
        let place = (a * at_b - b * at_a) / (at_b - at_a);
        let value = function(place);
        if value == 0.0 || place == a || place == b {
            return place;
        }
        if value * at_b < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        (b, at_b) = (place, value);
    }
    b
}

/// The integral over an interval of f that has kinks at these rising places alone: each part between two is
/// allowed its share of the tolerance.
pub(super) fn simpson_between(
    (from, to): (f64, f64),
    kinks: &[f64],
    tolerance: f64,
    f: &impl Fn(f64) -> f64,
) -> f64 {
    let each = tolerance / (kinks.len() + 1) as f64;
    let starts = std::iter::once(from).chain(kinks.iter().copied());
    let ends = kinks.iter().copied().chain(std::iter::once(to));
    let parts = starts.zip(ends).filter(|(a, b)| a < b);
    parts.map(|(a, b)| simpson_of_smooth(a, b, each, f)).sum()
}

/// Adaptive Simpson quadrature: the error is about `tolerance` for continuous f with kinks.
pub(super) fn simpson(a: f64, b: f64, tolerance: f64, f: &impl Fn(f64) -> f64) -> f64 {
    // Four starts, so that no symmetry of f about the middle hides its ends.
    let width = 0.25 * (b - a);
    (0..4)
        .map(|i| {
            let from = a + width * f64::from(i);
            simpson_of_smooth(from, from + width, 0.25 * tolerance, f)
        })
        .sum()
}

/// The same for f without kinks: five values tell whether more are needed.
fn simpson_of_smooth(from: f64, to: f64, tolerance: f64, f: &impl Fn(f64) -> f64) -> f64 {
    let (start, middle, end) = (f(from), f(f64::midpoint(from, to)), f(to));
    let panel = Panel {
        from,
        to,
        start,
        middle,
        end,
    };
    halved(&panel, tolerance, 30, f)
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
