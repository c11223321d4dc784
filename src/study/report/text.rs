//! A report as a table for spreadsheets, and as Markdown for pull requests.

use std::fmt::Write as _;

use super::super::machine::Machine;
use super::figures::{
    GateVerdict, ReportRow, RunTiming, SensorFigures, SensorTimings, StudyReport, Timings,
    TruthFigures,
};
use crate::metric::{Bounded, Fidelity, LayerComparison};
use crate::run::Quantity;
use crate::run::format::three_digits;

/// The table: a line a row, numbers as in the JSON, empty fields for those that are unknown.
pub fn csv(report: &StudyReport, timings: &Timings) -> String {
    let mut out = String::from(
        "sensor,name,label,layer,error,truth_error,resolved,energy,misplaced,displaced_texels,displaced_low,displaced_high,\
         displaced_metres,l2,resolution_texels,resolution_metres,picture_flip,picture_ssim,half_in,relative_rmse,rel_mse,\
         smape,verdict,rays,seconds,file\n",
    );
    for (sensor, timings) in report.sensors.iter().zip(&timings.sensors) {
        for (row, timing) in sensor.rows.iter().zip(&timings.rows) {
            // Writing to a string does not fail.
            let _ = writeln!(out, "{},{}", field(&sensor.sensor), line(row, timing));
        }
    }
    out
}

fn line(row: &ReportRow, timing: &RunTiming) -> String {
    let judged = judged(row);
    let figure = |figure: fn(&LayerComparison) -> Option<f64>| number(judged.and_then(figure));
    let light = |figure: fn(&Fidelity) -> Option<f64>| {
        number(judged.and_then(|layer| figure(&layer.fidelity)))
    };
    let cells = [
        field(&row.name),
        field(&row.label),
        field(&row.layer),
        number(row.error),
        number(row.truth_error),
        row.resolved.to_string(),
        light(|it| Some(it.energy?.value)),
        light(|it| Some(it.misplaced?.value)),
        light(|it| Some(it.displaced.as_ref()?.texels.value)),
        light(|it| it.displaced.as_ref()?.texels.low),
        light(|it| it.displaced.as_ref()?.texels.high),
        light(|it| Some(it.displaced.as_ref()?.metres?.value)),
        light(|it| Some(it.l2?.value)),
        light(|it| Some(it.resolution?.texels.value)),
        light(|it| it.resolution?.metres),
        number(row.picture.and_then(|it| it.flip)),
        number(row.picture.and_then(|it| it.ssim)),
        number(row.half_in),
        figure(|it| it.difference.relative_rmse),
        figure(|it| it.difference.rel_mse),
        figure(|it| it.difference.smape),
        judged
            .map_or("", |it| it.equivalence.verdict.name())
            .to_owned(),
        rays(row).map_or(String::new(), |rays| rays.to_string()),
        number(timing.median),
        field(&row.file),
    ];
    cells.join(",")
}

/// Number of rays traced.
fn rays(row: &ReportRow) -> Option<u64> {
    let counters = &row.facts.as_ref()?.counters;
    counters
        .iter()
        .find(|counter| counter.name == "rays")
        .map(|counter| counter.count)
}

/// The comparison of the layer that a row is judged by.
pub fn judged(row: &ReportRow) -> Option<&LayerComparison> {
    row.comparison
        .layers
        .iter()
        .find(|layer| layer.layer == row.layer)
}

