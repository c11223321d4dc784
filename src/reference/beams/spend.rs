//! Passes with smaller and smaller tolerances, until the budget is used.

use std::ops::Range;
use std::time::Instant;

use super::batch::batches;
use super::by_photons::OF_BEAMS;
use super::finish;
use super::layers::{BeamLayer, Made};
use super::limit::Limit;
use super::pass::layers as pass_layers;
use super::refine::Asked;
use super::report::BeamReport;
use super::run::Setup;
use super::schedule;
use super::selection::{Found, LeftOut, MARGIN, left, squares_of};
use super::settings::target_error;
use super::source::PassSource;
use super::traced::BatchSums;
use crate::geometry::TraversalCounters;
use crate::numeric::math;
use crate::reference::target::{LitTexels, Target};
use crate::run::{Budget, Error, Estimate};
use crate::transport::direct::{AREA_SAMPLES, Direct, direct};

/// Part of the error that is left of it after the next pass if no error is asked for.
const WITHOUT_TARGET: f64 = 0.25;

/// Least part of the error asked for that passes aim at, however much is left out.
const LEAST_LEFT: f64 = 0.5;

/// Number of passes that may light nothing, each finer than the one before, until nothing is known.
const MOST_UNLIT: u32 = 3;

/// Factor of the tolerance after a pass whose cells were too large to light any texel.
const UNLIT: f64 = 1.0 / 256.0;

/// A run whose budget is spent.
pub struct Spent {
    /// Direct light, for a receiver.
    direct: Option<Direct>,
    /// The layers that are followed.
    layers: Vec<BeamLayer>,
    /// The signatures that are not.
    others: Vec<Found>,
    passes: u32,
    counters: TraversalCounters,
    /// True if the first pass took so much more work than its forecast that it was ended.
    gave_up: bool,
}

