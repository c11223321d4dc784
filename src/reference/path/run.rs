//! Spending a budget on replicates.

use std::time::{Duration, Instant};

use super::settings::{DEFAULT_SAMPLES, PathSettings};
use super::sums::{RoundSums, Rounds};
use super::tiles::Job;
use super::tracer::shining_shapes;
use crate::numeric::Stream;
use crate::reference::rounds::{self, Schedule};
use crate::run::{Budget, Error, Estimate, Progress, Quantity};
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;
use crate::transport::bsdf::check_colors;
use crate::transport::camera::Camera;
use crate::transport::ledger::Ledger;
use crate::transport::lights::Lights;
use crate::transport::path_class::PathClasses;

/// A run, set up: everything its paths need.
pub struct Setup<'a> {
    scene: &'a Scene,
    settings: PathSettings,
    camera: Camera,
    lights: Lights<'a>,
    shines: Vec<bool>,
    progress: &'a Progress,
}

/// The report of a run beside its image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct PathReport {
    /// Samples a pixel.
    pub samples: u64,
    /// Number of paths that ended because they met 65536 surfaces; light that they had yet to find is
    /// missing.
    pub cut_off: u64,
}

/// Time between two computations of the error so far, which is shown and takes a while.
const SHOW_EVERY: Duration = Duration::from_millis(500);

/// The stream of paths that are timed: a round that no run comes to.
const TIMED: u64 = u64::MAX;

/// The largest number of replicates, as for photons.
const MAX_REPLICATES: u32 = 255;

impl<'a> Setup<'a> {
    /// Checks the settings, the camera, and the colours of all that it may see.
    ///
    /// # Errors
    ///
    /// See [`Error`].
    pub fn new(
        scene: &'a Scene,
        sensor: &Sensor,
        settings: PathSettings,
        progress: &'a Progress,
    ) -> Result<Self, Error> {
        if !(1..=MAX_REPLICATES).contains(&settings.replicates) {
            let replicates = settings.replicates.to_string();
            return Err(SettingError::value("replicates", &replicates, "1 to 255").into());
        }
        if settings.rr_depth == 0 {
            return Err(SettingError::value("rr-depth", "0", "1 and more").into());
        }
        let camera = Camera::of_sensor(sensor)?.within(scene, sensor)?;
        check_colors(scene)?;
        Ok(Self {
            scene,
            settings,
            camera,
            lights: Lights::new(scene),
            shines: shining_shapes(scene),
            progress,
        })
    }

    /// The same for other classes.
    #[must_use]
    pub fn for_classes(mut self, classes: PathClasses) -> Self {
        self.settings.classes = classes;
        self
    }

    /// The time that a replicate of a sample a pixel takes, by a small part of it; `None` if it is more than
    /// `most`.
    pub fn time_of_replicate(&self, most: Duration) -> Option<Duration> {
        let stop = || self.progress.is_stopped();
        let stream = Stream::new(self.settings.stream, self.settings.seed).split(TIMED);
        self.job(stream, 1, &stop, &|_| ()).time(most)
    }

