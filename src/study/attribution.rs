//! Which stage of an approximation makes its error.
//!
//! The approximation is run with all its stages as they are set, with each stage exact alone, and with one more stage exact
//! after the other, in the order of the pipeline. An error is the root mean square difference to the truth of the *modelled*
//! light, relative to that light's mean,
//!
//! ```text
//! e = √(Σ (aᵢ − tᵢ)² / n) / (Σ tᵢ / n)
//! ```
//!
//! with sums over all texels, n the number of texels that the truth lights, and channels averaged: the relative RMSE of
//! `metric`, but for light that lands where there should be none, which counts here. The falls of the error along the pipeline and what is left
//! at its end add up to the whole error, exactly. What the falls of single stages do not add up to is their interaction: errors that hide
//! or cancel each other. Light that the technique does not model at all is told apart from both.

use crate::approximation::{Approximation, ApproximationError, Rendering, SettingError, Work};
use crate::radiometry::Rgb;
use crate::reference::beams::{self, BeamBudget, BeamError, BeamSettings};
use crate::reference::{Estimate, LayerName, Progress};
use crate::scene::{Scene, Sensor};
use crate::transport::signature::Signature;

/// Why errors cannot be attributed.
#[derive(Debug, thiserror::Error)]
pub enum AttributionError {
    /// There is no truth.
    #[error("the truth: {0}")]
    Truth(#[from] BeamError),
    /// The approximation does not run.
    #[error(transparent)]
    Approximation(#[from] ApproximationError),
    /// Nothing is known of the truth.
    #[error(
        "the truth was stopped before its first pass was through: nothing is known of the light of path {0}, and no \
         error can be told; allow it more time, or a larger error"
    )]
    Unknown(Signature),
    /// No light to be relative to.
    #[error(
        "the truth has no light of path {0} on the sensor: an error relative to it is not defined"
    )]
    Dark(Signature),
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
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Outcome {
    /// Relative RMSE.
    pub error: f64,
    /// Its light by the truth's.
    pub energy_ratio: f64,
    /// What it took.
    pub work: Work,
    /// What it took \[s\].
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
    /// Relative RMSE of leaving that light out, by the mean of the modelled light; NaN where that is not known.
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

/// The truth of a scene by beams, for an approximation of one path signature.
///
/// Two runs: one of chains no longer than that signature, to the error that is asked for, and one of all chains, of which only
/// the sum of the other light is wanted, to ten times that error.
///
/// # Errors
///
/// As [`beams::run::Setup::new`] and its run.
pub fn truth_by_beams(
    scene: &Scene,
    sensor: &Sensor,
    signature: Signature,
    budget: &BeamBudget,
    progress: &Progress,
) -> Result<Truth, BeamError> {
    /// Errors of the light that is not modelled are figures of one or two digits.
    const ROUGHLY: f64 = 10.0;
    /// Signatures with a layer of their own: the modelled one is hardly ever the seventeenth brightest.
    const LAYERS: usize = 16;
    let short = BeamSettings {
        max_depth: signature.len() as u32,
        ..BeamSettings::default()
    };
    let (estimate, _) = beams::run(scene, sensor, short, budget, progress)?;
    let rough = BeamBudget {
        relative_error: budget.relative_error.map(|error| ROUGHLY * error),
        ..*budget
    };
    let long = BeamSettings {
        max_layers: LAYERS,
        ..BeamSettings::default()
    };
    let (all, _) = beams::run(scene, sensor, long, &rough, progress)?;
    let direct = LayerName::Path(Signature::DIRECT);
    let modelled = LayerName::Path(signature);
    let is_good_enough = match (budget.relative_error, estimate.relative_error) {
        (Some(asked), Some(error)) => error <= asked,
        _ => true,
    };
    Ok(Truth {
        modelled: sum_of(&estimate, |name| name == modelled),
        rest: sum_of(&all, |name| name != modelled && name != direct),
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
        for (sum, value) in sum.iter_mut().zip(&layer.irradiance) {
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

/// Runs an approximation with its stages as they are, each exact alone, and cumulatively. `truth` is asked once, for the light
/// that the approximation turns out to model.
///
/// # Errors
///
/// Where the approximation does not run, the truth cannot be had, is not known, or is dark.
pub fn attribute<A: Approximation>(
    approximation: &A,
    scene: &Scene,
    sensor: &Sensor,
    truth: impl FnOnce(Signature) -> Result<Truth, BeamError>,
) -> Result<Attribution, AttributionError> {
    let whole = approximation.run(scene, sensor)?;
    let signature = whole.signature;
    let truth = truth(signature)?;
    if !truth.modelled.iter().all(|value| value.is_finite()) {
        return Err(AttributionError::Unknown(signature));
    }
    let judged = |rendering: &Rendering| {
        let error = relative_rmse(&rendering.values, &truth.modelled)
            .ok_or(AttributionError::Dark(signature))?;
        Ok::<_, AttributionError>(Outcome {
            error,
            energy_ratio: total(&rendering.values) / total(&truth.modelled),
            work: rendering.total_work(),
            seconds: rendering.seconds(),
        })
    };
    let all = judged(&whole)?;
    let mut stages = Vec::new();
    let mut cumulative = approximation.clone();
    for stage in approximation.stages() {
        let alone = approximation.with_exact(stage.name)?;
        cumulative = cumulative.with_exact(stage.name)?;
        stages.push(StageError {
            name: stage.name,
            alone: judged(&alone.run(scene, sensor)?)?,
            cumulative: judged(&cumulative.run(scene, sensor)?)?,
            variant: stage.variant,
        });
    }
    let (rest, modelled) = (total(&truth.rest), total(&truth.modelled));
    let lit = truth.modelled.iter().filter(|value| value.mean() > 0.0);
    let lit = lit.count() as f64;
    let squares: f64 = truth.rest.iter().map(|value| value.mean().powi(2)).sum();
    Ok(Attribution {
        approximation: approximation.name(),
        signature: signature.to_string(),
        all,
        stages,
        not_modelled: rest / (rest + modelled),
        not_modelled_error: (squares / lit).sqrt() / (modelled / lit),
        truth_error: truth.relative_error,
        is_resolved: truth.is_resolved,
    })
}
