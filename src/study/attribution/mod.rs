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
pub mod shapley;
pub mod truth;
mod twins;
pub mod wanted;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::film::Image;
use crate::method::Method;
use crate::metric::{CompareError, CompareImage, Figure, fidelity};
use crate::radiometry::Rgb;
use crate::run::{Budget, Context, Error, texels};
use crate::scene::{Scene, Sensor};
use crate::setting::{SettingError, Words as _};
pub use reduced::ReducedSensor;
use shapley::{Set, Share};
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
    truth: impl FnOnce(crate::run::Light) -> Result<Truth, Error>,
) -> Result<Option<Attribution>, AttributionError> {
    let stages = technique.stages();
    if stages.is_empty() {
        return Err(no_stages(technique));
    }
    // Stages that are exact as they are set have no error to share.
    let causes: Vec<usize> = (0..stages.len())
        .filter(|i| !stages[*i].is_exact())
        .collect();
    let sets = sets(causes.len());
    let run = |technique: &Method, set: Set| -> Result<_, AttributionError> {
        let mut method = technique.clone();
        for (bit, cause) in causes.iter().enumerate() {
            if set & (1 << bit) == 0 {
                method = method.with_exact(stages[*cause].name)?;
            }
        }
        Ok(method.run(scene, sensor, &Budget::default(), context)?)
    };
    let all: Set = (1 << causes.len()) - 1;
    let whole = run(technique, all)?;
    let layers = &whole.estimate.layers;
    let light = layers
        .first()
        .map_or_else(String::new, |layer| layer.name.to_string());
    let truth = truth(whole.light).map_err(AttributionError::Truth)?;
    if context.progress.is_stopped() {
        return Ok(None);
    }
    if !truth.modelled.iter().all(|value| value.is_finite()) {
        return Err(AttributionError::Unknown(light));
    }
    if truth.modelled.iter().all(|value| value.mean() <= 0.0) {
        return Err(AttributionError::Dark(light));
    }
    let size = sensor.size();
    let image = |name: &str, values: &[Rgb]| {
        let mut image = Image::new(size[0], size[1]);
        let triples: Vec<[f64; 3]> = values.iter().map(|value| value.0).collect();
        image.add_rgb("E", &triples);
        texels::describe(&mut image, scene, sensor);
        CompareImage::new(name, image)
    };
    let reference = image("the truth", &truth.modelled);
    let compared = |values: &[Rgb]| fidelity::of(&reference, &image("the approximation", values));
    let of_whole = compared(&whole.estimate.total.values)?;
    let twins = twins::known_to::<AttributionError>(
        TWINS * of_whole.l2.as_ref().map_or(f64::NAN, |l2| l2.value),
        technique,
        |technique| Ok(run(technique, 0)?.estimate.total.values),
        |finer, coarser| {
            let found = fidelity::of(&image("more halvings", finer), &image("fewer", coarser))?;
            Ok(found.l2.map_or(0.0, |l2| l2.value))
        },
    )?;
    let technique = twins.technique;
    let mut known: BTreeMap<Set, Vec<Option<f64>>> = BTreeMap::new();
    for (done, set) in sets.iter().copied().enumerate() {
        let other = (set != all).then(|| run(&technique, set)).transpose()?;
        if context.progress.is_stopped() {
            return Ok(None);
        }
        let found = match other {
            Some(other) => compared(&other.estimate.total.values)?,
            None => of_whole.clone(),
        };
        let figures = Figure::OF_LIGHT.map(|figure| Some(figure.of_light(&found)?.value));
        known.insert(set, figures.to_vec());
        progressing(done + 1, sets.len());
    }
    let figures = Figure::OF_LIGHT.iter().enumerate();
    let figures = figures.filter_map(|(i, figure)| {
        let of = |set: Set| *known.get(&set)?.get(i)?;
        figure_shares(*figure, &causes, stages.len(), of)
    });
    Ok(Some(Attribution {
        approximation: technique.name().to_owned(),
        light,
        size,
        runs: sets.len(),
        figures: figures.collect(),
        stages: stages
            .iter()
            .map(|stage| AttributedStage {
                name: stage.name.to_owned(),
                variant: stage.variant.clone(),
                exact: stage.exact.to_owned(),
            })
            .collect(),
        not_modelled: truth.not_modelled,
        truth_error: truth.relative_error,
        is_resolved: truth.is_resolved,
        twin_error: twins.error,
    }))
}

/// All sets of approximate stages that are run, each once.
fn sets(causes: usize) -> Vec<Set> {
    let all: Set = (1 << causes) - 1;
    let mut sets = shapley::sets(causes);
    for cause in 0..causes {
        // Fixed alone, spoiled alone, and with all before it exact.
        sets.extend([all & !(1 << cause), 1 << cause, all & !((2 << cause) - 1)]);
    }
    sets.sort_by_key(|set| (set.count_ones(), *set));
    sets.dedup();
    sets
}

/// The number of runs of an attribution.
pub fn count(technique: &Method) -> usize {
    let stages = technique.stages();
    sets(stages.iter().filter(|stage| !stage.is_exact()).count()).len()
}

fn figure_shares(
    figure: Figure,
    causes: &[usize],
    stages: usize,
    of: impl Fn(Set) -> Option<f64>,
) -> Option<FigureShares> {
    let all: Set = (1 << causes.len()) - 1;
    let shares = shapley::shares(causes.len(), &of)?;
    let (whole, residual) = (of(all)?, of(0)?);
    let mut found = Vec::new();
    let mut exact: Set = 0;
    for stage in 0..stages {
        found.push(match causes.iter().position(|cause| *cause == stage) {
            Some(bit) => {
                exact |= 1 << bit;
                StageShare {
                    share: shares[bit],
                    fixed: of(all & !(1 << bit))?,
                    spoiled: of(1 << bit)?,
                    cumulative: of(all & !exact)?,
                }
            }
            None => StageShare {
                share: Share {
                    value: 0.0,
                    standard_error: 0.0,
                },
                fixed: whole,
                spoiled: residual,
                cumulative: of(all & !exact)?,
            },
        });
    }
    Some(FigureShares {
        figure: figure.word().to_owned(),
        whole,
        residual,
        stages: found,
    })
}

fn no_stages(method: &Method) -> AttributionError {
    let names = Method::names().into_iter();
    let staged = names.filter(|name| {
        Method::new(name, &BTreeMap::new()).is_ok_and(|one| !one.stages().is_empty())
    });
    let staged: Vec<&str> = staged.collect();
    AttributionError::NoStages(method.name(), staged.join(", "))
}
