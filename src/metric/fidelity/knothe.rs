//! An upper bound of the Wasserstein distance: the cost of plans that can be written down.
//!
//! The plans are rearrangements after Knothe (1957): texels are in groups (columns, rows, or rings about the
//! truth's centre of light). Light of one distribution goes to the groups of the other in their order, and
//! within two groups to their texels in theirs. Each plan moves all light to its place, so its cost is an
//! upper bound. The plan of columns and rows is the cheapest for light moved by one vector or scaled.
//!
//! Light that both have in a texel may as well stay. So each plan is tried with and without it.

use glam::DVec2;

use super::measure::Measure;
use crate::numeric::math;

/// Texels in order, as one group.
type Group = Vec<usize>;

/// The upper bound, in the unit of `spacing`.
pub(super) fn upper_bound(truth: &Measure, other: &Measure, spacing: [f64; 2]) -> f64 {
    use rayon::prelude::*;
    let [width, height] = truth.size;
    let rows: Vec<Group> = (0..height)
        .map(|y| (y * width..(y + 1) * width).collect())
        .collect();
    let columns: Vec<Group> = (0..width)
        .map(|x| (0..height).map(|y| y * width + x).collect())
        .collect();
    let orders = [rows, columns, rings(truth, spacing)];
    let whole = [truth.shares.clone(), other.shares.clone()];
    let (mut missing, mut surplus) = (Vec::new(), Vec::new());
    for (t, a) in truth.shares.iter().zip(&other.shares) {
        missing.push((t - a).max(0.0));
        surplus.push((a - t).max(0.0));
    }
    let apart = [missing, surplus];
    let tries: Vec<(&Vec<Group>, &[Vec<f64>; 2])> = orders
        .iter()
        .flat_map(|order| [(order, &whole), (order, &apart)])
        .collect();
    let costs: Vec<f64> = tries
        .into_par_iter()
        .map(|(order, [to, from])| {
            plan_cost(order, from, to, |a, b| {
                truth.place(a, spacing).distance(truth.place(b, spacing))
            })
        })
        .collect();
    costs.into_iter().fold(f64::INFINITY, f64::min)
}

/// Texels by their distance from the centre of light, in rings as wide as a texel, and by angle in a ring.
fn rings(truth: &Measure, spacing: [f64; 2]) -> Vec<Group> {
    let centre = truth.centre(spacing);
    let step = spacing[0].max(spacing[1]);
    let mut rings: Vec<Vec<(f64, usize)>> = Vec::new();
    for texel in 0..truth.shares.len() {
        let at: DVec2 = truth.place(texel, spacing) - centre;
        let ring = (at.length() / step) as usize;
        if ring >= rings.len() {
            rings.resize(ring + 1, Vec::new());
        }
        rings[ring].push((math::atan2(at.y, at.x), texel));
    }
    let sorted = rings.into_iter().map(|mut ring| {
        ring.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        ring.into_iter().map(|(_, texel)| texel).collect()
    });
    sorted.collect()
}

/// The cost of moving `from` to `to`, which have the same sum: group by group, and in order within groups.
fn plan_cost(
    groups: &[Group],
    from: &[f64],
    to: &[f64],
    distance: impl Fn(usize, usize) -> f64,
) -> f64 {
    let sums = |shares: &[f64]| -> Vec<f64> {
        let sum = |group: &Group| group.iter().map(|texel| shares[*texel]).sum();
        groups.iter().map(sum).collect()
    };
    let (sums_from, sums_to) = (sums(from), sums(to));
    let mut cost = 0.0;
    in_order(&sums_from, &sums_to, |a, b, share| {
        let parts = |group: &Group, shares: &[f64], sum: f64| -> Vec<f64> {
            let part = |texel: &usize| shares[*texel] * (share / sum);
            group.iter().map(part).collect()
        };
        let own = parts(&groups[a], from, sums_from[a]);
        let theirs = parts(&groups[b], to, sums_to[b]);
        in_order(&own, &theirs, |i, j, part| {
            cost += part * distance(groups[a][i], groups[b][j]);
        });
    });
    cost
}

/// Pairs of places and the share that goes from one to the other, if shares keep their order.
fn in_order(from: &[f64], to: &[f64], mut found: impl FnMut(usize, usize, f64)) {
    let next = |shares: &[f64], from: usize| {
        let rest = shares[from..].iter();
        rest.clone()
            .position(|share| *share > 0.0)
            .map(|i| from + i)
    };
    let (mut i, mut j) = (next(from, 0), next(to, 0));
    let mut left = [i.map_or(0.0, |i| from[i]), j.map_or(0.0, |j| to[j])];
    // Where sums differ by rounding, what is left at the end is next to nothing.
    while let (Some(a), Some(b)) = (i, j) {
        let share = left[0].min(left[1]);
        found(a, b, share);
        left[0] -= share;
        left[1] -= share;
        if left[0] <= 0.0 {
            i = next(from, a + 1);
            left[0] = i.map_or(0.0, |i| from[i]);
        }
        if left[1] <= 0.0 {
            j = next(to, b + 1);
            left[1] = j.map_or(0.0, |j| to[j]);
        }
    }
}
