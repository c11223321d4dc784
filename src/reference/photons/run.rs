//! Spending a budget on replicates.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use super::bounds::at_most_unseen;
use super::finish::{Rounds, relative_error_of};
use super::layers::LayerMap;
use super::pilot::{PilotLight, squares_by_cell};
use super::replicate::Job;
use super::settings::{DEFAULT_PHOTONS, PhotonSettings};
use super::sums::RoundSums;
use crate::numeric::{FixedPoint, Stream};
use crate::radiometry::Rgb;
use crate::reference::rounds::{self, Schedule};
use crate::reference::shard::Shard;
use crate::reference::target::{LitTexels, Target};
use crate::run::{Budget, Error, Estimate, Progress};
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;
use crate::transport::camera::Camera;
use crate::transport::direct::{Direct, direct};
use crate::transport::domain::LightSpace;
use crate::transport::signature::{MAX_EVENTS, Signature};

/// A run, set up: everything its photons need.
pub struct Setup<'a> {
    pub(in crate::reference) scene: &'a Scene,
    pub(in crate::reference) settings: PhotonSettings,
    pub(in crate::reference) target: Target,
    pub(super) light: LightSpace,
    pub(super) pilot: PilotLight,
    pub(in crate::reference) map: LayerMap,
    /// The light that errors are relative to; `None` for the photons' own.
    lit: Option<LitTexels>,
    pub(in crate::reference) progress: &'a Progress,
}

/// Photons of each replicate in the first round of a run that has no fixed number of them.
const FIRST_ROUND_PHOTONS: u64 = 1 << 12;

/// Time between two computations of the error so far, which is shown and takes a while.
const SHOW_EVERY: Duration = Duration::from_millis(500);

impl<'a> Setup<'a> {
    /// Checks the settings, finds where light can meet specular geometry, and which path
    /// signatures are bright enough for a layer of their own.
    ///
    /// # Errors
    ///
    /// If a setting is out of range, the sensor cannot receive or an emitter is not modelled.
    pub fn new(
        scene: &'a Scene,
        sensor: &Sensor,
        settings: PhotonSettings,
        progress: &'a Progress,
    ) -> Result<Self, Error> {
        check(&settings)?;
        let normals = settings.chains.shading_normals;
        let target = Target::new(scene, sensor, normals, Camera::connectable)?;
        let light = LightSpace::aimed(scene, settings.chains.followed)?;
        check_flux(&light)?;
        let mut setup = Self {
            scene,
            settings,
            target,
            light,
            pilot: PilotLight::default(),
            map: LayerMap::default(),
            lit: None,
            progress,
        };
        let stop = || progress.is_stopped();
        let job = setup.job(setup.stream(PILOT), &stop, &|_| ());
        setup.pilot = PilotLight::of(&job, &setup.target);
        setup.map = setup.pilot.layers(settings.max_layers, BTreeSet::new());
        Ok(setup)
    }

    /// What the pilot's photons brought.
    pub fn pilot(&self) -> &PilotLight {
        &self.pilot
    }

    /// Leaves out the light of some signatures, which somebody else measures. Of the others so many get a
    /// layer of their own. Errors are relative to the light that is `lit`, if that is known.
    pub fn leave_out(
        &mut self,
        signatures: BTreeSet<Signature>,
        layers: usize,
        lit: Option<LitTexels>,
    ) {
        self.map = self.pilot.layers(layers, signatures);
        self.lit = lit;
    }

    /// The target that the photons fill.
    pub fn target(&self) -> &Target {
        &self.target
    }

    /// The light space in which photons start.
    pub fn light(&self) -> &LightSpace {
        &self.light
    }

    /// The signatures that the pilot gave a layer of their own.
    pub fn signatures(&self) -> &[Signature] {
        self.map.signatures()
    }

