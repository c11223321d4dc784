//! What every reference delivers.

use std::fmt;

use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::transport::ledger::Ledger;
use crate::transport::signature::Signature;

/// An irradiance map with its error bar, layer by layer.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Texels a row.
    pub width: usize,
    /// Rows; row 0 is at v = 0.
    pub height: usize,
    /// All light from specular chains and the direct light: the sum of the layers.
    pub total: Layer,
    /// `LD` first, then one layer a signature, then what is left.
    pub layers: Vec<Layer>,
    /// Contributions a texel, all specular layers together.
    pub counts: Vec<u64>,
    /// Where all traced flux went.
    pub ledger: Ledger,
    /// How many light paths were started.
    pub paths: u64,
    /// Rays, and the work of finding what they hit.
    pub counters: TraversalCounters,
    /// Standard error of the specular layers' sum, relative: √(mean σ²) / mean E over its lit
    /// texels; `None` where nothing is lit or no error is known.
    pub relative_error: Option<f64>,
    /// Whether the run was stopped before its budget was used.
    pub incomplete: bool,
}

/// Irradiance of one kind of light.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Which kind.
    pub name: LayerName,
    /// Texel averages [W/m²], row by row.
    pub irradiance: Vec<Rgb>,
    /// One standard error of each [W/m²]; NaN where there is no estimate of it.
    pub standard_error: Vec<Rgb>,
}

/// A kind of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerName {
    /// The sum of all layers: `E`.
    Total,
    /// One path signature: `LD`, `LRD`, `LTTD`, ...
    Path(Signature),
    /// All signatures that have no layer of their own: `other`.
    Other,
}

impl fmt::Display for LayerName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Total => formatter.pad("E"),
            Self::Path(signature) => signature.fmt(formatter),
            Self::Other => formatter.pad("other"),
        }
    }
}

impl Layer {
    /// A layer of `texels` texels without light and without error.
    pub fn dark(name: LayerName, texels: usize) -> Self {
        Self {
            name,
            irradiance: vec![Rgb::BLACK; texels],
            standard_error: vec![Rgb::BLACK; texels],
        }
    }

    /// Smallest, mean and largest irradiance over all texels [W/m²], channels averaged.
    pub fn range(&self) -> Range {
        let mut range = Range {
            min: f64::INFINITY,
            mean: 0.0,
            max: f64::NEG_INFINITY,
        };
        for value in &self.irradiance {
            let value = value.mean();
            range.min = range.min.min(value);
            range.max = range.max.max(value);
            range.mean += value;
        }
        range.mean /= self.irradiance.len() as f64;
        range
    }

    /// √(mean σ²) / mean E over the texels with E > 0, channels averaged; `None` where there
    /// are none.
    pub fn relative_error(&self) -> Option<f64> {
        relative_error(
            self.irradiance
                .iter()
                .zip(&self.standard_error)
                .map(|(value, error)| (value.mean(), error.mean())),
        )
    }
}

/// Smallest, mean and largest of a map.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Range {
    /// Smallest.
    pub min: f64,
    /// Mean over texels.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// √(mean σ²) / mean E over pairs (E, σ) with E > 0.
pub(crate) fn relative_error(texels: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let (mut lit, mut sum, mut squares) = (0_u64, 0.0, 0.0);
    for (value, error) in texels {
        if value > 0.0 {
            lit += 1;
            sum += value;
            squares += error * error;
        }
    }
    if lit == 0 || squares.is_nan() {
        return None;
    }
    let lit = lit as f64;
    Some((squares / lit).sqrt() / (sum / lit))
}
