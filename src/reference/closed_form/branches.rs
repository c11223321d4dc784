//! A function of one variable, cut into its monotone branches, so that it can be inverted.

use std::f64::consts::PI;

use crate::numeric::math;

/// Number of cells in which a function is searched for its extrema: two of them within a cell go unseen.
const CELLS: usize = 2048;

/// The monotone branches of a continuous function.
#[derive(Clone, Debug)]
pub(super) struct Branches(Vec<MonotoneBranch>);

/// A stretch of the variable on which the function rises, or falls.
#[derive(Clone, Debug)]
pub(super) struct MonotoneBranch {
    /// (variable, value) in rising order of the variable; at least two.
    table: Vec<(f64, f64)>,
    rising: bool,
}

impl Branches {
    /// Cuts `f` over [`from`, `to`] at its extrema and where it has no value.
    ///
    /// The variable is sampled in cosine spacing, dense at both ends. An extremum is placed to about
    /// the square root of rounding, which is where `f` stops to change in `f64`.
    pub(super) fn new(from: f64, to: f64, f: &impl Fn(f64) -> Option<f64>) -> Self {
        let at = |j: usize| {
            let half_sin = math::sin(0.5 * PI * j as f64 / CELLS as f64);
            if j == CELLS {
                to
            } else {
                from + (to - from) * half_sin * half_sin
            }
        };
        let mut runs: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
        let mut last = from;
        for j in 0..=CELLS {
            let u = at(j);
            let run_is_empty = runs.last().is_none_or(Vec::is_empty);
            match (f(u), run_is_empty) {
                (Some(value), empty) => {
                    let border = (empty && j > 0).then(|| border(last, u, f)).flatten();
                    if let Some(run) = runs.last_mut() {
                        run.extend(border);
                        run.push((u, value));
                    }
                }
                (None, false) => {
                    let border = border(u, last, f);
                    if let Some(run) = runs.last_mut() {
                        run.extend(border);
                    }
                    runs.push(Vec::new());
                }
                (None, true) => {}
            }
            last = u;
        }
        Self(runs.iter().flat_map(|run| cut_at_extrema(run, f)).collect())
    }

    /// One after another.
    pub(super) fn iter(&self) -> impl Iterator<Item = &MonotoneBranch> {
        self.0.iter()
    }
}

impl MonotoneBranch {
    /// The least and the greatest value.
    pub(super) fn value_range(&self) -> (f64, f64) {
        let (first, last) = (self.table[0].1, self.table[self.table.len() - 1].1);
        if self.rising {
            (first, last)
        } else {
            (last, first)
        }
    }

    /// The variable's range.
    pub(super) fn range(&self) -> (f64, f64) {
        (self.table[0].0, self.table[self.table.len() - 1].0)
    }

    /// The variable at which the function has this value; the nearer end if the function does not reach it.
    pub(super) fn inverse(&self, value: f64, f: &impl Fn(f64) -> Option<f64>) -> f64 {
        let below = |&(_, v): &(f64, f64)| if self.rising { v < value } else { v > value };
        let next = self.table.partition_point(below);
        if next == 0 {
            return self.table[0].0;
        }
        if next == self.table.len() {
            return self.table[next - 1].0;
        }
        let (mut a, mut b) = (self.table[next - 1], self.table[next]);
        a.1 -= value;
        b.1 -= value;
        // Regula falsi in the Illinois variant, with a bisection whenever it has not halved the
        // bracket in three steps. Ends where no number lies between, or at a hit.
        let mut width = b.0 - a.0;
        for step in 1..200 {
            let mut u = a.0 + (b.0 - a.0) * (a.1 / (a.1 - b.1));
            if step % 4 == 0 {
                if b.0 - a.0 > 0.5 * width {
                    u = f64::midpoint(a.0, b.0);
                }
                width = b.0 - a.0;
            }
            if !(u > a.0 && u < b.0) {
                u = f64::midpoint(a.0, b.0);
                if u <= a.0 || u >= b.0 {
                    break;
                }
            }
            let Some(v) = f(u).map(|v| v - value) else {
                break;
            };
            if v == 0.0 {
                return u;
            }
            if (v < 0.0) == (a.1 < 0.0) {
                a = (u, v);
                b.1 *= 0.5;
            } else {
                b = (u, v);
                a.1 *= 0.5;
            }
            if b.0 - a.0 <= 4.0 * f64::EPSILON * a.0.abs().max(b.0.abs()) {
                break;
            }
        }
        f64::midpoint(a.0, b.0)
    }
}

