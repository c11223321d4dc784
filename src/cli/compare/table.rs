//! The figures of a comparison as tables.

use std::fmt;

use crate::metric::difference::{EPSILON, PER_MILLE};
use crate::metric::{Bounded, Comparison, ImageSide, LayerComparison};
use crate::run::format::{number, three_digits};

/// A report for people.
pub(super) struct TextTable<'a> {
    report: &'a Comparison,
    unit: &'a str,
    files: &'a [String],
}

/// The mark for a figure that does not exist.
const NOTHING: &str = "-";

impl<'a> TextTable<'a> {
    pub(super) fn new(report: &'a Comparison, unit: Option<&'a str>, files: &'a [String]) -> Self {
        Self {
            report,
            unit: unit.unwrap_or("in the images' unit"),
            files,
        }
    }

    /// A title, a line of headings, and a line for each layer.
    fn block(
        &self,
        out: &mut fmt::Formatter,
        title: &str,
        headings: &[&str],
        cells: impl Fn(&LayerComparison) -> Option<Vec<String>>,
    ) -> fmt::Result {
        let lines: Vec<(&str, Vec<String>)> = self
            .report
            .layers
            .iter()
            .filter_map(|layer| Some((layer.layer.as_str(), cells(layer)?)))
            .collect();
        if lines.is_empty() {
            return Ok(());
        }
        let length = |text: &str| text.chars().count();
        let first = lines.iter().map(|(name, _)| length(name));
        let first = first.fold("layer".len(), usize::max);
        let widths: Vec<usize> = (0..headings.len())
            .map(|i| {
                let cells = lines.iter().map(|(_, cells)| length(&cells[i]));
                cells.fold(length(headings[i]).max(10), usize::max)
            })
            .collect();
        writeln!(out, "\n{title}")?;
        write!(out, "  {:<first$}", "layer")?;
        for (heading, width) in headings.iter().zip(&widths) {
            write!(out, "  {heading:>width$}")?;
        }
        writeln!(out)?;
        for (name, cells) in &lines {
            write!(out, "  {name:<first$}")?;
            for (cell, width) in cells.iter().zip(&widths) {
                write!(out, "  {cell:>width$}")?;
            }
            writeln!(out)?;
        }
        Ok(())
    }

    /// How much light, how far from its place, right at which scale.
    fn light(&self, out: &mut fmt::Formatter) -> fmt::Result {
        self.block(
            out,
            "light, over all texels (a black image has L1 = L2 = 100 %)",
            &[
                "energy",
                "L1",
                "misplaced",
                "displaced",
                "L2",
                "right to 10 % at",
            ],
            |layer| {
                let it = &layer.fidelity;
                Some(vec![
                    optional(it.energy, |energy| within(energy, 100.0, " %")),
                    optional(it.l1, |l1| within(l1, 100.0, " %")),
                    optional(it.misplaced, |misplaced| within(misplaced, 100.0, " %")),
                    optional(it.displaced.as_ref(), |displaced| {
                        let metres = displaced.metres.map(|it| within(it, 1.0, " m"));
                        let texels = within(displaced.texels, 1.0, " texels");
                        [texels]
                            .into_iter()
                            .chain(metres)
                            .collect::<Vec<_>>()
                            .join(" = ")
                    }),
                    optional(it.l2, |l2| within(l2, 100.0, " %")),
                    it.resolution.map_or_else(
                        || if it.l1.is_some() { "no scale" } else { NOTHING }.to_owned(),
                        |it| {
                            let metres = it
                                .metres
                                .map(|metres| format!(" = {} m", three_digits(metres)));
                            let texels = three_digits(it.texels.value);
                            format!("{texels} texels{}", metres.unwrap_or_default())
                        },
                    ),
                ])
            },
        )
    }

