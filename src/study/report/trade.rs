//! Rows against each other: curves with their orders, fronts, and limits.

use std::collections::BTreeSet;

use super::super::curve::{Order, Point, pareto};
use super::super::limit::Limit;
use super::figures::{Curve, Gate, GateVerdict, OrderOf, ReportRow, RunTiming};
use super::text::judged;
use crate::metric::Bounded;

/// The name of the axis of seconds, beside the names of counters.
pub(super) const SECONDS: &str = "seconds";

fn count(row: &ReportRow, counter: &str) -> Option<f64> {
    let counters = &row.facts.as_ref()?.counters;
    let found = counters.iter().find(|one| one.name == counter)?;
    Some(found.count as f64)
}

/// All names of counters, in the order of their first occurrence.
fn counters<'a>(rows: impl Iterator<Item = &'a ReportRow>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for counter in rows
        .filter_map(|row| row.facts.as_ref())
        .flat_map(|facts| &facts.counters)
    {
        if !names.contains(&counter.name) {
            names.push(counter.name.clone());
        }
    }
    names
}

/// Marks by each counter the rows that no other beats.
pub(super) fn mark_pareto(rows: &mut [ReportRow]) {
    for counter in counters(rows.iter()) {
        for (row, is_on_front) in front(rows, |_, row| count(row, &counter)) {
            rows[row].pareto.insert(counter.clone(), is_on_front);
        }
    }
}

/// The rows of the default study whose error the truth cannot tell from its own: no decision follows from
/// them. Rows that somebody asked for stay, and all do if the truth can judge none.
pub(super) fn unknown(rows: &[ReportRow], is_default: impl Fn(usize) -> bool) -> Vec<usize> {
    if !rows.iter().any(|row| row.resolved) {
        return Vec::new();
    }
    let is_unknown =
        |row: &ReportRow| !row.resolved && row.error.is_some() && row.truth_error.is_some();
    let rows = rows.iter().enumerate();
    rows.filter(|(place, row)| is_default(*place) && is_unknown(row))
        .map(|(place, _)| place)
        .collect()
}

/// The rows that have a cost and an error, each with true if it is on the front. A front is among rows that
/// are judged by the same light, since errors of one layer and of all light are not of one kind.
pub(super) fn front(
    rows: &[ReportRow],
    cost: impl Fn(usize, &ReportRow) -> Option<f64>,
) -> Vec<(usize, bool)> {
    let mut all = Vec::new();
    let layers: BTreeSet<&str> = rows.iter().map(|row| row.layer.as_str()).collect();
    for layer in layers {
        let own = rows
            .iter()
            .enumerate()
            .filter(|(_, row)| row.layer == layer);
        let with_both = own.filter_map(|(i, row)| {
            let (cost, error) = (cost(i, row)?, row.error?);
            Some((i, Point { cost, error }))
        });
        let (places, points): (Vec<usize>, Vec<Point>) = with_both.unzip();
        all.extend(places.into_iter().zip(pareto(&points)));
    }
    all
}

/// The curves, one a name, with their orders.
pub(super) fn curves(rows: &[ReportRow]) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        match curves.iter_mut().find(|curve| curve.name == row.name) {
            Some(curve) => curve.rows.push(i),
            None => curves.push(Curve {
                name: row.name.clone(),
                rows: vec![i],
                orders: Vec::new(),
            }),
        }
    }
    for curve in &mut curves {
        let costs = counters(curve.rows.iter().map(|i| &rows[*i]));
        if let Some(first) = costs.first() {
            let cost = |i: &usize| count(&rows[*i], first).unwrap_or(f64::INFINITY);
            curve.rows.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        }
        for name in costs {
            let orders = order(&curve.rows, rows, &name, |_, row| count(row, &name));
            curve.orders.extend(orders);
        }
    }
    curves
}