/// The last point with a value on the way from `with` to `without` (in this order of arguments: without,
/// with).
fn border(without: f64, with: f64, f: &impl Fn(f64) -> Option<f64>) -> Option<(f64, f64)> {
    let (mut outside, mut inside) = (without, with);
    for _ in 0..100 {
        let middle = f64::midpoint(outside, inside);
        if middle == outside || middle == inside {
            break;
        }
        if f(middle).is_some() {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    (inside != with)
        .then(|| f(inside).map(|value| (inside, value)))
        .flatten()
}

fn cut_at_extrema(run: &[(f64, f64)], f: &impl Fn(f64) -> Option<f64>) -> Vec<MonotoneBranch> {
    let mut branches = Vec::new();
    let mut table: Vec<(f64, f64)> = Vec::new();
    let mut rising = None;
    for (j, &point) in run.iter().enumerate() {
        if let Some(&last) = table.last() {
            let rises = match rising {
                _ if point.1 > last.1 => true,
                _ if point.1 < last.1 => false,
                Some(rising) => rising,
                None => true,
            };
            if rising.is_some_and(|rising| rising != rises) {
                let before = if table.len() > 1 {
                    table[table.len() - 2].0
                } else {
                    last.0
                };
                let top = extremum(before, point.0, rising == Some(true), f);
                // The last sample may lie on either side of the extremum.
                let carried = if top.0 < last.0 { table.pop() } else { None };
                table.push(top);
                finish(&mut branches, &mut table, rising);
                table.push(top);
                table.extend(carried);
            }
            rising = Some(rises);
        }
        debug_assert!(j == 0 || !table.is_empty());
        table.push(point);
    }
    finish(&mut branches, &mut table, rising);
    branches
}

fn finish(branches: &mut Vec<MonotoneBranch>, table: &mut Vec<(f64, f64)>, rising: Option<bool>) {
    table.dedup_by_key(|point| point.0);
    if table.len() > 1 {
        branches.push(MonotoneBranch {
            table: std::mem::take(table),
            rising: rising.unwrap_or(true),
        });
    }
    table.clear();
}

/// Golden-section search for the one extremum in [a, b].
fn extremum(mut a: f64, mut b: f64, maximum: bool, f: &impl Fn(f64) -> Option<f64>) -> (f64, f64) {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let value = |u: f64| f(u).map_or(f64::NEG_INFINITY, |v| if maximum { v } else { -v });
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut at_c, mut at_d) = (value(c), value(d));
    // 0.618^80 < 2^-53: to rounding.
    for _ in 0..80 {
        if at_c > at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - golden * (b - a);
            at_c = value(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + golden * (b - a);
            at_d = value(d);
        }
    }
    let best = f64::midpoint(a, b);
    (best, f(best).unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_with_two_extrema_has_three_branches_and_all_of_its_roots() {
        let f = |u: f64| Some(u * (u - 1.0) * (u - 2.0));
        let branches = Branches::new(-1.0, 3.0, &f);
        let roots: Vec<f64> = branches
            .iter()
            .map(|branch| branch.inverse(0.0, &f))
            .collect();
        assert_eq!(roots.len(), 3);
        for (root, expected) in roots.iter().zip([0.0, 1.0, 2.0]) {
            // The value near a root is right to about an ulp of 1, and the slope there is 1 or 2.
            assert!((root - expected).abs() < 1e-15, "{root}");
        }
        let extrema: Vec<f64> = branches
            .iter()
            .skip(1)
            .map(|branch| branch.range().0)
            .collect();
        for (found, exact) in extrema
            .iter()
            .zip([1.0 - 3.0_f64.sqrt().recip(), 1.0 + 3.0_f64.sqrt().recip()])
        {
            // f changes by less than rounding within √(2⁻⁵²) of an extremum.
            assert!((found - exact).abs() < 1e-7, "{found}");
        }
    }

    #[test]
    fn where_a_function_has_no_value_it_has_no_branch() {
        let f = |u: f64| (u.abs() > 0.25).then(|| 1.0 / u);
        let branches = Branches::new(-1.0, 1.0, &f);
        let ranges: Vec<_> = branches.iter().map(MonotoneBranch::range).collect();
        assert_eq!(ranges.len(), 2);
        assert!(
            (ranges[0].1 + 0.25).abs() < 1e-15 && (ranges[1].0 - 0.25).abs() < 1e-15,
            "{ranges:?}"
        );
        assert!((branches.0[1].inverse(2.0, &f) - 0.5).abs() < 1e-15);
        assert_eq!(branches.0[1].inverse(1e9, &f), ranges[1].0);
    }
}
