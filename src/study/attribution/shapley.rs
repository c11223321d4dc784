//! Shapley values: the share of each of some causes in a figure.
//!
//! v(U) is the figure if the causes of the set U are there. The value of cause i is the mean, over all orders
//! in which causes come in, of the change that i makes when it comes in (Shapley 1953):
//!
//! ```text
//! φᵢ = Σ_{U ∌ i} |U|! (n − |U| − 1)! / n! · (v(U ∪ i) − v(U)),    Σ φᵢ = v(all) − v(none)
//! ```
//!
//! Of up to [`ALL_SUBSETS`] causes all subsets are asked. Of more, some orders are drawn, each with its
//! reverse; their scatter gives a standard error, and the values still add up.

use crate::numeric::math;
use crate::numeric::streams::hash64;

/// Causes whose 2ⁿ subsets are all asked.
pub const ALL_SUBSETS: usize = 7;

/// Pairs of orders drawn if causes are more.
pub const PAIRS: usize = 8;

/// A set of causes: bit i is cause i.
pub type Set = u32;

/// The share of one cause.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Share {
    /// Its value, in the unit of the figure.
    pub value: f64,
    /// Its standard error, if orders were drawn; zero if all were taken.
    pub standard_error: f64,
}

/// The orders in which causes come in that are drawn; empty if all subsets are asked.
pub fn orders(causes: usize) -> Vec<Vec<usize>> {
    if causes <= ALL_SUBSETS {
        return Vec::new();
    }
    let mut orders = Vec::new();
    for pair in 0..PAIRS as u64 {
        let mut order: Vec<usize> = (0..causes).collect();
        // Fisher and Yates.
        for last in (1..causes).rev() {
            let lot = hash64(0, pair, last as u32);
            order.swap(last, (lot % (last as u64 + 1)) as usize);
        }
        let reverse = order.iter().rev().copied().collect();
        orders.extend([order, reverse]);
    }
    orders
}

/// All sets that [`shares`] asks for, each once, the smallest first.
pub fn sets(causes: usize) -> Vec<Set> {
    let mut sets: Vec<Set> = if causes <= ALL_SUBSETS {
        (0..1 << causes).collect()
    } else {
        let prefixes = orders(causes).into_iter().flat_map(|order| {
            (0..=causes)
                .map(|length| set(&order[..length]))
                .collect::<Vec<_>>()
        });
        prefixes.collect()
    };
    sets.sort_by_key(|set| (set.count_ones(), *set));
    sets.dedup();
    sets
}

fn set(causes: &[usize]) -> Set {
    causes.iter().fold(0, |set, cause| set | 1 << cause)
}

/// The share of each cause; `None` if the figure of a set that is asked for is not known.
pub fn shares(causes: usize, figure: impl Fn(Set) -> Option<f64>) -> Option<Vec<Share>> {
    if causes <= ALL_SUBSETS {
        return (0..causes)
            .map(|cause| exact(causes, cause, &figure))
            .collect();
    }
    let orders = orders(causes);
    // The change that a cause makes in each order.
    let mut changes = vec![Vec::new(); causes];
    for order in &orders {
        for (place, cause) in order.iter().enumerate() {
            let change = figure(set(&order[..=place]))? - figure(set(&order[..place]))?;
            changes[*cause].push(change);
        }
    }
    Some(changes.iter().map(|changes| mean(changes)).collect())
}

fn exact(causes: usize, cause: usize, figure: impl Fn(Set) -> Option<f64>) -> Option<Share> {
    let factorial = |n: usize| (1..=n).map(|i| i as f64).product::<f64>();
    let mut value = 0.0;
    for others in (0..1 << causes).filter(|others: &Set| others & (1 << cause) == 0) {
        let size = others.count_ones() as usize;
        let weight = factorial(size) * factorial(causes - size - 1) / factorial(causes);
        value += weight * (figure(others | 1 << cause)? - figure(others)?);
    }
    Some(Share {
        value,
        standard_error: 0.0,
    })
}

/// The mean of changes, and the standard error of means over pairs: an order and its reverse are not
/// independent.
fn mean(changes: &[f64]) -> Share {
    let pairs: Vec<f64> = changes
        .chunks_exact(2)
        .map(|pair| 0.5 * (pair[0] + pair[1]))
        .collect();
    let n = pairs.len() as f64;
    let value = pairs.iter().sum::<f64>() / n;
    let squares: f64 = pairs.iter().map(|one| math::powi(one - value, 2)).sum();
    Share {
        value,
        standard_error: (squares / (n * (n - 1.0))).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Causes that act alone, two that act only together, and two that hide each other.
    fn known(set: Set) -> f64 {
        let has = |cause: usize| f64::from(u8::from(set >> cause & 1 == 1));
        3.0 + 2.0 * has(0) - 0.5 * has(1) + 4.0 * has(2) * has(3) + (has(4) - has(5)).abs()
    }

    #[test]
    fn alone_a_cause_has_its_own_effect_and_a_common_effect_is_shared_alike() {
        let shares = shares(6, |set| Some(known(set))).unwrap();
        let expected = [2.0, -0.5, 2.0, 2.0, 0.0, 0.0];
        for (share, expected) in shares.iter().zip(expected) {
            // Sums of 32 terms.
            assert!((share.value - expected).abs() < 1e-13, "{shares:?}");
            assert_eq!(share.standard_error, 0.0);
        }
    }

    #[test]
    fn shares_add_up_to_the_whole_whether_all_subsets_are_asked_or_some_orders_drawn() {
        for causes in [0, 1, 2, 6, 7, 8, 11] {
            let shares = shares(causes, |set| Some(known(set))).unwrap();
            let sum: f64 = shares.iter().map(|share| share.value).sum();
            let whole = known((1 << causes) - 1) - known(0);
            assert!((sum - whole).abs() < 1e-12, "{causes}: {sum} {whole}");
        }
    }

    #[test]
    fn drawn_shares_are_those_of_all_orders_within_their_error() {
        let drawn = shares(9, |set| Some(known(set))).unwrap();
        let expected = [2.0, -0.5, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for (share, expected) in drawn.iter().zip(expected) {
            // Eight pairs: 99.9 % of Student's t with 7 degrees of freedom are within 5.4.
            let off = (share.value - expected).abs();
            assert!(off <= 5.4 * share.standard_error + 1e-13, "{share:?}");
        }
        // An order and its reverse find a common effect of two in one of them each: no error is left.
        assert_eq!(drawn[2].standard_error, 0.0);
    }

    #[test]
    fn all_sets_that_are_asked_are_listed() {
        for causes in [0, 3, 7, 8, 10] {
            let listed = sets(causes);
            let found = shares(causes, |set| listed.contains(&set).then_some(0.0));
            assert!(found.is_some(), "{causes}");
        }
        assert_eq!(sets(3).len(), 8);
        assert!(sets(10).len() <= 2 + 16 * 9);
    }

    #[test]
    fn an_unknown_figure_leaves_all_shares_unknown() {
        assert_eq!(shares(3, |set| (set != 5).then_some(1.0)), None);
    }
}
