//! The approximations as methods of a study.

use serde_json::Value;

use super::keys::Settings;
use super::product::{Counter, Facts, Product, Spread};
use crate::approximation::{Approximation, ApproximationError, Rendering, SettingError};
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::reference::{Estimate, Layer, LayerName, Quantity};
use crate::scene::{Scene, Sensor, SensorKind};
use crate::transport::ledger::Ledger;

/// An approximation with these settings; those not given are its defaults.
pub(super) fn with<A: Approximation + Default>(given: &Settings) -> Result<A, SettingError> {
    let mut made = A::default();
    for (key, value) in given {
        made.set(key, value)?;
    }
    Ok(made)
}

/// All its settings.
pub(super) fn settings<A: Approximation>(approximation: &A) -> Value {
    let pairs = approximation.settings().into_iter();
    pairs
        .map(|(key, value)| (key.to_owned(), Value::String(value)))
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// Fills a sensor. It is judged by the only light that it models.
pub(super) fn run<A: Approximation>(
    approximation: &A,
    scene: &Scene,
    sensor: &Sensor,
) -> Result<Product, ApproximationError> {
    let rendering = approximation.run(scene, sensor)?;
    let estimate = as_estimate(&rendering, sensor);
    let work = rendering.total_work();
    let counters = [
        ("rays", work.rays),
        ("march steps", work.steps),
        ("splats", work.splats),
        ("fragments", work.fragments),
        ("texture fetches", work.fetches),
        ("bytes", work.bytes),
        ("photons", estimate.paths),
    ];
    Ok(Product {
        image: estimate.channels(),
        quantity: estimate.quantity,
        facts: Facts {
            judged: rendering.signature.to_string(),
            replicates: None,
            counters: counters
                .map(|(name, count)| Counter {
                    name: name.to_owned(),
                    count,
                })
                .to_vec(),
            own_error: None,
            spread: Spread::default(),
            ledger: None,
            complete: true,
            warnings: Vec::new(),
        },
    })
}

/// An approximation's image as references deliver theirs: one layer, of whose error nothing is known.
pub fn as_estimate(rendering: &Rendering, sensor: &Sensor) -> Estimate {
    let layer = |name| {
        let mut layer = Layer::dark(name, rendering.values.len());
        layer.irradiance.clone_from(&rendering.values);
        layer.standard_error.fill(Rgb::grey(f64::NAN));
        layer
    };
    let is_meter = matches!(sensor.kind, SensorKind::IrradianceMeter { .. });
    let first = rendering.work.first();
    Estimate {
        quantity: if is_meter {
            Quantity::Irradiance
        } else {
            Quantity::Radiance
        },
        width: rendering.width,
        height: rendering.height,
        total: layer(LayerName::Total),
        layers: vec![layer(LayerName::Path(rendering.signature))],
        counts: vec![0; rendering.values.len()],
        ledger: Ledger::default(),
        paths: first.map_or(0, |stage| stage.work.photons),
        counters: TraversalCounters {
            rays: rendering.total_work().rays,
            ..TraversalCounters::default()
        },
        relative_error: None,
        incomplete: false,
    }
}