fn number(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

/// A field as RFC 4180 has it.
pub fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// The summary for the reader of a pull request.
pub fn markdown(report: &StudyReport, timings: &Timings) -> String {
    let mut out = format!("## nephroid validate: {}\n", report.study.scene);
    let several = timings.machines().len() > 1;
    for (sensor, timings) in report.sensors.iter().zip(&timings.sensors) {
        out.push_str(&section(sensor, timings, several));
    }
    out.push_str(
        "\nOver all texels; a black image has an L1 of 100 %. Energy: flux over the truth's. L1: sum of absolute differences over \
         the truth's sum. Misplaced: light in a wrong texel, at equal flux. Displaced: how far light is from its place, on \
         average. Right at: the smallest square over which means are right to 10 %. Not resolved: the truth's own error is more \
         than a tenth of L1.\n",
    );
    for sensor in &report.sensors {
        for gate in &sensor.gates {
            let verdict = match gate.verdict {
                GateVerdict::Kept => "kept",
                GateVerdict::Undecided => "**undecided**",
                GateVerdict::Exceeded => "**exceeded**",
            };
            let place = if report.sensors.len() > 1 {
                format!(" on `{}`", sensor.sensor)
            } else {
                String::new()
            };
            let _ = writeln!(
                out,
                "\nLimit of {} on `{}`{place}: {verdict} ({}).",
                gate.limit,
                gate.name,
                gate.error
                    .map_or("-".to_owned(), |it| gate.limit.show(it.value))
            );
        }
    }
    out
}

/// One sensor; each row with its machine if the report is of several.
fn section(sensor: &SensorFigures, timings: &SensorTimings, several_machines: bool) -> String {
    let [width, height] = sensor.size;
    let mut out = format!(
        "\nSensor `{}`, {width} x {height} {}, {} \\[{}\\]. Truth: {}, {}.\n\n",
        sensor.sensor,
        match sensor.quantity {
            Quantity::Irradiance => "texels",
            Quantity::Radiance => "pixels",
        },
        sensor.quantity.name(),
        sensor.unit,
        sensor.truth.label,
        own_error(&sensor.truth),
    );
    for answer in &sensor.answers {
        let _ = writeln!(out, "- **{}** {}", answer.name, answer.sentences.join(" "));
    }
    out.push_str(
        "\n| run | energy | L1 | misplaced | displaced [texels] | right at [texels] | rays | seconds | |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|---|\n",
    );
    for (row, timing) in sensor.rows.iter().zip(&timings.rows) {
        let light = judged(row).map(|layer| &layer.fidelity);
        let part = |figure: fn(&Fidelity) -> Option<Bounded>| {
            percent(light.and_then(|it| Some(figure(it)?.value)))
        };
        let texels = |figure: fn(&Fidelity) -> Option<f64>| {
            light.and_then(figure).map_or("-".to_owned(), three_digits)
        };
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            row.label.replace('|', "\\|"),
            part(|it| it.energy),
            percent(row.error),
            part(|it| it.misplaced),
            texels(|it| Some(it.displaced.as_ref()?.texels.value)),
            texels(|it| Some(it.resolution?.texels.value)),
            rays(row).map_or("-".to_owned(), |rays| format!("{:.3e}", rays as f64)),
            timing
                .median
                .map_or("-".to_owned(), |seconds| format!("{seconds:.2}")),
            remarks(
                sensor,
                row,
                timing.machine.as_ref().filter(|_| several_machines)
            ),
        );
    }
    for note in &timings.notes {
        let _ = writeln!(out, "\n{note}.");
    }
    out
}

/// The truth's estimate of its own error.
fn own_error(truth: &TruthFigures) -> String {
    let error = truth.facts.own_error;
    error.map_or("its error unknown".to_owned(), |error| {
        format!("its own error {}", percent(Some(error)))
    })
}

fn remarks(sensor: &SensorFigures, row: &ReportRow, machine: Option<&Machine>) -> String {
    let is_of_one_layer = row.layer != sensor.quantity.symbol();
    let layer = is_of_one_layer.then(|| format!("{} only", row.layer));
    let unresolved = (!row.resolved).then(|| "not resolved".to_owned());
    let incomplete = row.facts.as_ref().is_some_and(|facts| !facts.complete);
    let incomplete = incomplete.then(|| "incomplete".to_owned());
    let same = (!row.same.is_empty()).then(|| format!("the same film: {}", row.same.join(", ")));
    let checks = row.checks.iter().map(|check| check.message.clone());
    let all: Vec<String> = layer
        .into_iter()
        .chain(unresolved)
        .chain(same)
        .chain(incomplete)
        .chain(machine.map(|machine| format!("on {}, {}", machine.host, machine.processor)))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentages_have_three_digits() {
        assert_eq!(percent(Some(0.076_18)), "7.62 %");
        assert_eq!(percent(Some(12.345)), "1234 %");
        assert_eq!(percent(Some(1e-9)), "1.00e-7 %");
        assert_eq!(percent(Some(0.0)), "0 %");
    }

    #[test]
    fn fields_with_commas_and_quotes_are_quoted() {
        assert_eq!(field("plain"), "plain");
        assert_eq!(field("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}
