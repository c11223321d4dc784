//! The runs of an attribution, so that they can be made in parts, on any machine.
//!
//! The first one has all stages as they are set. From it follows what light is judged, and how well exact
//! twins must be known ([`Beginning`]). All others need nothing else, and the figures of all make the
//! attribution.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::shapley::{self, Set, Share};
use super::{
    AttributedStage, Attribution, AttributionError, FigureShares, RunProgress, StageShare, TWINS,
    Truth, twins,
};
use crate::film::Image;
use crate::method::{Method, StageSetting};
use crate::metric::{CompareError, CompareImage, Fidelity, Figure, fidelity};
use crate::radiometry::Rgb;
use crate::run::{Budget, Context, Error, Light, Rendering, texels};
use crate::scene::{Scene, Sensor};
use crate::setting::{Given, Words as _};

/// Number of runs that are made together: much more work than to begin them.
const TOGETHER: usize = 4;

/// The figures of a run, in the order of [`Figure::OF_LIGHT`]; `None` if one is not defined.
pub type RunFigures = Vec<Option<f64>>;

/// The figures of runs, by the stages that are not exact.
pub type KnownFigures = BTreeMap<Set, RunFigures>;

/// What is known of an attribution after its first run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Beginning {
    /// The light that the technique models.
    pub light: Light,
    /// The name of its layer.
    layer: String,
    /// The technique's settings, with twins no better known than the figures need.
    settings: Given,
    /// See [`Attribution::twin_error`].
    twin_error: Option<f64>,
    /// The figures with all stages as they are set.
    whole: RunFigures,
    /// See [`Attribution::not_modelled`].
    #[serde(with = "super::unknown")]
    not_modelled: f64,
    /// See [`Attribution::truth_error`].
    truth_error: Option<f64>,
    /// See [`Attribution::is_resolved`].
    is_resolved: bool,
}

/// A technique that is run on a sensor with all subsets of its stages exact.
pub struct StageRuns<'a> {
    technique: &'a Method,
    scene: &'a Scene,
    sensor: &'a Sensor,
    context: &'a Context,
    stages: Vec<StageSetting>,
    /// The stages that have an error to share: those that are not exact as they are set.
    causes: Vec<usize>,
}

impl<'a> StageRuns<'a> {
    /// Runs of a technique on a sensor.
    ///
    /// # Errors
    ///
    /// If the method has no stages.
    pub fn new(
        technique: &'a Method,
        scene: &'a Scene,
        sensor: &'a Sensor,
        context: &'a Context,
    ) -> Result<Self, AttributionError> {
        let stages = technique.stages();
        if stages.is_empty() {
            return Err(no_stages(technique));
        }
        let causes = causes(&stages);
        Ok(Self {
            technique,
            scene,
            sensor,
            context,
            stages,
            causes,
        })
    }

    /// Makes the first run, and has the truth of its light, which is returned. `None` if it was stopped.
    ///
    /// # Errors
    ///
    /// If the technique does not run, or the truth cannot be had, is not known, or is dark.
    pub fn begin(
        &self,
        truth: impl FnOnce(Light) -> Result<Truth, Error>,
    ) -> Result<Option<(Beginning, Vec<Rgb>)>, AttributionError> {
        let whole = self.run(self.technique, self.all())?;
        let layers = &whole.estimate.layers;
        let layer = layers
            .first()
            .map_or_else(String::new, |layer| layer.name.to_string());
        let truth = truth(whole.light).map_err(AttributionError::Truth)?;
        if self.is_stopped() {
            return Ok(None);
        }
        if !truth.modelled.iter().all(|value| value.is_finite()) {
            return Err(AttributionError::Unknown(layer));
        }
        if truth.modelled.iter().all(|value| value.mean() <= 0.0) {
            return Err(AttributionError::Dark(layer));
        }
        let reference = self.image("the truth", &truth.modelled);
        let of_whole = self.compared(&reference, &whole)?;
        let twins = twins::known_to::<AttributionError>(
            TWINS * of_whole.l2.as_ref().map_or(f64::NAN, |l2| l2.value),
            self.technique,
            |technique| Ok(self.run(technique, 0)?.estimate.total.values),
            |finer, coarser| {
                let finer = self.image("more halvings", finer);
                let found = fidelity::of(&finer, &self.image("fewer", coarser))?;
                Ok(found.l2.map_or(0.0, |l2| l2.value))
            },
        )?;
        if self.is_stopped() {
            return Ok(None);
        }
        let beginning = Beginning {
            light: whole.light,
            layer,
            settings: twins.technique.given().clone(),
            twin_error: twins.error,
            whole: figures(&of_whole),
            not_modelled: truth.not_modelled,
            truth_error: truth.relative_error,
            is_resolved: truth.is_resolved,
        };
        Ok(Some((beginning, truth.modelled)))
    }

    /// Number of all runs.
    pub fn count(&self) -> usize {
        count(self.technique)
    }

    /// Number of parts in which the other runs can be made.
    pub fn parts(&self) -> usize {
        parts(self.technique)
    }

    /// Makes the runs of one of the other parts, by its number from 0, against the truth of the light.
    /// `heard` is called after each run. `None` if it was stopped.
    ///
    /// # Errors
    ///
    /// If the technique does not run, or its film cannot be compared.
    pub fn others(
        &self,
        beginning: &Beginning,
        truth: &[Rgb],
        number: usize,
        mut heard: impl FnMut(),
    ) -> Result<Option<KnownFigures>, AttributionError> {
        let technique = Method::new(self.technique.name(), &beginning.settings)?;
        let reference = self.image("the truth", truth);
        let mut known = KnownFigures::new();
        for set in self.sets(number) {
            let found = self.run(&technique, set)?;
            if self.is_stopped() {
                return Ok(None);
            }
            known.insert(set, figures(&self.compared(&reference, &found)?));
            heard();
        }
        Ok(Some(known))
    }

