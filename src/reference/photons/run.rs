//! Spending a budget on replicates.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::finish::{Rounds, relative_error_of};
use super::layers::{LayerMap, pilot};
use super::replicate::Job;
use super::settings::{Budget, PhotonSettings, Shard};
use super::sums::{RoundSums, SumsError};
use crate::numeric::{FixedPoint, Stream};
use crate::reference::{Estimate, Progress, Target, TargetError};
use crate::scene::{Scene, Sensor};
use crate::transport::direct::{Direct, direct};
use crate::transport::domain::{LightSpace, LightSpaceError};
use crate::transport::signature::MAX_EVENTS;

/// Why a run cannot start or came to nothing.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The sensor cannot be filled.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// An emitter cannot be sampled.
    #[error(transparent)]
    LightSpace(#[from] LightSpaceError),
    /// The photons' sums are worth nothing.
    #[error(transparent)]
    Sums(#[from] SumsError),
    /// A setting outside its range.
    #[error("{name} is {value}; {allowed} are allowed")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: String,
        /// What it may be.
        allowed: String,
    },
    /// A shard of a run whose length depends on time or error.
    #[error(
        "a shard needs a fixed number of photons: give --photons, and neither --time nor --error"
    )]
    ShardBudget,
}

/// A run, set up: everything its photons need.
pub struct Setup<'a> {
    pub(super) scene: &'a Scene,
    pub(super) settings: PhotonSettings,
    pub(super) target: Target,
    pub(super) light: LightSpace,
    pub(super) map: LayerMap,
    progress: &'a Progress,
}

/// Photons of each replicate in the first round of a run that has no fixed number of them.
const FIRST_ROUND_PHOTONS: u64 = 1 << 12;

/// How often a round works out its error so far, for whoever watches: it takes a while.
const SHOW_EVERY: Duration = Duration::from_millis(500);

impl<'a> Setup<'a> {
    /// Checks the settings, finds where light can meet specular geometry, and which path
    /// signatures are bright enough for a layer of their own.
    ///
    /// # Errors
    ///
    /// Where a setting is out of range, the sensor cannot receive or an emitter is not modelled.
    pub fn new(
        scene: &'a Scene,
        sensor: &Sensor,
        settings: PhotonSettings,
        progress: &'a Progress,
    ) -> Result<Self, RunError> {
        check(&settings)?;
        let target = Target::new(scene, sensor, settings.chains.shading_normals)?;
        let light = LightSpace::new(scene)?;
        check_flux(&light)?;
        let mut setup = Self {
            scene,
            settings,
            target,
            light,
            map: LayerMap::new(Vec::new()),
            progress,
        };
        let stop = || progress.is_stopped();
        setup.map = pilot(
            &setup.job(setup.stream(PILOT), &stop, &|_| ()),
            &setup.target,
            settings.max_layers,
        );
        Ok(setup)
    }

    /// What the photons fill.
    pub fn target(&self) -> &Target {
        &self.target
    }

    /// Where photons start.
    pub fn light(&self) -> &LightSpace {
        &self.light
    }

    /// Measures the direct light of a receiver; what is not measured when the run is stopped is unknown.
    /// `None` of a camera.
    pub fn direct(&self, deadline: Option<Instant>) -> Option<Direct> {
        let Target::Receiver(receiver) = &self.target else {
            return None;
        };
        let stop = || self.is_over(deadline);
        let PhotonSettings {
            seed,
            direct_samples,
            ..
        } = self.settings;
        let measured = direct(self.scene, receiver, seed, direct_samples, &stop);
        Some(measured.unwrap_or_else(|| Direct::unknown(receiver.texels())))
    }

    fn is_over(&self, deadline: Option<Instant>) -> bool {
        self.progress.is_stopped() || deadline.is_some_and(|deadline| Instant::now() > deadline)
    }

