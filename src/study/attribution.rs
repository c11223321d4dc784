//! Which stage of an approximation makes its error.
//!
//! The approximation is run with all its stages as they are set, with each stage exact alone, and with one
//! more stage exact after the other, in the order of the pipeline. An error is the root mean square
//! difference to the truth of the *modelled* light, relative to that light's mean,
//!
//! ```text
//! e = √(Σ (aᵢ − tᵢ)² / n) / (Σ tᵢ / n)
//! ```
//!
//! with sums over all texels, n the number of texels that the truth lights, and channels averaged: the
//! relative RMSE of `metric`, but for light that lands where there should be none, which counts here. The
//! falls of the error along the pipeline and what is left at its end add up to the whole error, exactly. What
//! the falls of single stages do not add up to is their interaction: errors that hide or cancel each other.
//! Light that the technique does not model at all is told apart from both.

use std::collections::BTreeMap;

use crate::method::Method;
use crate::radiometry::Rgb;
use crate::run::{Budget, Context, Error, Estimate, LayerName, Light, Rendering};
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;
use crate::transport::signature::Signature;

/// An error that ends an attribution.
#[derive(Debug, thiserror::Error)]
pub enum AttributionError {
    /// There is no truth.
    #[error("the truth: {0}")]
    Truth(Error),
    /// The approximation does not run.
    #[error(transparent)]
    Approximation(#[from] Error),
    /// The method is no technique.
    #[error("{0} has no stages: errors of approximations are attributed, as of {1}")]
    NoStages(&'static str, String),
    /// Nothing is known of the truth.
    #[error(
        "the truth was stopped before its first pass was through: nothing is known of the light of path {0}, and no \
         error can be told; allow it more time, or a larger error"
    )]
    Unknown(String),
    /// No light to be relative to.
    #[error(
        "the truth has no light of path {0} on the sensor: an error relative to it is not defined"
    )]
    Dark(String),
}

impl From<SettingError> for AttributionError {
    fn from(error: SettingError) -> Self {
        Self::Approximation(error.into())
    }
}

/// The truth that an approximation is held against.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The light that the approximation models, texel by texel.
    pub modelled: Vec<Rgb>,
    /// All other light by way of mirrors and glass.
    pub rest: Vec<Rgb>,
    /// The likely error of all of it, relative.
    pub relative_error: Option<f64>,
    /// Whether that is what was asked for: not where time or rays ran out, or somebody stopped it.
    pub is_resolved: bool,
}

/// An approximation held against the truth.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Outcome {
    /// Relative RMSE.
    pub error: f64,
    /// Its light by the truth's.
    pub energy_ratio: f64,
    /// Work of a frame, counted.
    pub work: BTreeMap<String, u64>,
    /// Time of a frame \[s\].
    pub seconds: f64,
}

/// One stage.
#[derive(Clone, Debug, serde::Serialize)]
pub struct StageError {
    /// Its name.
    pub name: &'static str,
    /// The variant that was judged.
    pub variant: String,
    /// With this stage exact, all others as they are set.
    pub alone: Outcome,
    /// With this stage and all before it exact.
    pub cumulative: Outcome,
}

/// Where an approximation's error comes from.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Attribution {
    /// The technique.
    pub approximation: &'static str,
    /// The light that it models.
    pub signature: String,
    /// All stages as they are set.
    pub all: Outcome,
    /// In the order of the pipeline.
    pub stages: Vec<StageError>,
    /// The light that it does not model, by all light from mirrors and glass; NaN where that is not known.
    pub not_modelled: f64,
    /// Relative RMSE of leaving that light out, by the mean of the modelled light; NaN where that is not
    /// known.
    pub not_modelled_error: f64,
    /// The truth's own likely error, relative.
    pub truth_error: Option<f64>,
    /// Whether the truth is as good as was asked for. Where it is not, figures below its error say nothing.
    pub is_resolved: bool,
}

impl Attribution {
    /// The error that is left with all stages exact: of sampling, and of the truth.
    pub fn residual(&self) -> f64 {
        self.stages
            .last()
            .map_or(self.all.error, |stage| stage.cumulative.error)
    }

    /// How far the error falls as a stage becomes exact after those before it; below zero where it rises.
    pub fn falls(&self) -> Vec<f64> {
        let mut before = self.all.error;
        let fall = |stage: &StageError| {
            let fall = before - stage.cumulative.error;
            before = stage.cumulative.error;
            fall
        };
        self.stages.iter().map(fall).collect()
    }

    /// What the falls of single stages do not add up to: the error less the residual less all falls alone.
    pub fn interaction(&self) -> f64 {
        let alone = self.stages.iter().map(|stage| stage.alone.error);
        self.all.error - self.residual() - fall_alone(self.all.error, alone)
    }
}

/// By how much an error falls with each stage exact alone, all falls added.
pub fn fall_alone(error: f64, alone: impl Iterator<Item = f64>) -> f64 {
    alone.map(|alone| error - alone).sum()
}

