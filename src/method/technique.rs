//! Techniques as methods: their frames as estimates of the light that they model.

use std::time::Duration;

use super::reference::Job;
use crate::approximation::{Prepared, Technique};
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::run::format::number;
use crate::run::{Error, Estimate, FluxEntry, Layer, LayerName, Light, Quantity, Rendering};
use crate::transport::ledger::Ledger;

/// Makes one frame. It uses what is left of the frames before it, if there is any, and leaves its own.
pub(super) fn run(
    technique: &dyn Technique,
    job: &Job,
    left: &mut Option<Box<dyn Prepared>>,
) -> Result<Rendering, Error> {
    let (scene, sensor) = (job.scene, job.sensor);
    let light = technique.light(scene, job.values)?;
    // Whatever fails leaves nothing.
    let kept = left.take();
    let is_first = kept.is_none();
    let mut prepared = match kept {
        Some(kept) => {
            technique.supports(scene, sensor, job.values)?;
            kept
        }
        None => technique.prepare(scene, sensor, job.values, job.context)?,
    };
    let mut frame = prepared.frame(scene, sensor, job.context)?;
    // The preparation is work of the first frame.
    let preparation = if is_first {
        prepared.work().to_vec()
    } else {
        Vec::new()
    };
    if technique.keeps_frames(job.values) {
        *left = Some(prepared);
    }
    let seconds: f64 = frame.work.iter().map(|stage| stage.seconds).sum();
    let quantity = if sensor.is_camera() {
        Quantity::Radiance
    } else {
        Quantity::Irradiance
    };
    let values = std::mem::take(&mut frame.values);
    let texels = values.len();
    let layer = |name, values| Layer {
        name,
        values,
        standard_error: vec![Rgb::grey(f64::NAN); texels],
        interval: None,
        sampling: None,
    };
    let estimate = Estimate {
        quantity,
        width: sensor.film.crop.width as usize,
        height: sensor.film.crop.height as usize,
        total: layer(LayerName::Total, values.clone()),
        layers: vec![layer(name(light), values)],
        counts: vec![0; texels],
        ledger: Ledger::default(),
        paths: frame.counters.get(technique.unit()),
        counters: TraversalCounters {
            rays: frame.counters.get("rays"),
            ..TraversalCounters::default()
        },
        relative_error: None,
        // Whoever stops a run has what there was then, if the technique ends early.
        incomplete: job.context.progress.is_stopped(),
    };
    // Seconds differ from run to run: they are apart.
    let work: Vec<_> = frame.work.iter().map(|one| (one.name, &one.work)).collect();
    Ok(Rendering {
        light,
        summary: summary(&frame.flux, technique.unit()),
        warnings: frame.warnings,
        unit: technique.unit(),
        counters: frame.counters.list(),
        preparation,
        frame_time: Some(Duration::from_secs_f64(seconds)),
        ..Rendering::new(estimate).reporting("work", work)
    }
    .with_flux(frame.flux)
    .with_stages(frame.work))
}

/// The flux of a frame as a table: what sets out, what each stage does to it, and what is left.
fn summary(flux: &[FluxEntry], unit: &str) -> Vec<String> {
    if flux.is_empty() {
        return Vec::new();
    }
    let row = |stage: &str, watts: f64, reason: &str, photons: u64| {
        let photons = match photons {
            0 => String::new(),
            photons => format!(" ({photons} {unit})"),
        };
        format!("  {stage:<11}{:>12}  {reason}{photons}", number(watts))
    };
    let mut lines = vec!["flux by stage [W], mean of channels".to_owned()];
    lines.extend(
        flux.iter()
            .map(|one| row(one.stage, one.flux.mean(), one.reason, one.photons)),
    );
    let left: Rgb = flux.iter().map(|one| one.flux).sum();
    lines.push(row(
        "left",
        left.mean(),
        "on the sensor, or before a camera",
        0,
    ));
    lines
}

/// The layer of the light that a technique models.
fn name(light: Light) -> LayerName {
    match light {
        Light::All => LayerName::Total,
        Light::Path(signature) => LayerName::Path(signature),
        Light::Specular { .. } => LayerName::Specular,
    }
}
