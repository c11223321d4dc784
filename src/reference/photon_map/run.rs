//! Spending a budget on photon maps.

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::error::PhotonMapError;
use super::finish::{PhotonMapReport, Rounds};
use super::gather::Pass;
use super::map::{Catch, PhotonMap, scattering_shapes};
use super::pilot::Pilot;
use super::settings::{MAX_MAP_PHOTONS, PhotonMapSettings, Seen, radius_squared_factor};
use super::sums::RoundSums;
use crate::numeric::Stream;
use crate::reference::photons::layers::{LayerMap, PILOT_PHOTONS};
use crate::reference::photons::replicate::Job;
use crate::reference::photons::run::{check, check_flux, refused};
use crate::reference::photons::{Budget, RunError};
use crate::reference::{Estimate, Progress, Target};
use crate::scene::{Scene, Sensor};
use crate::transport::camera::Camera;
use crate::transport::domain::LightSpace;

/// A run, set up.
pub struct Setup<'a> {
    pub(super) scene: &'a Scene,
    pub(super) settings: PhotonMapSettings,
    pub(super) target: Target,
    pub(super) light: LightSpace,
    pub(super) map: LayerMap,
    /// By shape.
    pub(super) scatters: Vec<bool>,
    progress: &'a Progress,
}

/// Streams of different use are kept apart by these.
const PILOT: u64 = 1;
const PHOTONS: u64 = 2;
const PIXELS: u64 = 3;

impl<'a> Setup<'a> {
    /// Checks the settings, finds where light can meet specular geometry, and which path signatures are bright
    /// enough for a layer of their own: of all light that they bring to scattering surfaces, seen or not.
    ///
    /// # Errors
    ///
    /// Where a setting is out of range, the sensor is no camera or an emitter is not modelled.
    pub fn new(
        scene: &'a Scene,
        sensor: &Sensor,
        settings: PhotonMapSettings,
        progress: &'a Progress,
    ) -> Result<Self, PhotonMapError> {
        check(&settings.photons)?;
        let limits = [
            ("the radius in pixels", settings.radius, 1e-6..=1e6),
            ("alpha", settings.alpha, 1e-3..=1.0),
        ];
        for (name, value, range) in limits {
            if !range.contains(&value) {
                let allowed = format!("{} to {}", range.start(), range.end());
                refused(name, value.to_string(), allowed)?;
            }
        }
        if !(1..=MAX_MAP_PHOTONS).contains(&settings.map_photons) {
            let allowed = format!("1 to {MAX_MAP_PHOTONS}");
            refused(
                "the number of photons of a map",
                settings.map_photons.to_string(),
                allowed,
            )?;
        }
        let target = Target::new(scene, sensor, settings.photons.chains.shading_normals)
            .map_err(RunError::from)?;
        if matches!(target, Target::Receiver(_)) {
            return Err(PhotonMapError::NotACamera {
                id: sensor.id.clone(),
            });
        }
        let light = LightSpace::new(scene).map_err(RunError::from)?;
        check_flux(&light)?;
        let mut setup = Self {
            scene,
            settings,
            target,
            light,
            map: LayerMap::new(Vec::new()),
            scatters: scattering_shapes(scene),
            progress,
        };
        setup.map = setup.pilot();
        Ok(setup)
    }

    /// Where photons start.
    pub fn light(&self) -> &LightSpace {
        &self.light
    }

    /// The camera.
    pub(super) fn camera(&self) -> Option<&Camera> {
        match &self.target {
            Target::Camera { camera, .. } => Some(camera),
            Target::Receiver(_) => None,
        }
    }

    /// How many layers are measured.
    pub(super) fn layers(&self) -> usize {
        let kinds = if self.settings.seen == Seen::Anyhow {
            2
        } else {
            1
        };
        kinds * self.map.len()
    }

    /// The first layer of what is seen directly, or not.
    #[inline]
    pub(super) fn first_layer(&self, by_specular: bool) -> usize {
        if by_specular && self.settings.seen == Seen::Anyhow {
            self.map.len()
        } else {
            0
        }
    }

    /// Layers for the signatures that bring most flux to scattering surfaces.
    fn pilot(&self) -> LayerMap {
        let stop = || self.progress.is_stopped();
        let job = self.job(self.stream(PILOT), &stop);
        let scale = job.scale(1.0);
        let found = job.trace(PILOT_PHOTONS, || Pilot {
            scatters: &self.scatters,
            scale,
            received: BTreeMap::new(),
        });
        let mut received = BTreeMap::new();
        for task in found {
            for (signature, flux) in task.recipient.received {
                *received.entry(signature).or_insert(0_i128) += flux;
            }
        }
        LayerMap::of_brightest(received, self.settings.photons.max_layers)
    }

