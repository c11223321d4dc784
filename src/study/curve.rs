//! The cost of less error: fitted orders and the Pareto front.

use serde::Serialize;

use crate::numeric::math;

/// A run's cost and error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The cost, in any unit.
    pub cost: f64,
    /// The error, relative.
    pub error: f64,
}

/// The fitted order of an error in a cost: error ∝ cost^exponent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Order {
    /// The exponent: −0.5 for independent random samples.
    pub exponent: f64,
    /// Its standard error, from the scatter about the line; `None` for fewer than three different points,
    /// which have no scatter.
    pub standard_error: Option<f64>,
    /// Number of runs to which it is fitted.
    pub points: usize,
}

impl Order {
    /// The least squares line through (log cost, log error), dimensionless:
    ///
    /// ```text
    /// b = Σ (x − x̄)(y − ȳ) / Σ (x − x̄)²,      SE² = Σ (y − ȳ − b (x − x̄))² / ((n − 2) Σ (x − x̄)²)
    /// ```
    ///
    /// Points without cost or error have no logarithm and are left out. `None` for fewer than two costs.
    /// Points that are the same to the bit are one film under several settings. A line through them and one
    /// more point has no scatter but rounding, and so no standard error.
    pub fn fit(points: &[Point]) -> Option<Self> {
        let logs: Vec<[f64; 2]> = points
            .iter()
            .filter(|point| point.cost > 0.0 && point.error > 0.0)
            .map(|point| [math::ln(point.cost), math::ln(point.error)])
            .collect();
        let n = logs.len() as f64;
        let mean = |axis: usize| logs.iter().map(|log| log[axis]).sum::<f64>() / n;
        let (x, y) = (mean(0), mean(1));
        let sum = |term: &dyn Fn(f64, f64) -> f64| -> f64 {
            logs.iter().map(|log| term(log[0] - x, log[1] - y)).sum()
        };
        let squares = sum(&|dx, _| dx * dx);
        // Costs that differ by rounding alone are one cost.
        let is_spread = squares > n * math::powi(1e-9_f64, 2);
        if logs.len() < 2 || !is_spread {
            return None;
        }
        let exponent = sum(&|dx, dy| dx * dy) / squares;
        let residual = sum(&|dx, dy| math::powi(dy - exponent * dx, 2));
        Some(Self {
            exponent,
            standard_error: (count_different(&logs) > 2)
                .then(|| (residual / ((n - 2.0) * squares)).sqrt()),
            points: logs.len(),
        })
    }
}

/// The number of points that differ.
fn count_different(points: &[[f64; 2]]) -> usize {
    let places = points.iter().enumerate();
    places
        .filter(|(i, point)| !points[..*i].contains(point))
        .count()
}

/// Marks the points that no other beats: none costs as little with less error, or less with as little.
pub fn pareto(points: &[Point]) -> Vec<bool> {
    let beats = |one: &Point, other: &Point| {
        one.cost <= other.cost
            && one.error <= other.error
            && (one.cost < other.cost || one.error < other.error)
    };
    points
        .iter()
        .map(|point| !points.iter().any(|other| beats(other, point)))
        .collect()
}

/// The median \[s\]; for an even number the mean of the two in the middle; `None` for no values.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        n if n % 2 == 1 => Some(sorted[middle]),
        _ => Some(0.5 * (sorted[middle - 1] + sorted[middle])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(cost: f64, error: f64) -> Point {
        Point { cost, error }
    }

    #[test]
    fn a_power_law_has_its_exponent_and_no_scatter() {
        let points = [1.0, 4.0, 16.0, 64.0].map(|n: f64| point(n, 3.0 * math::powf(n, -0.75)));
        let order = Order::fit(&points).unwrap();
        // Logarithms are good to some ulps, and the slope divides by numbers above one.
        assert!((order.exponent + 0.75).abs() < 1e-14, "{order:?}");
        assert!(order.standard_error.unwrap() < 1e-14);
        assert_eq!(order.points, 4);
    }

    #[test]
    fn the_standard_error_is_that_of_the_textbook() {
        // y = x with residuals e, −2e, e at x = −1, 0, 1, which move neither slope nor mean:
        // SE² = 6 e² / (1 · 2).
        let e: f64 = 0.01;
        let points = [(-1.0, e), (0.0, -2.0 * e), (1.0, e)]
            .map(|(x, off): (f64, f64)| point(math::exp(x), math::exp(x + off)));
        let order = Order::fit(&points).unwrap();
        assert!((order.exponent - 1.0).abs() < 1e-14);
        assert!((order.standard_error.unwrap() - 3_f64.sqrt() * e).abs() < 1e-14);
    }

    #[test]
    fn two_points_have_an_order_and_no_interval_however_often_one_is_repeated() {
        // Given whose runs are the same film: their points are one.
        let (cheap, dear) = (point(1e6, 3e-3), point(2e6, 7e-4));
        for points in [
            vec![cheap, dear],
            vec![cheap, cheap, dear],
            vec![dear, cheap, dear, cheap],
        ] {
            let order = Order::fit(&points).unwrap();
            let slope = math::ln(7e-4_f64 / 3e-3) / math::ln(2_f64);
            assert!((order.exponent - slope).abs() < 1e-12, "{order:?}");
            assert_eq!(order.standard_error, None);
            assert_eq!(order.points, points.len());
        }
        let third = point(4e6, 6e-4);
        assert!(
            Order::fit(&[cheap, cheap, dear, third])
                .unwrap()
                .standard_error
                .is_some()
        );
        let json = serde_json::to_value(Order::fit(&[cheap, dear])).unwrap();
        assert!(json["standard_error"].is_null());
    }

    #[test]
    fn one_cost_has_no_order() {
        assert_eq!(Order::fit(&[point(2.0, 0.1), point(2.0, 0.2)]), None);
        assert_eq!(Order::fit(&[]), None);
        assert_eq!(Order::fit(&[point(1.0, 0.0), point(2.0, 0.1)]), None);
    }

    #[test]
    fn what_costs_more_and_errs_more_is_not_on_the_front() {
        let points = [
            point(1.0, 0.5),
            point(2.0, 0.6),
            point(2.0, 0.1),
            point(3.0, 0.1),
        ];
        assert_eq!(pareto(&points), [true, false, true, false]);
    }

    #[test]
    fn equal_points_are_on_the_front_together() {
        assert_eq!(pareto(&[point(1.0, 0.1); 2]), [true, true]);
    }

    #[test]
    fn medians_of_odd_and_even_numbers() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0]), Some(2.5));
        assert_eq!(median(&[]), None);
    }
}
