//! What a finished run has to say, for people and for programs.

use std::fmt;

use serde::Serialize;

use super::ledger::LedgerSummary;
use super::output::{Run, Settings};
use crate::geometry::TraversalCounters;
use crate::reference::Quantity;
use crate::reference::beams::BeamReport;
use crate::reference::beams::pass::SignatureReport;
use crate::reference::full::{FullReport, PartDetail};
use crate::reference::path::PathReport;
use crate::transport::path_class::{PathClass, PathClasses};

/// The layer of direct light.
const LD: &str = "LD";

/// The result in numbers. Serialised, it is what `--json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The scene file.
    pub scene: String,
    /// The sensor's id.
    pub sensor: String,
    /// What is measured.
    pub quantity: Quantity,
    /// Texels a row and rows.
    pub size: [usize; 2],
    /// How it was computed.
    pub method: &'static str,
    /// Whether the run used its whole budget.
    pub complete: bool,
    /// Photons started.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub photons: Option<u64>,
    /// What there is to know of paths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<PathReport>,
    /// What there is to know of beams.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beams: Option<BeamReport>,
    /// What there is to know of photon maps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub photon_map: Option<MapSummary>,
    /// What there is to know of the parts that several methods measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full: Option<FullReport>,
    /// √(mean σ²) / mean E over lit texels of the specular layers, of paths over all light; of beams the likely error.
    pub relative_error: Option<f64>,
    /// One entry a layer, the total first.
    pub layers: Vec<LayerSummary>,
    /// Where the traced flux went \[W\]; of a receiver, where any was traced.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ledger: Option<LedgerSummary>,
    /// Rays, and the work of finding what they hit.
    pub counters: TraversalCounters,
    /// What is odd about the scene or the run.
    pub warnings: Vec<String>,
    /// What the run took; absent in files, which hold it apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timing: Option<Timing>,
    /// The files written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
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

/// Photon maps in numbers.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MapSummary {
    /// Maps of each replicate.
    pub passes: u64,
    /// Of the first and the last map's lookups, in pixels.
    pub radius: [f64; 2],
    /// √(mean bias²) / mean L over lit pixels, beyond what is noise.
    pub relative_bias: Option<f64>,
}

/// What a run took.
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
            rays_per_second: run.estimate.counters.rays as f64 / seconds,
        }
    }
}

