//! Films of a study, and the facts known of them.

use serde::{Deserialize, Serialize};

use crate::film::Image;
use crate::radiometry::Rgb;
use crate::run::{Counter, Estimate, FluxEntry, Layer, LayerName, Light, Quantity, Rendering};
use crate::transport::signature::Signature;

/// A film of a study, with everything that is known of it.
#[derive(Clone, Debug)]
pub struct Product {
    /// The layers as channels, as [`CompareImage`](crate::metric::CompareImage) reads them.
    pub image: Image,
    /// The quantity that is measured.
    pub quantity: Quantity,
    /// Time \[s\] of the film by the method's own clock, if it leaves out preparations that a frame does not
    /// repeat; otherwise the whole run counts.
    pub seconds: Option<f64>,
    /// Everything else.
    pub facts: Facts,
}

/// Facts known of a film beside its texels, timings apart: the same on every machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// The layer that the method is judged by: all light, or the only light that it models.
    pub judged: String,
    /// How many independent replicates standard errors come from.
    pub replicates: Option<u32>,
    /// Work, counted: noise-free, in the order of importance.
    pub counters: Vec<Counter>,
    /// What the method says of its own error, relative, over lit texels of the light it measured itself.
    pub own_error: Option<f64>,
    /// What is known of the error of each part of the light.
    pub spread: Spread,
    /// Where the flux went.
    pub ledger: Option<LedgerTable>,
    /// What each stage of a technique does to the flux; empty for references.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stage_flux: Vec<StageFlux>,
    /// Whether the budget was used and the error asked for reached.
    pub complete: bool,
    /// What is odd about the scene or the run.
    pub warnings: Vec<String>,
}

/// What a stage of a technique does to the flux, and why. All entries add up to the flux of the image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageFlux {
    /// The stage.
    pub stage: String,
    /// The reason.
    pub reason: String,
    /// The change \[W\], mean of channels; the first entry is what sets out.
    pub flux: f64,
    /// Photons, or corners of beams, that came to nothing for this reason.
    pub photons: u64,
}

/// Root mean square over all texels of one (likely) standard error, in the film's unit, by part of the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Of light that came by way of mirrors or glass (to a camera: of all light); `None` where it is not
    /// known.
    pub specular: Option<f64>,
    /// Of direct light on a receiver: of a quadrature's bounds, half their distance.
    pub direct: f64,
}

/// Flux by what it met and how it ended \[W\], mean of channels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LedgerTable {
    /// Flux that was traced.
    pub emitted: f64,
    /// By signature of the events before the end; rows without flux left out.
    pub rows: Vec<LedgerRow>,
    /// What ended elsewhere, by difference: of methods that follow only what is received.
    pub elsewhere: Option<f64>,
    /// |emitted + gain − Σ rows| / emitted; `None` where part is known by difference.
    pub closure_error: Option<f64>,
}

/// One signature's flux \[W\], mean of channels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LedgerRow {
    /// The signature.
    pub after: String,
    /// In texels of the sensor.
    pub received: f64,
    /// In texels, without a specular event.
    pub direct: f64,
    /// Left the scene.
    pub escaped: f64,
    /// On surfaces.
    pub absorbed: f64,
    /// Past the deepest level.
    pub cut_off: f64,
}

impl Product {
    /// The result of a run. A method that models only a part of the light is judged by that part, and all its
    /// light is that layer's.
    pub fn of(rendering: &Rendering) -> Self {
        let estimate = &rendering.estimate;
        let is_all = rendering.light == Light::All;
        let judged = match estimate.layers.first() {
            Some(layer) if !is_all => layer.name.to_string(),
            _ => estimate.quantity.symbol().to_owned(),
        };
        Self {
            image: if is_all {
                estimate.channels()
            } else {
                of_layer(estimate, &judged)
            },
            quantity: estimate.quantity,
            seconds: rendering.frame_time.map(|time| time.as_secs_f64()),
            facts: Facts {
                judged,
                replicates: rendering.replicates,
                counters: rendering.counters.clone(),
                own_error: estimate.relative_error,
                spread: if is_all {
                    Spread::of(estimate)
                } else {
                    Spread::default()
                },
                ledger: LedgerTable::of(estimate).filter(|_| is_all),
                stage_flux: rendering.flux.iter().map(StageFlux::of).collect(),
                complete: !estimate.incomplete,
                warnings: rendering.warnings.clone(),
            },
        }
    }
}

impl StageFlux {
    fn of(entry: &FluxEntry) -> Self {
        Self {
            stage: entry.stage.to_owned(),
            reason: entry.reason.to_owned(),
            flux: entry.flux.mean(),
            photons: entry.photons,
        }
    }
}