    /// One randomisation.
    fn job<'b>(
        &'b self,
        stream: Stream,
        samples: u64,
        stop: &'b (dyn Fn() -> bool + Sync),
        finished: &'b (dyn Fn(u64) + Sync),
    ) -> Job<'b> {
        Job {
            scene: self.scene,
            lights: &self.lights,
            shines: &self.shines,
            camera: &self.camera,
            settings: &self.settings,
            stream,
            samples,
            stop,
            finished,
        }
    }

    /// Spends the budget and delivers the estimate.
    ///
    /// # Errors
    ///
    /// If a sample is not a finite number.
    pub fn run(&self, budget: &Budget) -> Result<(Estimate, PathReport), Error> {
        self.progress.count_camera_paths();
        let (replicates, most) = self.division(budget.work.unwrap_or(if budget.is_work_only() {
            DEFAULT_SAMPLES
        } else {
            u64::MAX
        }));
        let mut run = Run {
            setup: self,
            replicates,
            rounds: Rounds::new(self.camera.width() * self.camera.height()),
        };
        let schedule = Schedule {
            budget,
            progress: self.progress,
            start: Instant::now(),
            first: 1,
            most,
            hopeless: DEFAULT_SAMPLES.div_ceil(u64::from(replicates)),
            is_in_one: true,
        };
        let incomplete = schedule.spend(&mut run)?;
        let report = PathReport {
            samples: run.rounds.samples(),
            cut_off: run.rounds.cut_off,
        };
        let estimate = self.estimate(&run.rounds, incomplete || run.rounds.samples() == 0);
        Ok((estimate, report))
    }

    /// Number of replicates, and of samples a pixel of each, for a run of `samples`.
    pub fn division(&self, samples: u64) -> (u32, u64) {
        let replicates = u64::from(self.settings.replicates).min(samples.max(1));
        (replicates as u32, samples.max(1) / replicates)
    }

    /// Traces one round; fewer replicates if it is stopped.
    fn round(
        &self,
        rounds: &Rounds,
        number: u64,
        samples: u64,
        replicates: u32,
        deadline: Option<Instant>,
    ) -> Result<RoundSums, Error> {
        let stop = || self.progress.is_over(deadline);
        let finished = |paths: u64| self.progress.add(paths);
        let root = Stream::new(self.settings.stream, self.settings.seed).split(number);
        let mut sums = RoundSums::new(self.camera.width() * self.camera.height());
        let mut shown = Instant::now();
        for replicate in 0..replicates {
            let stream = root.split(u64::from(replicate));
            let job = self.job(stream, samples, &stop, &finished);
            if replicate == 0 {
                let started = self.progress.done();
                self.progress
                    .expect(started + job.paths() * u64::from(replicates));
            }
            let Some(image) = job.trace() else { break };
            sums.add(&image);
            if let Some((count, at)) = sums.not_finite {
                return Err(Error::NotRepresentable(format!(
                    "{count} samples are infinite or not a number, the first at film coordinates ({}, {}): the \
                     scene's numbers are too large or too small to be multiplied",
                    at.x, at.y
                )));
            }
            if rounds.samples() == 0 && shown.elapsed() > SHOW_EVERY {
                shown = Instant::now();
                self.progress.set_relative_error(sums.relative_error());
            }
        }
        Ok(sums)
    }

    fn estimate(&self, rounds: &Rounds, incomplete: bool) -> Estimate {
        let total = rounds.total();
        let (width, height) = (self.camera.width(), self.camera.height());
        let border = 2 * self.camera.sampled_border();
        let sampled = (width + border) * (height + border);
        Estimate {
            quantity: Quantity::Radiance,
            width,
            height,
            layers: rounds.classes(),
            counts: vec![rounds.samples(); width * height],
            ledger: Ledger::default(),
            paths: rounds.samples() * sampled as u64,
            counters: rounds.counters,
            relative_error: rounds.relative_error(),
            incomplete: incomplete || total.is_unknown(),
            total,
        }
    }
}

/// A run under way: its rounds so far.
struct Run<'a, 's> {
    setup: &'a Setup<'s>,
    replicates: u32,
    rounds: Rounds,
}

impl rounds::Rounds for Run<'_, '_> {
    fn trace(&mut self, number: u64, each: u64, deadline: Option<Instant>) -> Result<bool, Error> {
        let round = self
            .setup
            .round(&self.rounds, number, each, self.replicates, deadline)?;
        // One replicate says nothing of its own error: beside earlier rounds it is no use.
        if round.replicates() > 1 || self.rounds.samples() == 0 {
            self.rounds.add(&round, each);
        }
        Ok(round.replicates() == self.replicates)
    }

    fn done(&self) -> u64 {
        self.rounds.samples() / u64::from(self.replicates)
    }

    fn relative_error(&self) -> Option<f64> {
        self.rounds.relative_error()
    }

    fn is_dark(&self) -> bool {
        self.setup.lights.is_empty()
    }
}

/// Measures what a camera sees.
///
/// # Errors
///
/// See [`Error`].
pub fn run(
    scene: &Scene,
    sensor: &Sensor,
    settings: PathSettings,
    budget: &Budget,
    progress: &Progress,
) -> Result<(Estimate, PathReport), Error> {
    Setup::new(scene, sensor, settings, progress)?.run(budget)
}