    fn differences(&self, out: &mut fmt::Formatter) -> fmt::Result {
        let settings = &self.report.settings;
        let confidence = 100.0 * (1.0 - settings.level);
        let interval = format!("{} % interval", rounded(confidence));
        self.block(
            out,
            &format!("means [{}]", self.unit),
            &[
                "reference",
                "other",
                "bias",
                "bias/mean",
                &interval,
                "energy ratio",
            ],
            |layer| {
                let (difference, bias) = (&layer.difference, &layer.equivalence.bias);
                Some(vec![
                    number(difference.mean_reference),
                    number(difference.mean_other),
                    number(bias.bias),
                    signed_percent(bias.relative),
                    bias.interval.map_or(NOTHING.to_owned(), |[low, high]| {
                        format!("{:+.3} .. {:+.3} %", 100.0 * low, 100.0 * high)
                    }),
                    optional(difference.energy_ratio, |ratio| format!("{ratio:.6}")),
                ])
            },
        )?;
        self.block(
            out,
            "texels",
            &[
                "RMSE",
                "rel. RMSE",
                "MAE",
                "relMSE",
                "SMAPE",
                "PSNR [dB]",
                "SSIM",
                "FLIP",
            ],
            |layer| {
                let it = &layer.difference;
                let is_equal = it.rmse == 0.0 && it.psnr_peak > 0.0;
                Some(vec![
                    number(it.rmse),
                    percent(it.relative_rmse),
                    number(it.mae),
                    optional(it.rel_mse, number),
                    optional(it.smape, number),
                    match it.psnr {
                        None if is_equal => "infinite".to_owned(),
                        psnr => optional(psnr, |psnr| format!("{psnr:.2}")),
                    },
                    optional(layer.similarity, |it| format!("{:.6}", it.ssim)),
                    optional(layer.flip, |flip| format!("{:.6}", flip.mean)),
                ])
            },
        )?;
        let percents = PER_MILLE.map(|per_mille| format!("{} %", f64::from(per_mille) / 10.0));
        let mut headings: Vec<&str> = percents.iter().map(String::as_str).collect();
        headings.extend(["largest", "at (x, y)", "reference", "other"]);
        self.block(
            out,
            &format!("percentiles of |difference| [{}]", self.unit),
            &headings,
            |layer| {
                let worst = &layer.difference.worst;
                let values = |values: &[f64]| {
                    let texts: Vec<String> = values.iter().map(|value| number(*value)).collect();
                    texts.join(" ")
                };
                let percentiles = layer.difference.percentiles.iter();
                let mut cells: Vec<String> = percentiles.map(|one| number(one.value)).collect();
                cells.push(number(worst.difference));
                cells.push(format!("{}, {}", worst.x, worst.y));
                cells.push(values(&worst.reference));
                cells.push(values(&worst.other));
                Some(cells)
            },
        )
    }

    fn tests(&self, out: &mut fmt::Formatter) -> fmt::Result {
        self.block(
            out,
            "error bars: z = difference / standard error",
            &[
                "tests",
                "mean z",
                "mean z²",
                "largest",
                "at (x, y)",
                "p (Šidák)",
                "p uniform?",
                "says",
            ],
            |layer| {
                let it = layer.significance.as_ref()?;
                let extreme = it.extreme.as_ref();
                Some(vec![
                    it.tests.to_string(),
                    number(it.mean_z),
                    number(it.mean_square_z),
                    optional(extreme, |extreme| number(extreme.z)),
                    optional(extreme, |extreme| format!("{}, {}", extreme.x, extreme.y)),
                    format!("{:.3}", it.family.p),
                    optional(it.uniformity, |uniformity| {
                        let answer = if uniformity.uniform { "yes" } else { "no" };
                        format!("{answer}, {:.3}", uniformity.p)
                    }),
                    if it.family.different {
                        "texels differ".to_owned()
                    } else {
                        "explained".to_owned()
                    },
                ])
            },
        )?;
        let settings = &self.report.settings;
        let interval = format!(
            "{} % interval",
            rounded(100.0 * (1.0 - 2.0 * settings.level))
        );
        self.block(
            out,
            &format!(
                "within {} % of the reference's mean?",
                rounded(100.0 * settings.margin)
            ),
            &[
                "means (TOST p)",
                "texels beyond bars",
                &interval,
                "texels",
                "verdict",
            ],
            |layer| {
                let it = &layer.equivalence;
                let p = optional(it.bias.p, |p| format!(" ({p:.3})"));
                Some(vec![
                    format!("{}{p}", it.bias.verdict.name()),
                    percent(it.texels.unexplained),
                    it.texels
                        .interval
                        .map_or(NOTHING.to_owned(), |[low, high]| {
                            format!("{:.3} .. {:.3} %", 100.0 * low, 100.0 * high)
                        }),
                    it.texels.verdict.name().to_owned(),
                    it.verdict.name().to_owned(),
                ])
            },
        )
    }

