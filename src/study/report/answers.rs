//! Sentences for a reader's first questions: how wrong, where, why, and what would less error cost?

use super::super::checks::plane;
use super::figures::{Answer, Curve, OrderOf, ReportRow, StageErrors};
use super::text::{judged, percent};
use crate::film::Image;
use crate::metric::{Figure, LayerComparison};
use crate::numeric::math;
use crate::run::format::three_digits;

/// More work is no help if half the error needs more than this many times the work.
const HOPELESS: f64 = 1000.0;

/// The part of the error that a stage must add or hide to be named.
const NOTABLE: f64 = 0.1;

/// A displacement that is not worth a word [texels].
const LEAST_DISPLACEMENT: f64 = 0.01;

/// A part of the light that is not worth a word.
const NEXT_TO_NOTHING: f64 = 0.005;

/// One answer a curve.
pub(super) fn answers(rows: &[ReportRow], curves: &[Curve], stages: &[StageErrors]) -> Vec<Answer> {
    let answer = |curve: &Curve| {
        let known = curve.rows.iter().map(|i| &rows[*i]);
        let best = known
            .filter(|row| row.error.is_some())
            .min_by(|a, b| a.error.unwrap_or(0.0).total_cmp(&b.error.unwrap_or(0.0)))?;
        let why = stages.iter().find(|one| one.name == curve.name);
        let sentences = [
            Some(how_wrong(best, curve.rows.len() > 1)),
            best.resolved.then(|| place(best)).flatten(),
            why.and_then(reason),
            price(curve),
        ];
        Some(Answer {
            name: curve.name.clone(),
            sentences: sentences.into_iter().flatten().collect(),
        })
    };
    curves.iter().filter_map(answer).collect()
}

/// A sentence for each curve on runs that are no rows, since the truth cannot tell their error from its own.
pub(super) fn left_out(
    rows: &[ReportRow],
    unknown: &[usize],
    truth: &str,
) -> Vec<(String, String)> {
    let mut said: Vec<(String, String)> = Vec::new();
    for place in unknown {
        let name = &rows[*place].name;
        if said.iter().any(|(known, _)| known == name) {
            continue;
        }
        let own = unknown.iter().map(|place| &rows[*place]);
        let own: Vec<&ReportRow> = own.filter(|row| row.name == *name).collect();
        let labels = own
            .iter()
            .flat_map(|row| std::iter::once(&row.label).chain(&row.same));
        let labels: Vec<&str> = labels.map(String::as_str).collect();
        let largest = |of: fn(&ReportRow) -> Option<f64>| {
            own.iter().filter_map(|row| of(row)).reduce(f64::max)
        };
        said.push((
            name.clone(),
            format!(
                "No {}: {}. The truth ({truth}) cannot tell an L1 of {} from its own error, {}.",
                if labels.len() == 1 { "row" } else { "rows" },
                labels.join(", "),
                percent(largest(|row| row.error)),
                percent(largest(|row| row.truth_error)),
            ),
        ));
    }
    said
}

/// Answers, with a sentence more for curves that lack rows.
pub(super) fn with_left_out(mut answers: Vec<Answer>, said: Vec<(String, String)>) -> Vec<Answer> {
    for (name, sentence) in said {
        match answers.iter_mut().find(|answer| answer.name == name) {
            Some(answer) => answer.sentences.push(sentence),
            None => answers.push(Answer {
                name,
                sentences: vec![sentence],
            }),
        }
    }
    answers
}

/// Energy, displacement, misplaced light and resolution of the best row.
fn how_wrong(best: &ReportRow, is_best_of_several: bool) -> String {
    let at_best = if is_best_of_several {
        format!("At best ({}) it", best.label)
    } else {
        "It".to_owned()
    };
    if !best.resolved {
        return format!(
            "{at_best} has an L1 of {}, which the truth cannot tell from its own error, {}.",
            percent(best.error),
            percent(best.truth_error)
        );
    }
    let Some(layer) = judged(best) else {
        return format!("{at_best} has an L1 of {}.", percent(best.error));
    };
    let light = &layer.fidelity;
    let energy = light.energy.map_or(1.0, |energy| energy.value);
    if energy == 0.0 {
        let warnings = best.facts.iter().flat_map(|facts| &facts.warnings);
        let reason = warnings.into_iter().next();
        let reason = reason.map_or(String::new(), |reason| format!(": {reason}"));
        return format!("{at_best} delivers no light at all{reason}.");
    }
    let mut said = Vec::new();
    if (energy - 1.0).abs() > NEXT_TO_NOTHING {
        let less = if energy < 1.0 { "less" } else { "more" };
        said.push(format!(
            "puts {} {less} light",
            percent(Some((energy - 1.0).abs()))
        ));
    }
    let displaced = light.displaced.as_ref();
    let displaced = displaced.filter(|it| it.texels.value >= LEAST_DISPLACEMENT);
    said.extend(displaced.map(|displaced| {
        let metres = displaced.metres;
        let metres = metres.map_or(String::new(), |it| format!(" ({})", length(it.value)));
        format!(
            "moves it by {} texels{metres}",
            three_digits(displaced.texels.value)
        )
    }));
    said.extend(
        light
            .misplaced
            .map(|it| format!("has {} of it in a wrong texel", percent(Some(it.value)))),
    );
    said.push(light.resolution.map_or_else(
        || "is right to 10 % at no scale".to_owned(),
        |it| {
            let metres = it
                .metres
                .map_or(String::new(), |it| format!(" ({})", length(it)));
            let texels = it.texels.value;
            if texels <= 1.0 {
                return "is right to 10 % at every texel".to_owned();
            }
            format!(
                "is right to 10 % at {} texels{metres}",
                three_digits(texels)
            )
        },
    ));
    let last = said.pop().unwrap_or_default();
    let list = if said.is_empty() {
        last
    } else {
        format!("{}, and {last}", said.join(", "))
    };
    format!("{at_best} {list}; L1 is {}.", percent(best.error))
}

