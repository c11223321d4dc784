//! A report as a table for spreadsheets, and as Markdown for pull requests.

use std::fmt::Write as _;

use super::figures::{GateVerdict, Report, Row, Timings};
use crate::metric::Comparison;

/// A line a row; numbers as in the JSON, empty where there is none.
pub fn csv(report: &Report, timings: &Timings) -> String {
    let mut out = String::from(
        "name,label,layer,error,truth_error,resolved,bias,rmse,rel_mse,smape,ssim,flip,energy_ratio,verdict,rays,seconds,file\n",
    );
    for (row, timing) in report.rows.iter().zip(&timings.rows) {
        let judged = judged(row);
        let figure = |figure: fn(&Comparison) -> Option<f64>| number(judged.and_then(figure));
        let rays = row.facts.as_ref().and_then(|facts| facts.counters.first());
        let cells = [
            field(&row.name),
            field(&row.label),
            field(&row.layer),
            number(row.error),
            number(row.truth_error),
            row.resolved.to_string(),
            number(row.bias),
            figure(|it| Some(it.difference.rmse)),
            figure(|it| it.difference.rel_mse),
            figure(|it| it.difference.smape),
            figure(|it| it.similarity.map(|similarity| similarity.ssim)),
            figure(|it| it.flip.map(|flip| flip.mean)),
            figure(|it| it.difference.energy_ratio),
            judged
                .map_or("", |it| it.equivalence.verdict.name())
                .to_owned(),
            rays.map_or(String::new(), |rays| rays.count.to_string()),
            number(timing.median),
            field(&row.file),
        ];
        // Writing to a string does not fail.
        let _ = writeln!(out, "{}", cells.join(","));
    }
    out
}

/// The comparison of the layer that a row is judged by.
pub fn judged(row: &Row) -> Option<&Comparison> {
    row.comparison
        .layers
        .iter()
        .find(|layer| layer.layer == row.layer)
}

fn number(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

/// A field as RFC 4180 has it.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// What a pull request's reader wants to know.
pub fn markdown(report: &Report, timings: &Timings) -> String {
    let study = &report.study;
    let [width, height] = study.size;
    let mut out = format!(
        "## nephroid validate: {}\n\nSensor `{}`, {width} x {height} texels, {} \\[{}\\]. Truth: {}, {}.\n\n",
        study.scene,
        study.sensor,
        study.quantity.name(),
        study.unit,
        timings.truth.label,
        own_error(report),
    );
    out.push_str("| run | error | bias | rays | seconds | |\n|---|--:|--:|--:|--:|---|\n");
    for (row, timing) in report.rows.iter().zip(&timings.rows) {
        let rays = row.facts.as_ref().and_then(|facts| facts.counters.first());
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} |",
            row.label.replace('|', "\\|"),
            percent(row.error),
            signed_percent(row.bias),
            rays.map_or("-".to_owned(), |rays| format!("{:.3e}", rays.count as f64)),
            timing
                .median
                .map_or("-".to_owned(), |seconds| format!("{seconds:.2}")),
            remarks(row),
        );
    }
    out.push_str(
        "\nError: root mean square difference over the truth's mean, over lit texels. Not resolved: the truth's own error \
         is more than a tenth of it.\n",
    );
    for gate in &report.gates {
        let verdict = match gate.verdict {
            GateVerdict::Kept => "kept",
            GateVerdict::Undecided => "**undecided**",
            GateVerdict::Exceeded => "**exceeded**",
        };
        let _ = writeln!(
            out,
            "\nLimit of {} on `{}`: {verdict} ({}).",
            percent(Some(gate.limit)),
            gate.name,
            percent(gate.error)
        );
    }
    out
}

/// What the truth says of its own error.
fn own_error(report: &Report) -> String {
    let error = report.truth.facts.own_error;
    error.map_or("its error unknown".to_owned(), |error| {
        format!("its own error {}", percent(Some(error)))
    })
}

fn remarks(row: &Row) -> String {
    let unresolved = (!row.resolved).then(|| "not resolved".to_owned());
    let incomplete = row.facts.as_ref().is_some_and(|facts| !facts.complete);
    let incomplete = incomplete.then(|| "incomplete".to_owned());
    let checks = row.checks.iter().map(|check| check.message.clone());
    let all: Vec<String> = unresolved
        .into_iter()
        .chain(incomplete)
        .chain(checks)
        .collect();
    all.join("; ").replace('|', "\\|")
}

/// A fraction in percent, three digits.
pub fn percent(fraction: Option<f64>) -> String {
    fraction.map_or("-".to_owned(), |fraction| {
        format!("{} %", three_digits(100.0 * fraction))
    })
}

fn signed_percent(fraction: Option<f64>) -> String {
    let sign = |fraction: f64| if fraction > 0.0 { "+" } else { "" };
    fraction.map_or("-".to_owned(), |it| {
        format!("{}{}", sign(it), percent(Some(it)))
    })
}

fn three_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    if (0..=5).contains(&digits) {
        format!("{value:.*}", digits as usize)
    } else if digits < 0 {
        format!("{value:.0}")
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentages_have_three_digits() {
        assert_eq!(percent(Some(0.076_18)), "7.62 %");
        assert_eq!(percent(Some(12.345)), "1234 %");
        assert_eq!(percent(Some(1e-9)), "1.00e-7 %");
        assert_eq!(percent(Some(0.0)), "0 %");
        assert_eq!(signed_percent(Some(0.02)), "+2.00 %");
        assert_eq!(signed_percent(Some(-0.02)), "-2.00 %");
    }

    #[test]
    fn fields_with_commas_and_quotes_are_quoted() {
        assert_eq!(field("plain"), "plain");
        assert_eq!(field("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}