/// The truth of a scene by beams, for an approximation of some of its light.
///
/// Two runs: one of chains no longer than that light's, to the error that is asked for, and one of all
/// chains, of which only the sum of the other light is wanted, to ten times that error.
///
/// # Errors
///
/// As [`Method::run`].
pub fn truth_by_beams(
    scene: &Scene,
    sensor: &Sensor,
    light: Light,
    budget: &Budget,
    context: &Context,
) -> Result<Truth, Error> {
    /// Errors of the light that is not modelled are figures of one or two digits.
    const ROUGHLY: f64 = 10.0;
    /// Signatures with a layer of their own: the modelled one is hardly ever the seventeenth brightest.
    const LAYERS: &str = "16";
    let beams =
        |key: &str, value: String| Method::new("beams", &BTreeMap::from([(key.to_owned(), value)]));
    let depth = light.max_depth().map(|depth| depth.to_string());
    let short = match depth {
        Some(depth) => beams("max-depth", depth)?,
        None => Method::new("beams", &BTreeMap::new())?,
    };
    let estimate = short.run(scene, sensor, budget, context)?.estimate;
    let rough = Budget {
        relative_error: budget.relative_error.map(|error| ROUGHLY * error),
        ..*budget
    };
    let long = beams("layers", LAYERS.to_owned())?;
    let all = long.run(scene, sensor, &rough, context)?.estimate;
    let is_modelled = |name: LayerName| match (light, name) {
        (Light::Specular { .. }, LayerName::Other) => true,
        (light, LayerName::Path(signature)) => light.includes(signature),
        _ => false,
    };
    let direct = LayerName::Path(Signature::DIRECT);
    let is_good_enough = match (budget.relative_error, estimate.relative_error) {
        (Some(asked), Some(error)) => error <= asked,
        _ => true,
    };
    // Of chains of any length, those beyond the modelled depth are among `other` or have a layer.
    let is_rest = |name| name != direct && !is_modelled(name);
    Ok(Truth {
        modelled: sum_of(&estimate, is_modelled),
        rest: sum_of(&all, is_rest),
        relative_error: estimate.relative_error,
        is_resolved: is_good_enough && !estimate.incomplete,
    })
}

/// Some layers of an estimate, added up, texel by texel; NaN where the estimate knows nothing.
fn sum_of(estimate: &Estimate, is_chosen: impl Fn(LayerName) -> bool) -> Vec<Rgb> {
    let start = if estimate.total.is_unknown() {
        Rgb::grey(f64::NAN)
    } else {
        Rgb::BLACK
    };
    let mut sum = vec![start; estimate.width * estimate.height];
    for layer in estimate.layers.iter().filter(|layer| is_chosen(layer.name)) {
        for (sum, value) in sum.iter_mut().zip(&layer.values) {
            *sum += *value;
        }
    }
    sum
}

/// Relative RMSE of values against the truth, as this module defines it; `None` where the truth is dark.
pub fn relative_rmse(values: &[Rgb], truth: &[Rgb]) -> Option<f64> {
    let (mut squares, mut sum, mut lit) = (0.0, 0.0, 0_u64);
    for (value, truth) in values.iter().zip(truth) {
        squares += (value.mean() - truth.mean()).powi(2);
        sum += truth.mean();
        lit += u64::from(truth.mean() > 0.0);
    }
    let lit = lit as f64;
    (sum > 0.0).then(|| (squares / lit).sqrt() / (sum / lit))
}

fn total(values: &[Rgb]) -> f64 {
    values.iter().map(|value| value.mean()).sum()
}

/// Runs a technique with its stages as they are, each exact alone, and cumulatively. `truth` is asked once,
/// for the light that the technique models.
///
/// # Errors
///
/// If the method has no stages or does not run, or the truth cannot be had, is not known, or is dark.
pub fn attribute(
    technique: &Method,
    scene: &Scene,
    sensor: &Sensor,
    context: &Context,
    truth: impl FnOnce(Light) -> Result<Truth, Error>,
) -> Result<Attribution, AttributionError> {
    if technique.stages().is_empty() {
        let names = Method::names().into_iter();
        let staged = names.filter(|name| {
            Method::new(name, &BTreeMap::new()).is_ok_and(|one| !one.stages().is_empty())
        });
        let staged: Vec<&str> = staged.collect();
        return Err(AttributionError::NoStages(
            technique.name(),
            staged.join(", "),
        ));
    }
    let run = |method: &Method| method.run(scene, sensor, &Budget::default(), context);
    let whole = run(technique)?;
    let light = whole.light;
    let layers = &whole.estimate.layers;
    let signature = layers
        .first()
        .map_or_else(String::new, |layer| layer.name.to_string());
    let truth = truth(light).map_err(AttributionError::Truth)?;
    if !truth.modelled.iter().all(|value| value.is_finite()) {
        return Err(AttributionError::Unknown(signature));
    }
    let judged = |rendering: &Rendering| {
        let values = &rendering.estimate.total.values;
        let error = relative_rmse(values, &truth.modelled)
            .ok_or_else(|| AttributionError::Dark(signature.clone()))?;
        Ok::<_, AttributionError>(Outcome {
            error,
            energy_ratio: total(values) / total(&truth.modelled),
            work: rendering
                .counters
                .iter()
                .map(|one| (one.name.clone(), one.count))
                .collect(),
            seconds: rendering.frame_time.unwrap_or_default().as_secs_f64(),
        })
    };
    let all = judged(&whole)?;
    let mut stages = Vec::new();
    let mut cumulative = technique.clone();
    for stage in technique.stages() {
        let alone = technique.with_exact(stage.name)?;
        cumulative = cumulative.with_exact(stage.name)?;
        stages.push(StageError {
            name: stage.name,
            alone: judged(&run(&alone)?)?,
            cumulative: judged(&run(&cumulative)?)?,
            variant: stage.variant,
        });
    }
    let (rest, modelled) = (total(&truth.rest), total(&truth.modelled));
    let lit = truth.modelled.iter().filter(|value| value.mean() > 0.0);
    let lit = lit.count() as f64;
    let squares: f64 = truth.rest.iter().map(|value| value.mean().powi(2)).sum();
    Ok(Attribution {
        approximation: technique.name(),
        signature,
        all,
        stages,
        not_modelled: rest / (rest + modelled),
        not_modelled_error: (squares / lit).sqrt() / (modelled / lit),
        truth_error: truth.relative_error,
        is_resolved: truth.is_resolved,
    })
}
