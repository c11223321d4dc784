//! Techniques as methods: their frames as estimates of the light that they model.

use std::time::Duration;

use super::reference::Job;
use crate::approximation::Technique;
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::run::{Error, Estimate, Layer, LayerName, Light, Quantity, Rendering};
use crate::transport::ledger::Ledger;

/// Prepares a technique and makes one frame.
pub(super) fn run(technique: &dyn Technique, job: &Job) -> Result<Rendering, Error> {
    let (scene, sensor) = (job.scene, job.sensor);
    let light = technique.light(scene, job.values)?;
    let mut prepared = technique.prepare(scene, sensor, job.values, job.context)?;
    let frame = prepared.frame(scene, sensor, job.context)?;
    let seconds: f64 = frame.work.iter().map(|stage| stage.seconds).sum();
    let quantity = if sensor.is_camera() {
        Quantity::Radiance
    } else {
        Quantity::Irradiance
    };
    let layer = |name| {
        let mut layer = Layer::dark(name, frame.values.len());
        layer.values.clone_from(&frame.values);
        layer.standard_error.fill(Rgb::grey(f64::NAN));
        layer
    };
    let estimate = Estimate {
        quantity,
        width: sensor.film.crop.width as usize,
        height: sensor.film.crop.height as usize,
        total: layer(LayerName::Total),
        layers: vec![layer(name(light))],
        counts: vec![0; frame.values.len()],
        ledger: Ledger::default(),
        paths: frame.counters.get("photons"),
        counters: TraversalCounters {
            rays: frame.counters.get("rays"),
            ..TraversalCounters::default()
        },
        relative_error: None,
        incomplete: false,
    };
    // Seconds differ from run to run: they are apart.
    let work: Vec<_> = frame.work.iter().map(|one| (one.name, &one.work)).collect();
    Ok(Rendering {
        light,
        warnings: frame.warnings,
        unit: "photons",
        counters: frame.counters.list(),
        preparation: prepared.work().to_vec(),
        frame_time: Some(Duration::from_secs_f64(seconds)),
        ..Rendering::new(estimate).reporting("work", work)
    }
    .with_stages(frame.work))
}

/// The layer of the light that a technique models.
fn name(light: Light) -> LayerName {
    match light {
        Light::All => LayerName::Total,
        Light::Path(signature) => LayerName::Path(signature),
        Light::Specular { .. } => LayerName::Specular,
    }
}
