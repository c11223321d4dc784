//! The errors of an approximation's stages, from films of the store.

use super::super::StudyError;
use super::super::attribution::{fall_alone, relative_rmse};
use super::super::plan::StageRuns;
use super::super::session::Session;
use super::super::store::StoredRun;
use super::figures::{StageErrors, StageFigures};
use crate::film::{Image, exr};
use crate::metric::CompareImage;
use crate::radiometry::Rgb;

/// The films of an approximation's stages.
#[derive(Clone, Debug)]
pub struct StageFilms<'a> {
    /// The runs of these films.
    pub runs: &'a StageRuns,
    /// With all stages as they are set.
    pub all: StoredRun,
    /// With each stage exact, alone and with all before it, in the order of the pipeline.
    pub stages: Vec<[StoredRun; 2]>,
}

/// The figures; `None` if the truth has none of the light that is modelled.
pub(super) fn stage_errors(
    session: &Session,
    truth: &CompareImage,
    films: &StageFilms,
) -> Result<Option<StageErrors>, StudyError> {
    let layer = &films.all.facts.judged;
    let Some(modelled) = channels(&truth.image, layer) else {
        return Ok(None);
    };
    let error = |film: &StoredRun| -> Result<Option<f64>, StudyError> {
        let image = exr::read(&session.store.path(&film.exr))?;
        let values = channels(&image, layer);
        Ok(values.and_then(|values| relative_rmse(&values, &modelled)))
    };
    let Some(whole) = error(&films.all)? else {
        return Ok(None);
    };
    let mut stages = Vec::new();
    for (run, [alone, cumulative]) in films.runs.stages.iter().zip(&films.stages) {
        let (Some(alone), Some(cumulative)) = (error(alone)?, error(cumulative)?) else {
            return Ok(None);
        };
        stages.push(StageFigures {
            stage: run.stage.name,
            variant: run.stage.variant.clone(),
            exact: run.stage.exact,
            alone,
            cumulative,
        });
    }
    let residual = stages.last().map_or(whole, |stage| stage.cumulative);
    let alone = stages.iter().map(|stage| stage.alone);
    Ok(Some(StageErrors {
        name: films.runs.all.name.clone(),
        label: films.runs.all.label(),
        layer: layer.clone(),
        error: whole,
        interaction: whole - residual - fall_alone(whole, alone),
        residual,
        stages,
        not_modelled: not_modelled(truth, &modelled),
    }))
}

/// The part of the truth's light from mirrors and glass that is not modelled.
fn not_modelled(truth: &CompareImage, modelled: &[Rgb]) -> f64 {
    let total = |name: &str| channels(&truth.image, name).map_or(0.0, |values| sum(&values));
    let specular = total("E").max(total("L")) - total("LD");
    if specular > 0.0 {
        (1.0 - sum(modelled) / specular).max(0.0)
    } else {
        0.0
    }
}

fn sum(values: &[Rgb]) -> f64 {
    values.iter().map(|value| value.mean()).sum()
}

/// A layer's colours, texel by texel.
fn channels(image: &Image, layer: &str) -> Option<Vec<Rgb>> {
    let channel = |end: &str| image.channel(&format!("{layer}.{end}"));
    let (red, green, blue) = (channel("R")?, channel("G")?, channel("B")?);
    let colours = red.samples.iter().zip(&green.samples).zip(&blue.samples);
    Some(
        colours
            .map(|((r, g), b)| Rgb([*r, *g, *b].map(f64::from)))
            .collect(),
    )
}