    /// The direct light of a receiver; unknown as far as it is not measured when the run is stopped. `None`
    /// for a camera.
    pub fn direct(&self, deadline: Option<Instant>) -> Option<Direct> {
        let Target::Receiver(receiver) = &self.target else {
            return None;
        };
        let stop = || self.progress.is_over(deadline);
        let PhotonSettings {
            seed,
            direct_samples,
            ..
        } = self.settings;
        let measured = direct(self.scene, receiver, seed, direct_samples, &stop);
        Some(measured.unwrap_or_else(|| Direct::unknown(receiver.texels())))
    }

    /// Spends the budget and delivers the estimate.
    ///
    /// # Errors
    ///
    /// If photon contributions are not representable.
    pub fn run(&self, budget: &Budget) -> Result<Estimate, Error> {
        let start = Instant::now();
        let direct = self.direct(budget.deadline(start));
        let (schedule, mut run) = self.begun(budget, start);
        let incomplete = schedule.spend(&mut run)?;
        Ok(run.estimate(direct.as_ref(), incomplete))
    }

    /// The same without the direct light, by photons that start where the light in question does. Also
    /// returns the flux \[W\] of it that they may have missed: they tell its bounds where they start often.
    /// Elsewhere a few large ones may, by chance, be none.
    ///
    /// # Errors
    ///
    /// As [`Setup::run`].
    pub fn run_aimed(&mut self, budget: &Budget) -> Result<(Estimate, Rgb), Error> {
        let start = Instant::now();
        let stop = || self.progress.is_over(budget.deadline(start));
        let job = self.job(self.stream(AIM), &stop, &|_| ());
        let squares = squares_by_cell(&job, &self.target, &self.map);
        self.light.share_by(&squares);
        let (schedule, mut run) = self.begun(budget, start);
        let incomplete = schedule.spend(&mut run)?;
        let relative_error = rounds::Rounds::relative_error(&run);
        let missed = run.rounds.largest_start() * at_most_unseen();
        let estimate = Estimate {
            relative_error,
            ..run.estimate(None, incomplete)
        };
        Ok((estimate, missed))
    }

    /// A run that begins, and the schedule by which it spends its budget.
    pub(in crate::reference) fn begun<'b>(
        &'b self,
        budget: &'b Budget,
        start: Instant,
    ) -> (Schedule<'b>, Run<'b, 'a>) {
        let (replicates, most) = self.division(budget.work.unwrap_or(if budget.is_work_only() {
            DEFAULT_PHOTONS
        } else {
            u64::MAX
        }));
        let schedule = Schedule {
            budget,
            progress: self.progress,
            start,
            first: FIRST_ROUND_PHOTONS,
            most,
            hopeless: DEFAULT_PHOTONS.div_ceil(u64::from(replicates)),
            is_in_one: true,
        };
        let run = Run {
            setup: self,
            replicates,
            rounds: self.rounds(),
        };
        (schedule, run)
    }

    /// The state before any round.
    pub(super) fn rounds(&self) -> Rounds {
        let is_signed = !self.scene.dispersion().is_empty();
        Rounds::new(self.target.texels(), &self.map, is_signed)
    }

    /// Number of replicates, and of photons of each, for a run of `photons`: at least one photon each.
    pub fn division(&self, photons: u64) -> (u32, u64) {
        let replicates = u64::from(self.settings.replicates).min(photons.max(1));
        (replicates as u32, photons.max(1) / replicates)
    }

    /// Traces one round, or the shard's part of it.
    pub(in crate::reference) fn round(
        &self,
        round: u64,
        photons: u64,
        replicates: u32,
        shard: Shard,
        deadline: Option<Instant>,
    ) -> Result<RoundSums, Error> {
        let stop = || self.progress.is_over(deadline);
        let finished = |photons: u64| self.progress.add(photons);
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
            if round == 0 && self.lit.is_none() && shown.elapsed() > SHOW_EVERY {
                shown = Instant::now();
                self.progress.set_relative_error(relative_error_of(sums));
            }
        }
        let job = self.job(self.stream(REPLICATES), &stop, &finished);
        Ok(sums.unwrap_or_else(|| RoundSums::new(&job, &self.target, &self.map, photons)))
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