    fn stream(&self, purpose: u64) -> Stream {
        let photons = &self.settings.photons;
        Stream::new(photons.stream, photons.seed).split(purpose)
    }

    pub(super) fn pixel_stream(&self) -> Stream {
        self.stream(PIXELS)
    }

    pub(super) fn job<'b>(
        &'b self,
        stream: Stream,
        stop: &'b (dyn Fn() -> bool + Sync),
    ) -> Job<'b> {
        Job {
            scene: self.scene,
            light: &self.light,
            chains: self.settings.photons.chains,
            stream,
            stop,
            finished: &|_| (),
        }
    }

    /// Spends the budget and delivers the estimate, and what there is to know of its bias.
    ///
    /// Rounds of all replicates follow each other, each of twice the passes of the one before unless only the
    /// number of photons is limited. Radii go on shrinking from round to round.
    ///
    /// # Errors
    ///
    /// Where contributions are not representable, or a map is too large.
    pub fn run(&self, budget: &Budget) -> Result<(Estimate, PhotonMapReport), PhotonMapError> {
        let start = Instant::now();
        let deadline = budget.time.and_then(|time| start.checked_add(time));
        let each_pass = self.settings.map_photons * u64::from(self.settings.photons.replicates);
        let photons = budget.photons.unwrap_or(if budget.is_photons_only() {
            Budget::DEFAULT_PHOTONS
        } else {
            u64::MAX
        });
        let most = (photons / each_pass).max(1);
        let mut rounds = Rounds::new(self);
        let mut passes = if budget.is_photons_only() { most } else { 1 };
        let mut is_stopped = false;
        loop {
            let expected = (rounds.passes() + passes).saturating_mul(each_pass);
            self.progress
                .expected_paths
                .store(expected, Ordering::Relaxed);
            let Some(sums) = self.round(rounds.passes(), passes, deadline)? else {
                is_stopped = self.progress.is_stopped();
                break;
            };
            rounds.add(&sums);
            let error = rounds.relative_error();
            self.progress.set_relative_error(error);
            let is_good =
                matches!((error, budget.relative_error), (Some(e), Some(goal)) if e <= goal);
            let is_hopeless = error.is_none() && rounds.paths() >= Budget::DEFAULT_PHOTONS;
            passes = (2 * passes).min(most - rounds.passes());
            if let Some(time) = budget.time {
                let rate = rounds.passes() as f64 / start.elapsed().as_secs_f64();
                let left = time.saturating_sub(start.elapsed()).as_secs_f64();
                passes = passes.min((0.9 * rate * left) as u64);
            }
            if is_good || passes == 0 || is_hopeless || self.light.is_empty() {
                break;
            }
        }
        let is_empty = rounds.passes() == 0 && !self.light.is_empty();
        Ok(rounds.estimate(is_stopped || is_empty))
    }

    /// All replicates of `passes` passes after the first `before`; `None` where it was stopped.
    fn round(
        &self,
        before: u64,
        passes: u64,
        deadline: Option<Instant>,
    ) -> Result<Option<RoundSums>, PhotonMapError> {
        let stop = || {
            self.progress.is_stopped() || deadline.is_some_and(|deadline| Instant::now() > deadline)
        };
        let (Some(camera), Target::Camera { etendue, .. }) = (self.camera(), &self.target) else {
            return Ok(None);
        };
        let mut sums = RoundSums::new(self, passes);
        for replicate in 0..u64::from(self.settings.photons.replicates) {
            for pass in before..before + passes {
                let photons = self.stream(PHOTONS).split(replicate).split(pass);
                let job = self.job(photons, &stop);
                let caught = job.trace(self.settings.map_photons, || Catch {
                    scatters: &self.scatters,
                    map: &self.map,
                    positions: Vec::new(),
                    photons: Vec::new(),
                });
                if stop() {
                    return Ok(None);
                }
                for task in &caught {
                    sums.counters += task.counters;
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
                sums.gather(&pass)?;
                self.progress
                    .paths
                    .fetch_add(self.settings.map_photons, Ordering::Relaxed);
            }
            sums.end_replicate()?;
        }
        Ok(Some(sums))
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
) -> Result<(Estimate, PhotonMapReport), PhotonMapError> {
    Setup::new(scene, sensor, settings, progress)?.run(budget)
}
