//! The summary of a finished run, for people and for programs.

use std::fmt;

use serde::Serialize;
use serde_json::{Map, Value};

use super::run::Run;
use crate::geometry::TraversalCounters;
use crate::run::Quantity;
use crate::run::account::LedgerSummary;
use crate::run::format::{number, relative};

/// The result in numbers. Serialised, it is what `--json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The scene file.
    pub scene: String,
    /// The sensor's id.
    pub sensor: String,
    /// The quantity that is measured.
    pub quantity: Quantity,
    /// Texels a row and rows.
    pub size: [usize; 2],
    /// The method.
    pub method: &'static str,
    /// True if the run used its whole budget.
    pub complete: bool,
    /// The method's own report, by name.
    #[serde(flatten)]
    pub report: Map<String, Value>,
    /// √(mean σ²) / mean E over lit texels of the specular layers, of paths over all light; of beams the
    /// likely error.
    pub relative_error: Option<f64>,
    /// One entry a layer, the total first.
    pub layers: Vec<LayerSummary>,
    /// If the traced flux went \[W\]; of a receiver, where any was traced.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ledger: Option<LedgerSummary>,
    /// Rays, and the work of finding what they hit.
    pub counters: TraversalCounters,
    /// Oddities of the scene or the run.
    pub warnings: Vec<String>,
    /// Time of the run; absent in files, which hold it apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timing: Option<Timing>,
    /// The files written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
    /// True if layers have bounds rather than standard errors.
    #[serde(skip)]
    has_bounds: bool,
    /// Paths started, and their unit.
    #[serde(skip)]
    started: (u64, &'static str),
    /// The method's own lines.
    #[serde(skip)]
    lines: Vec<String>,
}

/// One layer in numbers; NaN (in JSON `null`) where nothing is known.
#[derive(Clone, Debug, Serialize)]
pub struct LayerSummary {
    /// `E`, `LD`, `LTTD`, ...
    pub name: String,
    /// Smallest texel [W/m²].
    pub min: f64,
    /// Mean over texels [W/m²].
    pub mean: f64,
    /// Largest texel [W/m²].
    pub max: f64,
    /// √(mean σ²) / mean E over the layer's lit texels; where there are bounds, σ is half their distance.
    pub relative_error: Option<f64>,
}

/// Time and threads of a run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Timing {
    /// From the start of the command, reading and set-up included.
    pub seconds: f64,
    /// Threads used.
    pub threads: usize,
    /// Rays a second.
    pub rays_per_second: f64,
}

impl Timing {
    /// The timing of a run.
    pub fn of(run: &Run) -> Self {
        let seconds = run.elapsed.as_secs_f64();
        Self {
            seconds,
            threads: rayon::current_num_threads(),
            rays_per_second: run.rendering.estimate.counters.rays as f64 / seconds,
        }
    }
}

impl Summary {
    /// The summary of a run.
    pub fn of(run: &Run) -> Self {
        let rendering = run.rendering;
        let estimate = &rendering.estimate;
        // Attributes of files: a summary has the first two, and settings were typed.
        let report = rendering
            .report
            .iter()
            .filter(|(name, _)| !["method", "sensor", "settings"].contains(&name.as_str()));
        Self {
            scene: run.scene.path().display().to_string(),
            sensor: run.sensor.id.clone(),
            quantity: estimate.quantity,
            size: [estimate.width, estimate.height],
            method: run.method.name(),
            complete: !estimate.incomplete,
            report: report
                .map(|(name, value)| (name.replace('-', "_"), value.clone()))
                .collect(),
            relative_error: estimate.relative_error,
            layers: std::iter::once(&estimate.total)
                .chain(&estimate.layers)
                .map(|layer| {
                    let range = layer.range();
                    LayerSummary {
                        name: layer.name.of(estimate.quantity),
                        min: range.min,
                        mean: range.mean,
                        max: range.max,
                        relative_error: layer.relative_error(),
                    }
                })
                .collect(),
            ledger: LedgerSummary::of(estimate),
            counters: estimate.counters,
            warnings: rendering.all_warnings(run.scene),
            timing: Some(Timing::of(run)),
            files: Vec::new(),
            has_bounds: estimate.total.interval.is_some(),
            started: (estimate.paths, rendering.unit),
            lines: rendering.summary.clone(),
        }
    }

    /// The part that is the same for every run with the same settings.
    #[must_use]
    pub fn without_timing(&self) -> Self {
        Self {
            timing: None,
            files: Vec::new(),
            ..self.clone()
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for warning in &self.warnings {
            writeln!(out, "warning: {warning}")?;
        }
        let [width, height] = self.size;
        writeln!(
            out,
            "{} · sensor {} · {width} x {height} texels · {}{}",
            self.scene,
            self.sensor,
            self.method,
            if self.complete { "" } else { " · INCOMPLETE" }
        )?;
        let names = self.layers.iter().map(|layer| layer.name.len());
        let rows = self.ledger.iter().flat_map(|ledger| &ledger.rows);
        let names = names.chain(rows.map(|(name, _)| name.len()));
        let wide = names.fold("after".len(), usize::max) + 2;
        writeln!(out, "\n{} [{}]", self.quantity.name(), self.quantity.unit())?;
        writeln!(
            out,
            "  {:<wide$} {:>12} {:>12} {:>12} {:>12}",
            "layer",
            "min",
            "mean",
            "max",
            if self.has_bounds {
                "rel. bar"
            } else {
                "rel. error"
            }
        )?;
        for layer in &self.layers {
            writeln!(
                out,
                "  {:<wide$} {:>12} {:>12} {:>12} {:>12}",
                layer.name,
                number(layer.min),
                number(layer.mean),
                number(layer.max),
                relative(layer.relative_error, layer.max == 0.0)
            )?;
        }
        if let Some(ledger) = &self.ledger {
            ledger.write(out, wide)?;
        }
        writeln!(out)?;
        if let Some(timing) = &self.timing {
            let (seconds, threads) = (timing.seconds, timing.threads);
            match (self.started, self.counters.rays) {
                ((0, _), 0) => {
                    writeln!(out, "nothing traced, {seconds:.2} s on {threads} threads")?;
                }
                ((started, unit), rays) => {
                    let rate = timing.rays_per_second / 1e6;
                    writeln!(
                        out,
                        "{started} {unit}, {rays} rays in {seconds:.2} s on {threads} threads: {rate:.2} M rays/s"
                    )?;
                }
            }
        }
        for line in &self.lines {
            writeln!(out, "{line}")?;
        }
        for file in &self.files {
            writeln!(out, "wrote {file}")?;
        }
        Ok(())
    }
}
