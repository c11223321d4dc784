//! Which stage of an approximation makes its error.
//!
//! Each stage has an exact twin. The approximation is run with all subsets of its stages exact, and each
//! run's figures are taken against the truth of the *modelled* light. From these come, for each figure and
//! stage:
//!
//! - its **share**, by Shapley's value ([`shapley`]): shares and the residual add up to the figure. A share
//!   has a sign: a stage that hides another's error has a negative one.
//! - the figure with this stage alone exact (fix one), and with all others exact (spoil one);
//! - the figure with this stage and all before it exact, in the order of the pipeline.
//!
//! The residual is the figure with all stages exact: of sampling, and of the truth. Light that the technique
//! does not model at all is told apart. The runs are made on a sensor of fewer texels ([`reduced`]).
//! Exact twins that sample, or halve cells, until the image is known do no more than the figures need
//! ([`TWINS`]).

pub mod film;
pub mod reduced;
mod runs;
pub mod shapley;
pub mod truth;
mod twins;
pub mod wanted;

use serde::{Deserialize, Serialize};

use crate::method::Method;
use crate::metric::{CompareError, Figure};
use crate::run::{Context, Error, Light};
use crate::scene::{Scene, Sensor};
use crate::setting::{SettingError, Words as _};
pub use reduced::ReducedSensor;
pub use runs::{Beginning, KnownFigures, StageRuns, count, parts};
use shapley::Share;
pub use truth::{Truth, truth_by, truth_by_beams};
pub use twins::TWINS;

/// The least number of texels on the longer side of the sensor on which runs are made.
pub const SIDE: usize = 128;

/// An error that ends an attribution.
#[derive(Debug, thiserror::Error)]
pub enum AttributionError {
    /// There is no truth.
    #[error("the truth: {0}")]
    Truth(Error),
    /// The approximation does not run.
    #[error(transparent)]
    Approximation(#[from] Error),
    /// Its film cannot be compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
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

/// The error of an approximation, stage by stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attribution {
    /// The technique.
    pub approximation: String,
    /// The light that it models, by which it is judged.
    pub light: String,
    /// Texels a row and rows of the sensor on which runs were made.
    pub size: [usize; 2],
    /// Number of runs.
    pub runs: usize,
    /// In the order of the pipeline.
    pub stages: Vec<AttributedStage>,
    /// One entry a figure that is defined for all runs, the headline first.
    pub figures: Vec<FigureShares>,
    /// The part of the light from mirrors and glass that is not modelled at all; NaN if it is not known.
    #[serde(with = "unknown")]
    pub not_modelled: f64,
    /// The truth's own likely error, relative.
    pub truth_error: Option<f64>,
    /// True if the truth is as good as was asked for. If not, figures below its error say nothing.
    pub is_resolved: bool,
    /// The noise in runs with exact twins that sample or halve cells, a relative standard error over the
    /// sensor; `None` if no twin of the technique does.
    #[serde(default)]
    pub twin_error: Option<f64>,
}

/// A stage as it was judged.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AttributedStage {
    /// Its name.
    pub name: String,
    /// The variant that is set.
    pub variant: String,
    /// Its twin without error.
    pub exact: String,
}

/// A figure, shared out among the stages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FigureShares {
    /// The figure's name.
    pub figure: String,
    /// The figure with all stages as they are set.
    pub whole: f64,
    /// The figure with all stages exact: of sampling, and of the truth.
    pub residual: f64,
    /// In the order of the pipeline.
    pub stages: Vec<StageShare>,
}

/// The effect of one stage on a figure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageShare {
    /// What the stage adds to the figure.
    #[serde(flatten)]
    pub share: Share,
    /// The figure with this stage exact, all others as they are set.
    pub fixed: f64,
    /// The figure with this stage as it is set, all others exact.
    pub spoiled: f64,
    /// The figure with this stage and all before it exact.
    pub cumulative: f64,
}

impl Attribution {
    /// The shares in a figure; `None` if it is not defined for all runs.
    pub fn of(&self, figure: Figure) -> Option<&FigureShares> {
        self.figures.iter().find(|one| one.figure == figure.word())
    }
}

/// NaN as `null`.
mod unknown {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    // The signature is serde's.
    #[allow(clippy::trivially_copy_pass_by_ref)]
    pub(super) fn serialize<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
        (!value.is_nan()).then_some(*value).serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
    }
}

/// A listener that hears how many runs are done, of how many.
pub type RunProgress<'a> = &'a mut dyn FnMut(usize, usize);

/// Attributes the error of a technique on a sensor. `truth` is asked once, for the light that the technique
/// models. `None` if it was stopped.
///
/// # Errors
///
/// If the method has no stages or does not run, or the truth cannot be had, is not known, or is dark.
pub fn attribute(
    technique: &Method,
    scene: &Scene,
    sensor: &Sensor,
    context: &Context,
    progressing: RunProgress,
    truth: impl FnOnce(Light) -> Result<Truth, Error>,
) -> Result<Option<Attribution>, AttributionError> {
    let runs = StageRuns::new(technique, scene, sensor, context)?;
    let Some((beginning, truth)) = runs.begin(truth)? else {
        return Ok(None);
    };
    let (known, missing) = (KnownFigures::new(), 0..runs.parts());
    runs.complete(
        beginning,
        known,
        missing,
        progressing,
        |beginning, number, heard| runs.others(beginning, &truth, number, heard),
    )
}