/// A run under way: its rounds so far.
pub struct Run<'a, 's> {
    pub(in crate::reference) setup: &'a Setup<'s>,
    pub(in crate::reference) replicates: u32,
    rounds: Rounds,
}

impl Run<'_, '_> {
    /// Adds a round. True if it has all replicates.
    pub(in crate::reference) fn add(&mut self, sums: &RoundSums) -> bool {
        // One replicate says nothing of its own error: beside earlier rounds it is no use.
        if sums.replicates() > 1 || self.rounds.paths() == 0 {
            self.rounds.add(sums, &self.setup.map);
        }
        sums.replicates() == self.replicates
    }

    /// The estimate of all rounds.
    pub(in crate::reference) fn estimate(
        self,
        direct: Option<&Direct>,
        incomplete: bool,
    ) -> Estimate {
        let setup = self.setup;
        // A budget too small for a single replicate leaves no estimate at all.
        let is_nothing = self.rounds.paths() == 0 && !setup.light.is_empty();
        let incomplete = incomplete || is_nothing;
        self.rounds
            .estimate(&setup.target, &setup.map, direct, incomplete)
    }
}

impl rounds::Rounds for Run<'_, '_> {
    fn trace(&mut self, number: u64, each: u64, deadline: Option<Instant>) -> Result<bool, Error> {
        let setup = self.setup;
        setup
            .progress
            .expect(self.rounds.paths() + each * u64::from(self.replicates));
        let sums = setup.round(number, each, self.replicates, Shard::WHOLE, deadline)?;
        Ok(self.add(&sums))
    }

    fn done(&self) -> u64 {
        self.rounds.paths() / u64::from(self.replicates)
    }

    fn relative_error(&self) -> Option<f64> {
        match self.setup.lit {
            Some(lit) => self.rounds.error_relative_to(lit, &self.setup.target),
            None => self.rounds.relative_error(),
        }
    }

    fn is_dark(&self) -> bool {
        self.setup.light.is_empty()
    }
}

/// Refuses settings that are out of range.
pub(in crate::reference) fn check(settings: &PhotonSettings) -> Result<(), SettingError> {
    let depth = settings.chains.max_depth;
    if depth as usize > MAX_EVENTS {
        let allowed = format!("0 to {MAX_EVENTS} specular events");
        return Err(SettingError::value(
            "max-depth",
            &depth.to_string(),
            allowed,
        ));
    }
    // 255 replicates fit the squares of the exact sums with all light in one texel.
    if !(1..=255).contains(&settings.replicates) {
        let replicates = settings.replicates.to_string();
        return Err(SettingError::value("replicates", &replicates, "1 to 255"));
    }
    if settings.max_layers > 1024 {
        let layers = settings.max_layers.to_string();
        return Err(SettingError::value("layers", &layers, "0 to 1024"));
    }
    Ok(())
}

/// Refuses emitters so strong or so faint that their flux has no fixed-point scale.
pub(in crate::reference) fn check_flux(light: &LightSpace) -> Result<(), SettingError> {
    let flux = light.flux_bound().max_channel();
    match FixedPoint::for_total(flux) {
        Ok(_) => Ok(()),
        Err(_) => Err(SettingError::value(
            "the flux of all emitters",
            &format!("{flux:e} W"),
            "0 and 1e-250 W to 1e250 W",
        )),
    }
}

/// Numbers that keep the streams of the pilot, of the replicates and of those that aim apart.
const PILOT: u64 = 1;
const REPLICATES: u64 = 2;
const AIM: u64 = 3;

/// Measures what falls on a sensor.
///
/// # Errors
///
/// If the settings or the scene do not allow it, or photon contributions are not representable.
pub fn run(
    scene: &Scene,
    sensor: &Sensor,
    settings: PhotonSettings,
    budget: &Budget,
    progress: &Progress,
) -> Result<Estimate, Error> {
    Setup::new(scene, sensor, settings, progress)?.run(budget)
}