    /// The attribution, from the figures that are known and those of the parts that are missing, which `make`
    /// makes: by the beginning, a part's number, and what it calls after each run. `None` if it was stopped.
    ///
    /// # Errors
    ///
    /// As `make`'s.
    pub fn complete<E>(
        &self,
        beginning: Beginning,
        mut known: KnownFigures,
        missing: impl IntoIterator<Item = usize>,
        progressing: RunProgress,
        mut make: impl FnMut(&Beginning, usize, &mut dyn FnMut()) -> Result<Option<KnownFigures>, E>,
    ) -> Result<Option<Attribution>, E> {
        let (mut done, all) = (1 + known.len(), self.count());
        progressing(done, all);
        for number in missing {
            let mut heard = || {
                done += 1;
                progressing(done, all);
            };
            let Some(part) = make(&beginning, number, &mut heard)? else {
                return Ok(None);
            };
            known.extend(part);
        }
        Ok(Some(self.end(beginning, known)))
    }

    /// The attribution, from the figures of all parts.
    fn end(&self, beginning: Beginning, mut known: KnownFigures) -> Attribution {
        known.insert(self.all(), beginning.whole);
        let shares = Figure::OF_LIGHT.iter().enumerate();
        let shares = shares.filter_map(|(i, figure)| {
            let of = |set: Set| *known.get(&set)?.get(i)?;
            figure_shares(*figure, &self.causes, self.stages.len(), of)
        });
        let stages = self.stages.iter().map(|stage| AttributedStage {
            name: stage.name.to_owned(),
            variant: stage.variant.clone(),
            exact: stage.exact.to_owned(),
        });
        Attribution {
            approximation: self.technique.name().to_owned(),
            light: beginning.layer,
            size: self.sensor.size(),
            runs: self.count(),
            figures: shares.collect(),
            stages: stages.collect(),
            not_modelled: beginning.not_modelled,
            truth_error: beginning.truth_error,
            is_resolved: beginning.is_resolved,
            twin_error: beginning.twin_error,
        }
    }

    fn is_stopped(&self) -> bool {
        self.context.progress.is_stopped()
    }

    /// The set of all causes.
    fn all(&self) -> Set {
        (1 << self.causes.len()) - 1
    }

    /// The sets of a part's runs.
    fn sets(&self, number: usize) -> Vec<Set> {
        let all = sets(self.causes.len()).into_iter();
        let others = all.filter(|set| *set != self.all());
        // Dealt out in turn: runs with many exact stages take longest, and are side by side.
        others.skip(number).step_by(self.parts()).collect()
    }

    /// Runs the technique with those stages exact whose causes are not in the set.
    fn run(&self, technique: &Method, set: Set) -> Result<Rendering, AttributionError> {
        let mut method = technique.clone();
        for (bit, cause) in self.causes.iter().enumerate() {
            if set & (1 << bit) == 0 {
                method = method.with_exact(self.stages[*cause].name)?;
            }
        }
        Ok(method.run(self.scene, self.sensor, &Budget::default(), self.context)?)
    }

    fn compared(&self, truth: &CompareImage, run: &Rendering) -> Result<Fidelity, CompareError> {
        let image = self.image("the approximation", &run.estimate.total.values);
        fidelity::of(truth, &image)
    }

    fn image(&self, name: &str, values: &[Rgb]) -> CompareImage {
        let [width, height] = self.sensor.size();
        let mut image = Image::new(width, height);
        let triples: Vec<[f64; 3]> = values.iter().map(|value| value.0).collect();
        image.add_rgb("E", &triples);
        texels::describe(&mut image, self.scene, self.sensor);
        CompareImage::new(name, image)
    }
}

/// The number of runs of an attribution.
pub fn count(technique: &Method) -> usize {
    sets(causes(&technique.stages()).len()).len()
}

/// The number of parts in which all runs but the first can be made.
pub fn parts(technique: &Method) -> usize {
    (count(technique) - 1).div_ceil(TOGETHER)
}

fn causes(stages: &[StageSetting]) -> Vec<usize> {
    let all = 0..stages.len();
    all.filter(|stage| !stages[*stage].is_exact()).collect()
}

fn figures(found: &Fidelity) -> RunFigures {
    let figures = Figure::OF_LIGHT.into_iter();
    figures
        .map(|figure| Some(figure.of_light(found)?.value))
        .collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_all_runs_but_the_first_once() {
        let scene = crate::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")]).unwrap();
        let (sensor, context) = (&scene.sensors()[0], Context::default());
        let mut causes = Vec::new();
        for name in Method::names() {
            let technique = Method::new(name, &BTreeMap::new()).unwrap();
            let Ok(runs) = StageRuns::new(&technique, &scene, sensor, &context) else {
                continue;
            };
            let parts: Vec<Vec<Set>> = (0..runs.parts()).map(|part| runs.sets(part)).collect();
            assert!(
                parts
                    .iter()
                    .all(|part| (1..=TOGETHER).contains(&part.len()))
            );
            let mut all = parts.concat();
            all.push(runs.all());
            all.sort_by_key(|set| (set.count_ones(), *set));
            assert_eq!(all, sets(runs.causes.len()), "{name}");
            assert_eq!(all.len(), count(&technique), "{name}");
            causes.push(runs.causes.len());
        }
        // Of all subsets, and of some of them.
        let all = shapley::ALL_SUBSETS;
        assert!(
            causes.iter().any(|causes| (1..=all).contains(causes)),
            "{causes:?}"
        );
        assert!(causes.iter().any(|causes| *causes > all), "{causes:?}");
    }
}