impl Setup<'_> {
    /// Makes passes by what a source delivers until the budget is spent, or the source has no more.
    ///
    /// # Errors
    ///
    /// If a texel's flux is not representable, or as the source.
    pub(in crate::reference) fn spend(
        &mut self,
        budget: &Budget,
        source: &mut dyn PassSource,
    ) -> Result<Spent, Error> {
        let limit = Limit::new(budget, self.progress, self.began);
        let direct = match &self.inputs.target {
            Target::Receiver(receiver) => Some(
                // No area light shines: seed and samples have no effect.
                direct(self.inputs.scene, receiver, 0, AREA_SAMPLES, &|| {
                    limit.is_reached()
                })
                .unwrap_or_else(|| Direct::unknown(receiver.texels())),
            ),
            Target::Camera { .. } => None,
        };
        let counters = direct
            .as_ref()
            .map(|direct| direct.counters)
            .unwrap_or_default();
        limit.spend(counters.rays);
        let target = target_error(budget);
        let mut most_work = None;
        if !limit.is_set() {
            let forecast = self.forecast(budget);
            self.progress.set_forecast(Some(forecast.time));
            most_work = forecast.most_work;
        }
        let limit = limit.early(self.early(budget)).guarded(most_work);
        let (layers, others) = self.layers(target);
        let mut spent = Spent {
            direct,
            layers,
            others,
            passes: 0,
            counters,
            gave_up: false,
        };
        self.make_passes(&mut spent, target, &limit, source)?;
        Ok(spent)
    }

    /// The estimate of a run whose budget is spent, with what photons measure of the rest.
    ///
    /// # Errors
    ///
    /// If a texel's flux is not representable.
    pub(in crate::reference) fn finish(
        &mut self,
        budget: &Budget,
        spent: Spent,
    ) -> Result<(Estimate, BeamReport), Error> {
        let Spent {
            direct,
            layers,
            others,
            passes,
            counters,
            gave_up,
        } = spent;
        let target = target_error(budget);
        let film = self.inputs.target.size();
        let lit = self.lit(&layers, &others);
        // If the discovery found light on the film, layers without any tell nothing.
        let is_dark = lit.is_none() && self.is_lit();
        let (made, waiting): (Vec<BeamLayer>, Vec<BeamLayer>) = layers
            .into_iter()
            .partition(|layer| layer.made.is_some() && !is_dark);
        // A limit may end a run before it knows light that is too bright to be left out.
        let coarse = target.unwrap_or(schedule::COARSE_ERROR);
        let is_due = |layer: &&BeamLayer| layer.needed_for > coarse;
        let missing = waiting.iter().filter(is_due).flat_map(|one| &one.members);
        let missing = missing.fold(0.0, |sum, (_, found)| sum + found.on_film);
        let is_asked = waiting.iter().any(|layer| layer.asked.is_some());
        let waiting = waiting.into_iter().flat_map(|one| one.members);
        let others: Vec<Found> = others.into_iter().chain(waiting).collect();
        let of_beams = lit.map(|lit| schedule::error(&self.known(&made, lit)));
        let rest = if missing > 0.0 && !gave_up || self.photon_part.is_some() {
            self.by_photons(&made, &others, lit, budget)?
        } else {
            None
        };
        let (missing, left_out) = match &rest {
            Some(_) => (0.0, LeftOut::default()),
            None => (
                missing,
                LeftOut::of(others.iter(), film).and_everywhere(MARGIN * missing, film),
            ),
        };
        let reached = match (&rest, lit, of_beams) {
            (Some((rest, _)), ..) => rest.relative_error,
            (None, Some(lit), Some(error)) => Some(math::hypot(
                error,
                self.error_of_left_out(left_out.squares, lit),
            )),
            _ => None,
        };
        let limited = budget.time.is_some() || budget.work.is_some();
        let is_unmet = match (target, reached) {
            (Some(target), Some(error)) => error > target,
            (Some(_), None) => rest.is_some(),
            (None, _) => false,
        } || made.iter().any(|layer| layer.is_unmet(&self.inputs.target));
        let incomplete = self.progress.is_stopped()
            || is_unmet && !limited
            || missing > 0.0
            || gave_up && rest.is_none()
            || is_asked
            || rest.as_ref().is_some_and(|(rest, _)| rest.incomplete)
            || made.is_empty() && rest.is_none() && !self.is_dark();
        let reports = made.iter().filter_map(|layer| layer.made.as_ref());
        let report = BeamReport {
            passes,
            not_followed: left_out.flux,
            relative_tolerance: reports
                .clone()
                .map(|made| made.tolerance)
                .reduce(f64::min)
                .unwrap_or(0.0),
            signatures: reports.flat_map(|made| made.reports.clone()).collect(),
            gave_up,
            by_photons: rest.as_ref().map(|(_, report)| report.clone()),
        };
        let outcome = finish::RunOutcome {
            scene: self.inputs.scene,
            target: &self.inputs.target,
            layers: made,
            left_out,
            rest: rest.map(|(rest, _)| rest),
            unseen: self.unseen(),
            direct: direct.as_ref(),
            relative_error: reached,
            counters,
            incomplete,
        };
        Ok((outcome.estimate(), report))
    }

    /// Makes the layers until their error is reached, or no budget is left.
    fn make_passes(
        &self,
        spent: &mut Spent,
        target: Option<f64>,
        limit: &Limit,
        source: &mut dyn PassSource,
    ) -> Result<(), Error> {
        let Spent {
            layers,
            others,
            passes,
            counters,
            gave_up,
            ..
        } = spent;
        let first = schedule::first(target, limit.is_set());
        let goal = target.unwrap_or(schedule::COARSE_ERROR);
        let tolerances = layers.iter().map(|layer| self.first(layer, first, goal));
        let mut tolerances: Vec<Option<f64>> = tolerances.collect();
        let mut unlit = 0;
        while tolerances.iter().any(Option::is_some) {
            let (began, rays) = (Instant::now(), limit.rays());
            let (work, is_done) = self.pass(layers, &tolerances, limit, counters, source)?;
            *passes += u32::from(work > 0.0);
            *gave_up = !is_done && limit.is_beyond_guard();
            if !is_done || limit.is_reached() {
                break;
            }
            let Some(mut lit) = self.lit(layers, others) else {
                if !self.is_lit() || unlit == MOST_UNLIT {
                    break;
                }
                unlit += 1;
                for tolerance in tolerances.iter_mut().flatten() {
                    *tolerance *= UNLIT;
                }
                continue;
            };
            if self.photon_part.is_some() {
                lit = self.with_others(lit, others);
            }
            let known = self.known(layers, lit);
            let error = schedule::error(&known);
            self.progress.set_relative_error(Some(error));
            if !layers
                .iter()
                .any(|layer| layer.made.is_none() && layer.needed_for > goal)
            {
                limit.extend();
            }
            let goal = target.unwrap_or(WITHOUT_TARGET * error);
            let affordable = work * limit.affordable(began.elapsed(), limit.rays() - rays);
            let goal = if self.photon_part.is_none() {
                self.left_for_beams(layers, others, lit, goal)
            } else {
                OF_BEAMS * goal
            };
            let finer = schedule::affordable(&known, goal, affordable);
            let mut finer = finer.into_iter();
            let again = |layer: &BeamLayer| {
                layer.made.as_ref()?;
                let both = [
                    finer.next().flatten(),
                    layer.own_tolerance(&self.inputs.target),
                ];
                both.into_iter().flatten().reduce(f64::min)
            };
            tolerances = layers.iter().map(again).collect();
            if tolerances.iter().all(Option::is_none) {
                break;
            }
            for (layer, tolerance) in layers.iter().zip(&mut tolerances) {
                if layer.made.is_none() {
                    *tolerance = self.first(layer, first, goal);
                }
            }
        }
        Ok(())
    }

    /// The error that the layers may have if all light may have `goal`: what is not followed has its part of
    /// that. On lit texels it may be a larger one than the [selection](super::selection) foresaw.
    fn left_for_beams(
        &self,
        layers: &[BeamLayer],
        others: &[Found],
        lit: LitTexels,
        goal: f64,
    ) -> f64 {
        let waiting = layers.iter().filter(|layer| layer.made.is_none());
        let waiting = waiting.flat_map(|layer| &layer.members);
        let squares = squares_of(others.iter().chain(waiting), self.inputs.target.size());
        let of_others = self.error_of_left_out(squares, lit);
        let rest = (goal * goal - of_others * of_others).max(0.0).sqrt();
        rest.clamp(LEAST_LEFT * goal, left(goal))
    }

    /// The error of light that is left out, by its Σ φ² \[W²\], relative to that of lit texels.
    fn error_of_left_out(&self, squares: f64, lit: LitTexels) -> f64 {
        lit.relative_error(squares) / self.typical_measure()
    }

    /// Makes some layers anew, each at its relative tolerance, as far as the limit allows and the source
    /// delivers. Returns the work that they took, and true if all are made.
    fn pass(
        &self,
        layers: &mut [BeamLayer],
        tolerances: &[Option<f64>],
        limit: &Limit,
        counters: &mut TraversalCounters,
        source: &mut dyn PassSource,
    ) -> Result<(f64, bool), Error> {
        let passes = self.passes(limit);
        let patches: usize = self
            .inputs
            .lights
            .iter()
            .map(|light| light.patches.len())
            .sum();
        let asked = || {
            layers
                .iter()
                .zip(tolerances)
                .filter(|(_, asked)| asked.is_some())
        };
        let signatures: usize = asked().map(|(layer, _)| layer.members.len()).sum();
        self.progress.begin_pass((patches * signatures) as u64);
        let members = self.members(layers, tolerances);
        let mut waiting: Vec<(Made, usize)> = layers
            .iter()
            .map(|layer| (Made::default(), layer.members.len()))
            .collect();
        let mut all = 0.0;
        let may_end = limit.is_set() || self.photon_part.is_some();
        let batches = batches(members.len(), self.most_together(), may_end);
        let asked = |batch: &Range<usize>| members[batch.clone()].iter().map(|one| one.asked);
        let asked: Vec<Vec<Asked>> = batches.iter().map(|batch| asked(batch).collect()).collect();
        source.begin_pass(&asked);
        for (batch, asked) in batches.into_iter().zip(&asked) {
            let batch = &members[batch];
            let sums = source.batch(&passes, &self.inputs.lights, asked)?;
            let Some(sums) = sums.filter(|sums| !matches!(sums, BatchSums::Beyond { .. })) else {
                return Ok((all, false));
            };
            pass_layers(sums, asked, |index, mut one| {
                let member = &batch[index];
                *counters += one.counters;
                if let Some(bound) = &member.may_get {
                    one.sums.widen(bound);
                }
                let (made, left) = &mut waiting[member.layer];
                made.add(one);
                *left -= 1;
                if *left == 0
                    && let Some(made) = std::mem::take(made).layer(member.tolerance)
                {
                    all += made.work;
                    layers[member.layer].take(made, &self.inputs.target);
                }
            });
        }
        Ok((all, true))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::beams::settings::BeamSettings;
    use crate::reference::beams::source::Here;
    use crate::run::Progress;
    use crate::scene::Scene;

    /// A run to 0.1 % whose first pass may take so much work.
    fn guarded(scene: &Scene, most_work: Option<u64>) -> (Estimate, BeamReport) {
        let (progress, budget) = (Progress::default(), Budget::error(1e-3));
        let sensor = &scene.sensors()[0];
        let mut setup = Setup::new(scene, sensor, BeamSettings::default(), &progress).unwrap();
        let limit = Limit::new(&budget, &progress, setup.began).guarded(most_work);
        let (layers, others) = setup.layers(target_error(&budget));
        let mut spent = Spent {
            direct: None,
            layers,
            others,
            passes: 0,
            counters: TraversalCounters::default(),
            gave_up: false,
        };
        let target = target_error(&budget);
        setup
            .make_passes(&mut spent, target, &limit, &mut Here)
            .unwrap();
        setup.finish(&budget, spent).unwrap()
    }

    #[test]
    fn beams_that_give_up_say_so_and_what_they_know_is_within_its_bounds() {
        let size = [("size".to_owned(), "32".to_owned())];
        let scene = crate::mitsuba::load("scenes/glass-ball.xml".as_ref(), &size).unwrap();
        let (truth, report) = guarded(&scene, None);
        assert!(!truth.incomplete && !report.gave_up && report.passes > 0);
        let (nothing, report) = guarded(&scene, Some(256));
        assert!(nothing.incomplete && report.gave_up && report.by_photons.is_none());
        assert!(nothing.total.is_unknown() && report.passes == 0);
        // The brightest light comes first: some guards let it pass, and not the rest.
        let some = (10..30).map(|power| guarded(&scene, Some(1 << power)));
        let some: Vec<_> = some
            .filter(|(_, report)| report.gave_up && !report.signatures.is_empty())
            .collect();
        assert!(!some.is_empty());
        for (part, report) in some {
            assert!(part.incomplete && report.by_photons.is_none() && report.not_followed > 0.0);
            let bounds = part.total.interval.as_ref().unwrap();
            let all = truth.total.interval.as_ref().unwrap();
            for texel in 0..part.total.values.len() {
                let is_disjoint = bounds.high[texel].mean() < all.low[texel].mean()
                    || bounds.low[texel].mean() > all.high[texel].mean();
                assert!(!is_disjoint, "texel {texel}");
            }
        }
    }
}