impl Summary {
    /// The summary of a run.
    pub fn of(run: &Run) -> Self {
        let estimate = run.estimate;
        let mut warnings: Vec<String> = run
            .scene
            .warnings()
            .iter()
            .map(ToString::to_string)
            .collect();
        warnings.extend(run.warnings.iter().cloned());
        Self {
            scene: run.scene.path().display().to_string(),
            sensor: run.sensor.id.clone(),
            quantity: estimate.quantity,
            size: [estimate.width, estimate.height],
            method: run.method.name(),
            complete: !estimate.incomplete,
            photons: matches!(run.method, Settings::Photons(_) | Settings::PhotonMap(..))
                .then_some(estimate.paths),
            path: match run.method {
                Settings::Path(_, report) => Some(*report),
                _ => None,
            },
            beams: match run.method {
                Settings::Beams(_, report) => Some(report.clone()),
                _ => None,
            },
            photon_map: match run.method {
                Settings::PhotonMap(_, report) => Some(MapSummary {
                    passes: report.passes,
                    radius: report.radius,
                    relative_bias: report.relative_bias,
                }),
                _ => None,
            },
            full: match run.method {
                Settings::Full(_, report) => Some(report.clone()),
                _ => None,
            },
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
            warnings,
            timing: Some(Timing::of(run)),
            files: Vec::new(),
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

/// Six digits are enough for a table; zero is a dot, so that the eye finds what is there.
pub(super) fn number(value: f64) -> String {
    if value.is_nan() {
        "unknown".to_owned()
    } else if value == 0.0 {
        "·".to_owned()
    } else if (1e-3..1e6).contains(&value.abs()) {
        let digits = (5 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

fn percent(error: f64) -> String {
    format!("{:.3} %", 100.0 * error)
}

/// Classes of paths, by name.
pub(super) fn listed(classes: PathClasses) -> String {
    let names: Vec<&str> = classes.iter().map(PathClass::name).collect();
    names.join(", ")
}

/// A relative error: a dot where there is no light, and so no error.
fn relative(error: Option<f64>, is_dark: bool) -> String {
    match error {
        Some(error) => percent(error),
        None if is_dark => number(0.0),
        None => number(f64::NAN),
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
            if self.beams.is_some() || self.full.is_some() {
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
        match (&self.beams, &self.path, &self.full) {
            (Some(report), _, _) => self.write_beams(out, report)?,
            (_, Some(report), _) => self.write_path(out, report)?,
            (_, _, Some(report)) => self.write_full(out, report)?,
            (None, None, None) => self.write_photons(out)?,
        }
        for file in &self.files {
            writeln!(out, "wrote {file}")?;
        }
        Ok(())
    }
}

impl Summary {
    fn write_photons(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let (Some(timing), Some(photons)) = (&self.timing, self.photons) {
            writeln!(
                out,
                "{photons} photons, {} rays in {:.2} s on {} threads: {:.2} M photons/s, {:.2} M rays/s",
                self.counters.rays,
                timing.seconds,
                timing.threads,
                photons as f64 / timing.seconds / 1e6,
                timing.rays_per_second / 1e6
            )?;
        }
        writeln!(
            out,
            "relative standard error of the specular layers' sum over lit texels: {}",
            self.relative_error()
        )?;
        let Some(map) = &self.photon_map else {
            return Ok(());
        };
        let [first, last] = map.radius;
        writeln!(
            out,
            "{} maps a replicate, radius {first:.3} to {last:.3} pixels; relative bias of their blur: {}",
            map.passes,
            relative(map.relative_bias, false)
        )
    }

    fn write_path(&self, out: &mut fmt::Formatter<'_>, report: &PathReport) -> fmt::Result {
        if let Some(timing) = &self.timing {
            writeln!(
                out,
                "{} samples a pixel, {} rays in {:.2} s on {} threads: {:.2} M rays/s",
                report.samples,
                self.counters.rays,
                timing.seconds,
                timing.threads,
                timing.rays_per_second / 1e6
            )?;
        }
        writeln!(
            out,
            "relative standard error over lit pixels: {}",
            relative(self.relative_error, self.complete)
        )
    }

    fn write_full(&self, out: &mut fmt::Formatter<'_>, report: &FullReport) -> fmt::Result {
        for part in &report.parts {
            let what = match &part.detail {
                PartDetail::Path(report) => format!("{} samples a pixel", report.samples),
                PartDetail::Beams(report) => format!("{} passes", report.passes),
                PartDetail::PhotonMap(report) => format!(
                    "{} photons, relative bias {}",
                    part.paths,
                    relative(report.relative_bias, false)
                ),
                PartDetail::Photons {} => format!("{} photons", part.paths),
            };
            writeln!(
                out,
                "{} by {}: {what}; relative error {}",
                listed(part.classes),
                part.method.name(),
                relative(part.relative_error, !part.incomplete)
            )?;
        }
        self.write_ray_rate(out)?;
        writeln!(
            out,
            "relative standard error over lit pixels, of what is drawn by lot: {}",
            relative(self.relative_error, self.complete)
        )
    }

    /// Rays and what they took, where it is known.
    fn write_ray_rate(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(timing) = &self.timing else {
            return Ok(());
        };
        writeln!(
            out,
            "{} rays in {:.2} s on {} threads: {:.2} M rays/s",
            self.counters.rays,
            timing.seconds,
            timing.threads,
            timing.rays_per_second / 1e6
        )
    }

    /// Of the specular layers' sum.
    fn relative_error(&self) -> String {
        let mut specular = self.layers.iter().skip(1).filter(|layer| layer.name != LD);
        let is_dark = self.complete && specular.all(|layer| layer.max == 0.0);
        relative(self.relative_error, is_dark)
    }

    fn write_beams(&self, out: &mut fmt::Formatter<'_>, report: &BeamReport) -> fmt::Result {
        if report.passes == 0 {
            writeln!(out, "no pass was finished")?;
        } else {
            write_cells(out, report)?;
        }
        self.write_ray_rate(out)?;
        let balance = report.signatures.iter().map(|one| one.balance_error);
        if let Some(worst) = balance.reduce(f64::max) {
            writeln!(
                out,
                "largest balance error of a signature (what its cells booked against the film): {worst:.1e}"
            )?;
        }
        writeln!(
            out,
            "likely error of the specular layers' sum over lit texels: {}",
            self.relative_error()
        )?;
        if let Some(lamps) = &report.lamps {
            writeln!(
                out,
                "  by cells {}, by {} places on each area light in {} replicates {}; bars hold with {} % \
                 confidence",
                percent(lamps.deterministic_error),
                lamps.points,
                lamps.replicates,
                percent(lamps.random_error),
                100.0 * lamps.confidence
            )?;
        }
        Ok(())
    }
}

fn write_cells(out: &mut fmt::Formatter<'_>, report: &BeamReport) -> fmt::Result {
    let sum = |count: fn(&SignatureReport) -> u64| report.signatures.iter().map(count).sum::<u64>();
    writeln!(
        out,
        "{} signatures, {} cells ({} cut, {} unresolved) in the last of {} passes",
        report.signatures.len(),
        sum(|one| one.cells),
        sum(|one| one.cut_cells),
        sum(|one| one.unresolved_cells),
        report.passes
    )
}
