//! The ledger of flux, for people and for programs.

use std::fmt;

use serde::Serialize;

use super::format::number;
use super::{Estimate, LayerName, Quantity};
use crate::radiometry::Rgb;
use crate::transport::ledger::FluxByFate;

/// The ledger in numbers \[W\].
#[derive(Clone, Debug, Serialize)]
pub struct LedgerSummary {
    /// Flux that photons started with; for beams the flux that met a specular surface first, mean of
    /// channels.
    pub emitted: Rgb,
    /// Flux that adjoint shading normals added; unknown for beams.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shading_gain: Option<Rgb>,
    /// By signature of the events before the end.
    pub rows: Vec<(String, RowSummary)>,
    /// Flux that is not received, for beams: by difference, mean of channels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elsewhere: Option<f64>,
    /// |emitted + gain − Σ rows| / emitted; of beams there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closure_error: Option<f64>,
}

/// Flux \[W\] by its end.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
pub enum RowSummary {
    /// In all ways.
    Fates(FluxByFate),
    /// On the sensor: no more is known of beams.
    Received {
        /// Flux in texels.
        received: Rgb,
    },
}

impl LedgerSummary {
    /// The ledger of an estimate; `None` where no light was traced, of cameras, and of techniques, which have
    /// an account of their own.
    pub fn of(estimate: &Estimate) -> Option<Self> {
        let is_kept = estimate.ledger.emitted != Rgb::BLACK;
        if estimate.quantity != Quantity::Irradiance || estimate.paths == 0 || !is_kept {
            return None;
        }
        let ledger = &estimate.ledger;
        let summary_of = |row: &FluxByFate| match ledger.elsewhere {
            None => RowSummary::Fates(*row),
            Some(_) => RowSummary::Received {
                received: row.received,
            },
        };
        let named = ledger.rows.iter();
        let mut rows: Vec<(String, RowSummary)> = named
            .map(|(signature, row)| (signature.to_string(), summary_of(row)))
            .collect();
        rows.push((LayerName::Other.to_string(), summary_of(&ledger.other)));
        Some(Self {
            emitted: ledger.emitted,
            shading_gain: ledger.elsewhere.is_none().then_some(ledger.shading_gain),
            rows,
            elsewhere: ledger.elsewhere,
            closure_error: ledger.closure_error(),
        })
    }
}

impl RowSummary {
    /// The columns of a table, means of channels.
    fn columns(&self) -> Vec<f64> {
        match self {
            Self::Fates(row) => [
                row.received,
                row.direct,
                row.escaped,
                row.absorbed,
                row.cut_off,
            ]
            .map(Rgb::mean)
            .to_vec(),
            Self::Received { received } => vec![received.mean()],
        }
    }
}

impl LedgerSummary {
    /// Writes it as a table whose first column is so wide.
    ///
    /// # Errors
    ///
    /// Where `out` takes no more.
    pub fn write(&self, out: &mut fmt::Formatter<'_>, wide: usize) -> fmt::Result {
        writeln!(out, "\nflux of the traced light [W], mean of channels")?;
        let fates = ["received", "direct", "escaped", "absorbed", "cut off"];
        let known = match self.elsewhere {
            None => &fates[..],
            Some(_) => &fates[..1],
        };
        write!(out, "  {:<wide$}", "after")?;
        for fate in known {
            write!(out, " {fate:>12}")?;
        }
        writeln!(out)?;
        let mut sum = vec![0.0; known.len()];
        for (name, row) in &self.rows {
            let columns = row.columns();
            for (sum, flux) in sum.iter_mut().zip(&columns) {
                *sum += flux;
            }
            if columns.iter().any(|flux| *flux != 0.0) {
                write_line(out, name, wide, &columns)?;
            }
        }
        write_line(out, "sum", wide, &sum)?;
        if let Some(elsewhere) = self.elsewhere {
            writeln!(out, "  elsewhere (by difference): {}", number(elsewhere))?;
        }
        write!(out, "  set out: {}", number(self.emitted.mean()))?;
        if let Some(error) = self.closure_error {
            write!(out, "; the ledger closes to {error:.1e}")?;
        }
        writeln!(out)
    }
}

fn write_line(
    out: &mut fmt::Formatter<'_>,
    name: &str,
    wide: usize,
    columns: &[f64],
) -> fmt::Result {
    write!(out, "  {name:<wide$}")?;
    for flux in columns {
        write!(out, " {:>12}", number(*flux))?;
    }
    writeln!(out)
}