    /// Spends the budget and delivers the estimate.
    ///
    /// With only photons limited there is one round. Otherwise there are several, each of all
    /// replicates with twice the photons of the one before, until the next would not fit.
    ///
    /// # Errors
    ///
    /// Where photon contributions are not representable.
    pub fn run(&self, budget: &Budget) -> Result<Estimate, RunError> {
        let start = Instant::now();
        // A time beyond what the clock can tell is no limit.
        let deadline = budget.time.and_then(|time| start.checked_add(time));
        let direct = self.direct(deadline);
        let mut rounds = Rounds::new(self.target.texels(), &self.map);
        let mut incomplete;
        if budget.is_photons_only() {
            let photons = budget.photons.unwrap_or(Budget::DEFAULT_PHOTONS);
            let (replicates, each) = self.division(photons);
            self.expect(each * u64::from(replicates));
            let sums = self.round(0, each, replicates, Shard::WHOLE, None)?;
            incomplete = sums.replicates() < replicates;
            rounds.add(&sums, &self.map);
        } else {
            incomplete = self.rounds(budget, start, &mut rounds)?;
        }
        // A budget too small for a single replicate leaves no estimate at all.
        incomplete |= rounds.paths() == 0 && !self.light.is_empty();
        Ok(rounds.estimate(&self.target, &self.map, direct.as_ref(), incomplete))
    }

    /// Traces rounds until the budget is used up. Returns whether the run was stopped before.
    fn rounds(
        &self,
        budget: &Budget,
        start: Instant,
        rounds: &mut Rounds,
    ) -> Result<bool, RunError> {
        let deadline = budget.time.and_then(|time| start.checked_add(time));
        let most = budget.photons.unwrap_or(u64::MAX);
        let (replicates, most_each) = self.division(most);
        let mut each = FIRST_ROUND_PHOTONS.min(most_each);
        for round in 0.. {
            self.expect(rounds.paths() + each * u64::from(replicates));
            let sums = self.round(round, each, replicates, Shard::WHOLE, deadline)?;
            let complete = sums.replicates() == replicates;
            // One replicate says nothing of its own error: beside earlier rounds it is no use.
            if sums.replicates() > 1 || rounds.paths() == 0 {
                rounds.add(&sums, &self.map);
            }
            let error = rounds.relative_error();
            self.progress.set_relative_error(error);
            let is_good =
                matches!((error, budget.relative_error), (Some(e), Some(goal)) if e <= goal);
            if !complete || is_good || self.light.is_empty() {
                break;
            }
            // Where nothing arrives there is no error to reach.
            let is_hopeless = error.is_none() && rounds.paths() >= Budget::DEFAULT_PHOTONS;
            if is_hopeless && budget.time.is_none() {
                return Ok(true);
            }
            let Some(next) = self.next_round(rounds, each, budget, start.elapsed()) else {
                break;
            };
            each = next;
        }
        Ok(self.progress.is_stopped())
    }

    /// Photons of each replicate of the next round; `None` where the budget is used up.
    fn next_round(
        &self,
        rounds: &Rounds,
        each: u64,
        budget: &Budget,
        elapsed: Duration,
    ) -> Option<u64> {
        let replicates = u64::from(self.settings.replicates);
        let mut next = each * 2;
        if let Some(photons) = budget.photons {
            next = next.min(photons.saturating_sub(rounds.paths()) / replicates);
        }
        if let Some(time) = budget.time {
            let rate = rounds.paths() as f64 / elapsed.as_secs_f64();
            let left = time.saturating_sub(elapsed).as_secs_f64();
            // A power of two suits Sobol' points, and a round that ends early is no use.
            let fits = (0.9 * rate * left) as u64 / replicates;
            if fits < next {
                next = next.min(fits.checked_ilog2().map_or(0, |log| 1 << log));
            }
        }
        (next >= FIRST_ROUND_PHOTONS.min(each)).then_some(next)
    }

    /// How many replicates of how many photons make a run of `photons`: a multiple of the
    /// replicates, at least one photon each.
    pub fn division(&self, photons: u64) -> (u32, u64) {
        let replicates = u64::from(self.settings.replicates).min(photons.max(1));
        (replicates as u32, photons.max(1) / replicates)
    }

