//! The approximations as methods of a study.

use serde_json::Value;

use super::keys::Settings;
use super::product::{Counter, Product};
use crate::approximation::{Approximation, ApproximationError, SettingError};
use crate::reference::Quantity;
use crate::scene::{Scene, Sensor, SensorKind};

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
    let is_meter = matches!(sensor.kind, SensorKind::IrradianceMeter { .. });
    let quantity = if is_meter {
        Quantity::Irradiance
    } else {
        Quantity::Radiance
    };
    let work = rendering.total_work();
    let photons = rendering.work.first().map_or(0, |stage| stage.work.photons);
    let counters = [
        ("rays", work.rays),
        ("march steps", work.steps),
        ("splats", work.splats),
        ("fragments", work.fragments),
        ("texture fetches", work.fetches),
        ("bytes", work.bytes),
        ("photons", photons),
    ];
    let counters = counters.map(|(name, count)| Counter {
        name: name.to_owned(),
        count,
    });
    let size = [rendering.width, rendering.height];
    let layer = rendering.signature.to_string();
    Ok(Product {
        seconds: Some(rendering.seconds()),
        ..Product::of_layer(size, quantity, &layer, &rendering.values, counters.to_vec())
    })
}