/// A film of one layer, of whose error nothing is known.
fn of_layer(estimate: &Estimate, layer: &str) -> Image {
    let mut image = Image::new(estimate.width, estimate.height);
    let values = estimate.total.values.iter();
    let triples: Vec<[f64; 3]> = values.map(|value| value.0).collect();
    for name in [estimate.quantity.symbol(), layer] {
        image.add_rgb(name, &triples);
    }
    image
}

impl Spread {
    /// [`Estimate::relative_error`] is √(Σ σ² / n) / (Σ E / n) over the n lit texels of specular light: so
    /// Σ σ² = (error · Σ E)² / n.
    fn of(estimate: &Estimate) -> Self {
        let direct = estimate
            .layers
            .iter()
            .find(|layer| layer.name == LayerName::Path(Signature::DIRECT));
        let texels = estimate.total.values.len() as f64;
        let (mut lit, mut sum) = (0.0, 0.0);
        for (texel, total) in estimate.total.values.iter().enumerate() {
            let own = direct.map_or(Rgb::BLACK, |layer| layer.values[texel]);
            let specular = (*total - own).mean();
            if specular > 0.0 {
                lit += 1.0;
                sum += specular;
            }
        }
        Self {
            specular: if lit == 0.0 {
                Some(0.0)
            } else {
                estimate
                    .relative_error
                    .map(|error| error * sum / (lit * texels).sqrt())
            },
            direct: direct.map_or(0.0, |layer| root_mean_square(&bars(layer))),
        }
    }
}

/// One error bar a texel, channels averaged: half the distance of bounds, else the standard error.
fn bars(layer: &Layer) -> Vec<f64> {
    match &layer.interval {
        Some(interval) => {
            let pairs = interval.low.iter().zip(&interval.high);
            pairs
                .map(|(low, high)| 0.5 * (*high - *low).mean())
                .collect()
        }
        None => layer
            .standard_error
            .iter()
            .map(|error| error.mean())
            .collect(),
    }
}

fn root_mean_square(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|value| value * value).sum();
    (squares / values.len().max(1) as f64).sqrt()
}

impl LedgerTable {
    /// The ledger of an estimate; `None` where no light was traced, and of cameras, which receive none.
    fn of(estimate: &Estimate) -> Option<Self> {
        if estimate.quantity != Quantity::Irradiance || estimate.paths == 0 {
            return None;
        }
        let ledger = &estimate.ledger;
        let named = ledger
            .rows
            .iter()
            .map(|(name, row)| (name.to_string(), row));
        let rows = named
            .chain([(LayerName::Other.to_string(), &ledger.other)])
            .filter(|(_, row)| !row.total().is_black())
            .map(|(after, row)| LedgerRow {
                after,
                received: row.received.mean(),
                direct: row.direct.mean(),
                escaped: row.escaped.mean(),
                absorbed: row.absorbed.mean(),
                cut_off: row.cut_off.mean(),
            });
        Some(Self {
            emitted: ledger.emitted.mean(),
            rows: rows.collect(),
            elsewhere: ledger.elsewhere,
            closure_error: ledger.closure_error(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::TraversalCounters;
    use crate::metric::{CompareImage, CompareSettings, compare};
    use crate::transport::ledger::Ledger;

    #[test]
    fn a_film_of_one_layer_is_compared_by_that_layer() {
        let signature: Signature = "LTTD".parse().unwrap();
        let values = vec![Rgb::grey(1.0), Rgb::grey(3.0)];
        let layer = |name| Layer {
            values: values.clone(),
            ..Layer::dark(name, 2)
        };
        let estimate = Estimate {
            quantity: Quantity::Irradiance,
            width: 2,
            height: 1,
            total: layer(LayerName::Total),
            layers: vec![layer(LayerName::Path(signature))],
            counts: vec![0; 2],
            ledger: Ledger::default(),
            paths: 0,
            counters: TraversalCounters::default(),
            relative_error: None,
            incomplete: false,
        };
        let product = Product::of(&Rendering {
            light: Light::Path(signature),
            ..Rendering::new(estimate)
        });
        assert_eq!(product.facts.judged, "LTTD");
        // The truth has direct light, too, which the method does not model.
        let mut truth = Image::new(2, 1);
        truth.add_rgb("E", &[[6.0; 3], [8.0; 3]]);
        truth.add_rgb("LTTD", &[[1.0; 3], [3.0; 3]]);
        let sources = [
            CompareImage::new("truth", truth),
            CompareImage::new("film", product.image),
        ];
        let report = compare(&sources[0], &sources[1], &CompareSettings::default()).unwrap();
        let named = |name: &str| report.layers.iter().find(|layer| layer.layer == name);
        assert_eq!(named("LTTD").unwrap().difference.rmse, 0.0);
        assert_eq!(named("E").unwrap().difference.rmse, 5.0);
    }
}
