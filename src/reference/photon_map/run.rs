//! Spending a budget on photon maps.

use std::time::Instant;

use super::finish::{PhotonMapReport, Rounds};
use super::gather::Pass;
use super::map::{Catch, PhotonMap};
use super::settings::{PhotonMapSettings, radius_squared_factor};
use super::setup::{PHOTONS, Setup};
use super::sums::RoundSums;
use crate::reference::Target;
use crate::reference::photons::DEFAULT_PHOTONS;
use crate::reference::rounds::{self, Schedule};
use crate::reference::shard::Shard;
use crate::run::{Budget, Error, Estimate, Progress};
use crate::scene::{Scene, Sensor};

impl Setup<'_> {
    /// Spends the budget and delivers the estimate, and the report on its bias.
    ///
    /// The unit of a round is a pass: one map for each replicate. Radii go on shrinking from round to round.
    /// A run that is stopped, or out of time, has the rounds before, at least half of what was gathered; of
    /// the first round it has the replicates that are done.
    ///
    /// # Errors
    ///
    /// If contributions are not representable, or a map is too large.
    pub fn run(&self, budget: &Budget) -> Result<(Estimate, PhotonMapReport), Error> {
        let (schedule, mut run) = self.begun(budget, Instant::now());
        schedule.spend(&mut run)?;
        Ok(run.estimate())
    }

    /// A run that begins, and the schedule by which it spends its budget.
    pub(in crate::reference) fn begun<'b>(
        &'b self,
        budget: &'b Budget,
        start: Instant,
    ) -> (Schedule<'b>, Run<'b>) {
        let photons = budget.work.unwrap_or(if budget.is_work_only() {
            DEFAULT_PHOTONS
        } else {
            u64::MAX
        });
        let each_pass = self.settings.map_photons * u64::from(self.settings.photons.replicates);
        let run = Run {
            setup: self,
            each_pass,
            rounds: Rounds::new(self),
        };
        let schedule = Schedule {
            budget,
            progress: self.progress,
            start,
            first: 1,
            most: (photons / each_pass).max(1),
            hopeless: DEFAULT_PHOTONS.div_ceil(each_pass),
            // The first replicate of one round would be most of the run.
            is_in_one: false,
        };
        (schedule, run)
    }

    /// The shard's replicates of `passes` passes after the first `before`; fewer if it is stopped.
    pub(in crate::reference) fn round(
        &self,
        before: u64,
        passes: u64,
        shard: Shard,
        deadline: Option<Instant>,
    ) -> Result<RoundSums, Error> {
        let stop = || self.progress.is_over(deadline);
        let mut sums = RoundSums::new(self, passes);
        let (Some(camera), Target::Camera { etendue, .. }) = (self.camera(), &self.target) else {
            return Ok(sums);
        };
        let replicates = 0..self.settings.photons.replicates;
        for replicate in replicates.filter(|replicate| shard.holds(*replicate)) {
            let replicate = u64::from(replicate);
            for pass in before..before + passes {
                let photons = self.stream(PHOTONS).split(replicate).split(pass);
                let job = self.job(photons, &stop);
                let caught = job.trace(self.settings.map_photons, || Catch {
                    scatters: &self.scatters,
                    without: self.without(),
                    map: &self.map,
                    positions: Vec::new(),
                    photons: Vec::new(),
                });
                if stop() {
                    return Ok(sums);
                }
                for task in &caught {
                    sums.count(task.counters);
                }
                let factor = radius_squared_factor(pass, self.settings.alpha);
                let map = PhotonMap::new(caught)?;
                let pass = Pass {
                    setup: self,
                    camera,
                    map: &map,
                    stream: self.pixel_stream().split(replicate),
                    number: pass,
                    radius_squared: self.settings.radius * self.settings.radius * factor,
                    factor: etendue / passes as f64,
                };
                sums.gather(&pass, &stop)?;
                if stop() {
                    return Ok(sums);
                }
                self.progress.add(self.settings.map_photons);
            }
            sums.end_replicate()?;
        }
        Ok(sums)
    }
}

/// A run under way: its rounds so far.
pub struct Run<'a> {
    pub(in crate::reference) setup: &'a Setup<'a>,
    /// Photons of one pass, all replicates together.
    each_pass: u64,
    rounds: Rounds<'a>,
}

impl Run<'_> {
    /// Adds a round. True if it has all replicates.
    pub(in crate::reference) fn add(&mut self, sums: &RoundSums) -> bool {
        let is_whole = sums.replicates() == self.setup.settings.photons.replicates;
        // One replicate says nothing of its own error, and beside whole rounds a few make bars wider.
        if is_whole || (self.rounds.passes() == 0 && sums.replicates() > 1) {
            self.rounds.add(sums);
        }
        is_whole
    }

    /// The estimate of all rounds, and the report on its bias.
    pub(in crate::reference) fn estimate(self) -> (Estimate, PhotonMapReport) {
        let setup = self.setup;
        let is_empty = self.rounds.passes() == 0 && !setup.light.is_empty();
        let incomplete = setup.progress.is_stopped() || is_empty;
        self.rounds.estimate(incomplete)
    }
}

impl rounds::Rounds for Run<'_> {
    fn trace(&mut self, _number: u64, each: u64, deadline: Option<Instant>) -> Result<bool, Error> {
        let before = self.rounds.passes();
        let expected = (before + each).saturating_mul(self.each_pass);
        self.setup.progress.expect(expected);
        let sums = self.setup.round(before, each, Shard::WHOLE, deadline)?;
        Ok(self.add(&sums))
    }

    fn done(&self) -> u64 {
        self.rounds.passes()
    }

    fn relative_error(&self) -> Option<f64> {
        self.rounds.relative_error()
    }

    fn is_dark(&self) -> bool {
        self.setup.light.is_empty()
    }
}

/// Measures the caustics that a camera sees, by photon maps.
///
/// # Errors
///
/// As [`Setup::new`] and [`Setup::run`].
pub fn run(
    scene: &Scene,
    sensor: &Sensor,
    settings: PhotonMapSettings,
    budget: &Budget,
    progress: &Progress,
) -> Result<(Estimate, PhotonMapReport), Error> {
    Setup::new(scene, sensor, settings, progress)?.run(budget)
}