/// The order of each curve's error in seconds, and the reasons why some are missing: seconds of different
/// machines do not compare.
pub(super) fn orders_in_seconds(
    curves: &[Curve],
    rows: &[ReportRow],
    timed: &[RunTiming],
) -> (Vec<Option<OrderOf>>, Vec<String>) {
    let mut notes = Vec::new();
    let orders = curves.iter().map(|curve| {
        let order = order(&curve.rows, rows, SECONDS, |i, _| timed[i].median)?;
        let resolved = curve.rows.iter().filter(|i| rows[**i].resolved);
        let machines: Vec<_> = resolved.map(|i| &timed[*i].machine).collect();
        if machines.iter().all(|machine| *machine == machines[0]) {
            return Some(order);
        }
        notes.push(format!(
            "{}: no order in seconds, since its runs are of different machines",
            curve.name
        ));
        None
    });
    let orders = orders.collect();
    (orders, notes)
}

/// The order of the error in a cost, fitted to those rows of a curve that are resolved.
fn order(
    curve: &[usize],
    rows: &[ReportRow],
    name: &str,
    cost: impl Fn(usize, &ReportRow) -> Option<f64>,
) -> Option<OrderOf> {
    let resolved = curve.iter().filter(|i| rows[**i].resolved);
    let points: Vec<Point> = resolved
        .filter_map(|i| {
            Some(Point {
                cost: cost(*i, &rows[*i])?,
                error: rows[*i].error?,
            })
        })
        .collect();
    Some(OrderOf {
        cost: name.to_owned(),
        order: Order::fit(&points)?,
    })
}

/// The verdicts on limits: a curve keeps a limit if any of its settings does, and exceeds it if all do.
pub(super) fn gates(limits: &[(String, Limit)], rows: &[ReportRow]) -> Vec<Gate> {
    let gate = |(name, limit): &(String, Limit)| {
        let own = rows.iter().filter(|row| row.name == *name);
        let judged = own.filter_map(|row| {
            let figure = limit.figure_of(judged(row)?)?;
            Some((figure, verdict(figure, limit, row.resolved)))
        });
        // The verdict that decides, and of equal ones the least figure.
        let rank = |verdict: GateVerdict| match verdict {
            GateVerdict::Kept => 0,
            GateVerdict::Undecided => 1,
            GateVerdict::Exceeded => 2,
        };
        let best = judged.min_by(|a, b| {
            let ranks = rank(a.1).cmp(&rank(b.1));
            ranks.then(a.0.value.total_cmp(&b.0.value))
        });
        Gate {
            name: name.clone(),
            limit: *limit,
            error: best.map(|(figure, _)| figure),
            verdict: best.map_or(GateVerdict::Undecided, |(_, verdict)| verdict),
        }
    };
    limits.iter().map(gate).collect()
}