    /// Prints the conventions and settings that the figures depend on.
    fn conventions(&self, out: &mut fmt::Formatter) -> fmt::Result {
        let Some(layer) = self.report.layers.first() else {
            return Ok(());
        };
        let it = &layer.difference;
        writeln!(
            out,
            "\nrel. RMSE is √(mean d²) / mean of the reference, over lit texels (reference > 0); relMSE has ε = {EPSILON} mean² \
             ({} for {}), SMAPE ε = {EPSILON} mean ({});",
            number(it.rel_mse_epsilon),
            layer.layer,
            number(it.smape_epsilon),
        )?;
        write!(
            out,
            "PSNR's peak is the reference's largest value ({})",
            number(it.psnr_peak)
        )?;
        if let Some(it) = layer.similarity {
            write!(
                out,
                "; SSIM has a Gaussian window of {} x {} texels (σ = {}), its range is the 99th percentile ({})",
                it.window,
                it.window,
                it.deviation,
                number(it.dynamic_range)
            )?;
        }
        if let Some(flip) = layer.flip {
            let exposures = flip.exposures;
            write!(
                out,
                "; FLIP is HDR-FLIP, {:.1} pixels a degree, {} exposures of {:+.2} to {:+.2} stops",
                flip.pixels_per_degree, exposures.count, exposures.start, exposures.stop
            )?;
        }
        writeln!(out, "; docs/compare.md has the formulas")?;
        let mut reasons = self
            .report
            .layers
            .iter()
            .filter_map(|it| it.fidelity.not_displaced.as_ref());
        if let Some(reason) = reasons.next() {
            writeln!(out, "no displacement: {reason}")?;
        }
        let layers = || self.report.layers.iter();
        if layers().any(|layer| layer.significance.as_ref().is_some_and(|it| it.has_bounds)) {
            writeln!(
                out,
                "bounds: z counts from the end of an interval, so its p-values are not uniform by design"
            )?;
        }
        if layers().all(|layer| layer.significance.is_none()) {
            writeln!(
                out,
                "neither image has error bars: nothing tells noise from difference"
            )?;
        }
        let tested = || layers().filter_map(|one| Some((&one.layer, one.significance.as_ref()?)));
        for (layer, it) in tested().filter(|(_, it)| it.few > 0) {
            writeln!(
                out,
                "{layer}: {} values of few samples are judged by their bounds, beside the {} of the means of z",
                it.few, it.tests
            )?;
        }
        for (layer, it) in tested().filter(|(_, it)| it.untested > 0) {
            writeln!(
                out,
                "{layer}: {} values differ where an image says 0 for its standard error (no sample arrived): not tested",
                it.untested
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for TextTable<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let report = self.report;
        let mark = |side: ImageSide| {
            if report.settings.reference == side {
                " (reference)"
            } else {
                ""
            }
        };
        write!(
            out,
            "A {}{} · B {}{}",
            report.a,
            mark(ImageSide::A),
            report.b,
            mark(ImageSide::B)
        )?;
        if let Some(layer) = report.layers.first() {
            write!(out, " · {} x {} texels", layer.size[0], layer.size[1])?;
        }
        writeln!(out)?;
        self.light(out)?;
        self.differences(out)?;
        self.tests(out)?;
        self.conventions(out)?;
        for note in &report.notes {
            writeln!(out, "note: {note}")?;
        }
        for file in self.files {
            writeln!(out, "wrote {file}")?;
        }
        write!(
            out,
            "verdict at {} %: {}",
            rounded(100.0 * report.settings.margin),
            report.verdict.name()
        )
    }
}

/// A figure in a unit, and what the reference's bars allow.
fn within(figure: Bounded, factor: f64, unit: &str) -> String {
    let digits = |value: f64| three_digits(factor * value);
    let ends = match (figure.low, figure.high) {
        (Some(low), Some(high)) => format!(" ({} .. {})", digits(low), digits(high)),
        (Some(low), None) => format!(" (from {})", digits(low)),
        _ => String::new(),
    };
    format!("{}{unit}{ends}", digits(figure.value))
}

fn optional<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| NOTHING.to_owned(), text)
}

fn percent(value: Option<f64>) -> String {
    optional(value, |value| format!("{:.4} %", 100.0 * value))
}

fn signed_percent(value: Option<f64>) -> String {
    optional(value, |value| format!("{:+.4} %", 100.0 * value))
}

/// A percentage without the last digits, which come from a product of decimals.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