    /// Traces one round, or the shard's part of it.
    pub(super) fn round(
        &self,
        round: u64,
        photons: u64,
        replicates: u32,
        shard: Shard,
        deadline: Option<Instant>,
    ) -> Result<RoundSums, RunError> {
        let stop = || self.is_over(deadline);
        let finished = |photons: u64| {
            self.progress.paths.fetch_add(photons, Ordering::Relaxed);
        };
        let mut sums = None;
        let mut shown = Instant::now();
        for replicate in (0..replicates).filter(|replicate| shard.holds(*replicate)) {
            let stream = self
                .stream(REPLICATES)
                .split(round)
                .split(u64::from(replicate));
            let job = self.job(stream, &stop, &finished);
            let sums =
                sums.get_or_insert_with(|| RoundSums::new(&job, &self.target, &self.map, photons));
            if !sums.add_replicate(&job, &self.target, &self.map)? {
                break;
            }
            if round == 0 && shown.elapsed() > SHOW_EVERY {
                shown = Instant::now();
                self.progress.set_relative_error(relative_error_of(sums));
            }
        }
        let job = self.job(self.stream(REPLICATES), &stop, &finished);
        Ok(sums.unwrap_or_else(|| RoundSums::new(&job, &self.target, &self.map, photons)))
    }

    /// Says how many photons there will be.
    pub(super) fn expect(&self, photons: u64) {
        self.progress
            .expected_paths
            .store(photons, Ordering::Relaxed);
    }

    fn stream(&self, purpose: u64) -> Stream {
        Stream::new(self.settings.stream, self.settings.seed).split(purpose)
    }

    fn job<'b>(
        &'b self,
        stream: Stream,
        stop: &'b (dyn Fn() -> bool + Sync),
        finished: &'b (dyn Fn(u64) + Sync),
    ) -> Job<'b> {
        Job {
            scene: self.scene,
            light: &self.light,
            chains: self.settings.chains,
            stream,
            stop,
            finished,
        }
    }
}

/// Refuses settings that are out of range.
pub(in crate::reference) fn check(settings: &PhotonSettings) -> Result<(), RunError> {
    if settings.chains.max_depth as usize > MAX_EVENTS {
        return refused(
            "the depth",
            settings.chains.max_depth.to_string(),
            format!("0 to {MAX_EVENTS} specular events"),
        );
    }
    // 255 replicates fit the squares of the exact sums with all light in one texel.
    if !(1..=255).contains(&settings.replicates) {
        return refused(
            "the number of replicates",
            settings.replicates.to_string(),
            "1 to 255".to_owned(),
        );
    }
    if settings.max_layers > 1024 {
        return refused(
            "the number of layers",
            settings.max_layers.to_string(),
            "0 to 1024".to_owned(),
        );
    }
    Ok(())
}

/// Refuses emitters so strong or so faint that their flux has no fixed-point scale.
pub(in crate::reference) fn check_flux(light: &LightSpace) -> Result<(), RunError> {
    let flux = light.flux_bound().max_channel();
    if FixedPoint::for_total(flux).is_err() {
        return refused(
            "the flux of all emitters",
            format!("{flux:e} W"),
            "0 and 1e-250 W to 1e250 W".to_owned(),
        );
    }
    Ok(())
}

pub(in crate::reference) fn refused(
    name: &'static str,
    value: String,
    allowed: String,
) -> Result<(), RunError> {
    Err(RunError::Setting {
        name,
        value,
        allowed,
    })
}

/// Streams of the pilot run and of the replicates are kept apart by these.
const PILOT: u64 = 1;
const REPLICATES: u64 = 2;

/// Measures what falls on a sensor.
///
/// # Errors
///
/// Where the settings or the scene do not allow it, or photon contributions are not
/// representable.
pub fn run(
    scene: &Scene,
    sensor: &Sensor,
    settings: PhotonSettings,
    budget: &Budget,
    progress: &Progress,
) -> Result<Estimate, RunError> {
    Setup::new(scene, sensor, settings, progress)?.run(budget)
}