/// A length for readers.
fn length(metres: f64) -> String {
    if metres < 1e-2 {
        format!("{} mm", three_digits(1e3 * metres))
    } else if metres < 1.0 {
        format!("{} cm", three_digits(1e2 * metres))
    } else {
        format!("{} m", three_digits(metres))
    }
}

fn place(best: &ReportRow) -> Option<String> {
    let half = best.half_in?;
    Some(format!(
        "Half of the squared error is in {} of the texels.",
        percent(Some(half))
    ))
}

/// The stages that add most to L1, and those that hide others' errors.
fn reason(stages: &StageErrors) -> Option<String> {
    let shares = stages.attribution.of(Figure::L1)?;
    let names = stages
        .attribution
        .stages
        .iter()
        .map(|stage| stage.name.as_str());
    let mut values: Vec<(&str, f64)> = names
        .zip(shares.stages.iter().map(|stage| stage.share.value))
        .filter(|(_, value)| value.abs() > NOTABLE * shares.whole)
        .collect();
    values.sort_by(|a, b| b.1.total_cmp(&a.1));
    let told = |values: Vec<&(&str, f64)>| {
        let told = values.into_iter().map(|(stage, value)| {
            format!(
                "{stage} ({} of {})",
                percent(Some(value.abs())),
                percent(Some(shares.whole))
            )
        });
        told.collect::<Vec<_>>().join(", ")
    };
    let adding: Vec<_> = values
        .iter()
        .filter(|(_, value)| *value > 0.0)
        .take(2)
        .collect();
    let hiding: Vec<_> = values.iter().filter(|(_, value)| *value < 0.0).collect();
    if adding.is_empty() {
        return None;
    }
    let hidden = if hiding.is_empty() {
        String::new()
    } else {
        format!("; hiding others' errors: {}", told(hiding))
    };
    Some(format!(
        "Stages that make most of it: {}{hidden}.",
        told(adding)
    ))
}

/// The price of half the error, by the order in the count of the method's own starts, which has no fixed work
/// in it.
fn price(curve: &Curve) -> Option<String> {
    let OrderOf { cost, order } = curve.orders.last()?;
    // Two points have no scatter, and a slope that its scatter explains is none.
    let spread = order.standard_error.unwrap_or(0.0);
    let factor = math::exp2(-1.0 / order.exponent);
    let is_hopeless = order.exponent + 2.0 * spread >= 0.0 || factor > HOPELESS;
    Some(if is_hopeless {
        format!("More {cost} do not make it less.")
    } else {
        format!("Half the error costs {factor:.1} times the {cost}.")
    })
}

/// The smallest part of all texels that holds half of Σ d², d the difference of channels' means; `None` if
/// all d are 0.
pub(super) fn half_in(truth: &Image, film: &Image, layer: &LayerComparison) -> Option<f64> {
    half_of(&plane(truth, layer)?, &plane(film, layer)?)
}

fn half_of(truth: &[f64], film: &[f64]) -> Option<f64> {
    let squares = truth.iter().zip(film).map(|(t, f)| (f - t) * (f - t));
    let mut squares: Vec<f64> = squares.filter(|square| square.is_finite()).collect();
    squares.sort_by(|a, b| b.total_cmp(a));
    let half = 0.5 * squares.iter().sum::<f64>();
    let mut sum = 0.0;
    let above = squares.iter().take_while(|square| {
        let is_needed = sum < half;
        sum += **square;
        is_needed
    });
    let count = above.count();
    (half > 0.0).then(|| count as f64 / truth.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::curve::Order;

    fn curve(exponent: f64, standard_error: Option<f64>) -> Curve {
        Curve {
            name: "photons".to_owned(),
            rows: vec![0],
            orders: vec![OrderOf {
                cost: "photons".to_owned(),
                order: Order {
                    exponent,
                    standard_error,
                    points: 3,
                },
            }],
        }
    }

    #[test]
    fn independent_samples_halve_their_error_at_four_times_the_price() {
        let price = price(&curve(-0.5, Some(0.01)));
        assert_eq!(
            price.as_deref(),
            Some("Half the error costs 4.0 times the photons.")
        );
    }

    #[test]
    fn a_slope_that_its_scatter_explains_promises_nothing() {
        for (exponent, spread) in [(-0.5, Some(0.3)), (0.1, None), (-1e-3, Some(1e-5))] {
            let price = price(&curve(exponent, spread));
            assert_eq!(price.as_deref(), Some("More photons do not make it less."));
        }
    }

    #[test]
    fn half_of_the_error_is_in_as_few_texels_as_hold_it() {
        // Squares 9, 1, 1, 1, and 0 twice: the first holds three quarters. Of four equal ones, two hold half.
        let truth = [0.0; 6];
        assert_eq!(
            half_of(&truth, &[1.0, 0.0, 3.0, 1.0, 0.0, -1.0]),
            Some(1.0 / 6.0)
        );
        assert_eq!(half_of(&truth[..4], &[1.0, -1.0, 1.0, 1.0]), Some(0.5));
        assert_eq!(half_of(&truth, &truth), None);
        assert_eq!(half_of(&[0.0, 0.0], &[f64::NAN, 1.0]), Some(0.5));
    }
}