/// A figure without an interval decides if the truth resolves the row.
fn verdict(figure: Bounded, limit: &Limit, is_resolved: bool) -> GateVerdict {
    let (low, high) = match (figure.low, figure.high) {
        (None, None) if is_resolved => (figure.value, Some(figure.value)),
        (None, _) => return GateVerdict::Undecided,
        (Some(low), high) => (low, high),
    };
    if high.is_some_and(|high| high <= limit.most) {
        GateVerdict::Kept
    } else if low > limit.most {
        GateVerdict::Exceeded
    } else {
        GateVerdict::Undecided
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Image;
    use crate::metric::{CompareImage, CompareSettings, Figure, compare};
    use crate::study::limit::LimitUnit;
    use crate::study::machine::Machine;

    /// A resolved row with this error.
    fn row(error: f64) -> ReportRow {
        let mut image = Image::new(1, 1);
        image.add_rgb("E", &[[1.0; 3]]);
        let source = CompareImage::new("film", image);
        ReportRow {
            name: "photons".to_owned(),
            label: String::new(),
            method: None,
            settings: crate::setting::Given::new(),
            file: String::new(),
            command: None,
            compare: String::new(),
            facts: None,
            layer: "E".to_owned(),
            error: Some(error),
            half_in: None,
            truth_error: Some(0.0),
            picture: None,
            same: Vec::new(),
            resolved: true,
            pareto: std::collections::BTreeMap::new(),
            checks: Vec::new(),
            comparison: compare(&source, &source, &CompareSettings::default()).unwrap(),
        }
    }

    fn timing(seconds: f64, host: &str) -> RunTiming {
        RunTiming {
            label: String::new(),
            seconds: vec![seconds],
            median: Some(seconds),
            threads: Some(2),
            machine: Some(Machine {
                host: host.to_owned(),
                processor: "a processor".to_owned(),
            }),
            pareto: false,
        }
    }

    #[test]
    fn a_limit_is_kept_by_any_row_and_exceeded_by_all_and_unknown_where_the_truth_is() {
        let limit = |most| Limit {
            figure: Figure::L1,
            most,
            unit: LimitUnit::Fraction,
        };
        let figure = |low: f64, value: f64, high: f64| Bounded {
            value,
            low: Some(low),
            high: Some(high),
        };
        let says = |figure, most, is_resolved| verdict(figure, &limit(most), is_resolved);
        assert_eq!(says(figure(0.1, 0.2, 0.3), 0.3, true), GateVerdict::Kept);
        assert_eq!(
            says(figure(0.1, 0.2, 0.3), 0.25, true),
            GateVerdict::Undecided
        );
        assert_eq!(
            says(figure(0.1, 0.2, 0.3), 0.05, true),
            GateVerdict::Exceeded
        );
        let bare = Bounded {
            value: 0.2,
            low: None,
            high: None,
        };
        assert_eq!(says(bare, 0.3, true), GateVerdict::Kept);
        assert_eq!(says(bare, 0.1, true), GateVerdict::Exceeded);
        assert_eq!(says(bare, 0.3, false), GateVerdict::Undecided);
        // An image and itself differ in nothing; without bars that is known if the row is resolved.
        let mut rows = vec![row(0.1), row(0.2)];
        let verdicts = |rows: &[ReportRow]| gates(&[("photons".to_owned(), limit(0.5))], rows);
        assert_eq!(verdicts(&rows)[0].verdict, GateVerdict::Kept);
        rows[0].resolved = false;
        assert_eq!(verdicts(&rows)[0].verdict, GateVerdict::Kept);
        rows[1].resolved = false;
        assert_eq!(verdicts(&rows)[0].verdict, GateVerdict::Undecided);
        assert_eq!(verdicts(&[])[0].verdict, GateVerdict::Undecided);
    }

    #[test]
    fn default_rows_that_the_truth_cannot_tell_are_left_out_unless_it_can_judge_none() {
        let mut rows = vec![row(0.1), row(1e-4), row(1e-5)];
        rows[1].resolved = false;
        rows[2].resolved = false;
        assert_eq!(unknown(&rows, |_| true), [1, 2]);
        // Somebody asked for the last one.
        assert_eq!(unknown(&rows, |place| place < 2), [1]);
        // A truth without an error of its own has not judged.
        rows[1].truth_error = None;
        assert_eq!(unknown(&rows, |_| true), [2]);
        rows[0].resolved = false;
        assert!(unknown(&rows, |_| true).is_empty());
    }

    #[test]
    fn seconds_of_different_machines_have_no_order_and_it_is_told() {
        let mut rows = vec![row(0.1), row(0.05), row(0.025)];
        let curves = curves(&rows);
        let timed = |hosts: [&str; 3]| {
            let seconds = [1.0, 4.0, 16.0].into_iter().zip(hosts);
            let timed = seconds.map(|(seconds, host)| timing(seconds, host));
            timed.collect::<Vec<_>>()
        };
        let two = timed(["here", "here", "there"]);
        let (orders, notes) = orders_in_seconds(&curves, &rows, &two);
        assert!(orders[0].is_none());
        assert!(notes[0].contains("different machines"), "{notes:?}");
        // Rows that the truth does not resolve are in no fit, wherever they ran.
        rows[2].resolved = false;
        let (orders, notes) = orders_in_seconds(&curves, &rows, &two);
        assert!((orders[0].as_ref().unwrap().order.exponent + 0.5).abs() < 1e-14);
        assert!(notes.is_empty());
        // Another processor is another machine, even under one name.
        rows[2].resolved = true;
        let mut one = timed(["here"; 3]);
        assert!(orders_in_seconds(&curves, &rows, &one).0[0].is_some());
        one[0].machine.as_mut().unwrap().processor = "another".to_owned();
        assert!(orders_in_seconds(&curves, &rows, &one).0[0].is_none());
    }
}
