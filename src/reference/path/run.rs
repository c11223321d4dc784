//! Spending a budget on replicates.

use std::time::{Duration, Instant};

use super::bands::Bands;
use super::settings::{DEFAULT_SAMPLES, PathSettings};
use super::sums::{RoundSums, Rounds};
use super::tiles::Job;
use super::tracer::shining_shapes;
use crate::numeric::Stream;
use crate::reference::rounds::{self, Schedule};
use crate::reference::shard::Round;
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
    pub(in crate::reference) scene: &'a Scene,
    pub(in crate::reference) settings: PathSettings,
    pub(in crate::reference) camera: Camera,
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
        self.job(self.all_rows(), stream, 1, &stop, &|_| ())
            .time(most)
    }

    fn all_rows(&self) -> Bands {
        Bands::whole(self.camera.height())
    }

    /// One randomisation of some rows.
    fn job<'b>(
        &'b self,
        bands: Bands,
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
            bands,
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
        let (schedule, mut run) = self.begun(budget, Instant::now());
        let incomplete = schedule.spend(&mut run)?;
        Ok(run.estimate(incomplete))
    }

    /// A run that begins, and the schedule by which it spends its budget.
    pub(in crate::reference) fn begun<'b>(
        &'b self,
        budget: &'b Budget,
        start: Instant,
    ) -> (Schedule<'b>, Run<'b, 'a>) {
        let (replicates, most) = self.division(budget.work.unwrap_or(if budget.is_work_only() {
            DEFAULT_SAMPLES
        } else {
            u64::MAX
        }));
        let run = Run {
            setup: self,
            replicates,
            rounds: Rounds::new(self.camera.width() * self.camera.height()),
        };
        let schedule = Schedule {
            budget,
            progress: self.progress,
            start,
            first: 1,
            most,
            hopeless: DEFAULT_SAMPLES.div_ceil(u64::from(replicates)),
            is_in_one: true,
        };
        (schedule, run)
    }

    /// Number of replicates, and of samples a pixel of each, for a run of `samples`.
    pub fn division(&self, samples: u64) -> (u32, u64) {
        let replicates = u64::from(self.settings.replicates).min(samples.max(1));
        (replicates as u32, samples.max(1) / replicates)
    }

    /// Traces a round, of so many samples a pixel and replicate, or some of its rows; fewer replicates if it
    /// is stopped.
    pub(in crate::reference) fn round(
        &self,
        round: Round,
        bands: Bands,
        deadline: Option<Instant>,
    ) -> Result<RoundSums, Error> {
        self.progress.count_camera_paths();
        let stop = || self.progress.is_over(deadline);
        let finished = |paths: u64| self.progress.add(paths);
        let root = Stream::new(self.settings.stream, self.settings.seed).split(round.number);
        let width = self.camera.width();
        let mut sums = RoundSums::new(bands.row_count() * width);
        let mut shown = Instant::now();
        for replicate in 0..round.replicates {
            let stream = root.split(u64::from(replicate));
            let job = self.job(bands, stream, round.each, &stop, &finished);
            if replicate == 0 {
                let paths = job.paths().saturating_mul(round.replicates.into());
                self.progress.expect_more(paths);
            }
            let Some(image) = job.trace() else { break };
            sums.add(&image.of_rows(bands, width));
            if let Some((count, at)) = sums.not_finite {
                return Err(Error::NotRepresentable(format!(
                    "{count} samples are infinite or not a number, the first at film coordinates ({}, {}): the \
                     scene's numbers are too large or too small to be multiplied",
                    at.x, at.y
                )));
            }
            if round.before == 0 && shown.elapsed() > SHOW_EVERY {
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
            paths: rounds.samples().saturating_mul(sampled as u64),
            counters: rounds.counters,
            relative_error: rounds.relative_error(),
            incomplete: incomplete || total.is_unknown(),
            total,
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
    /// Adds a round of so many samples a pixel and replicate. True if it has all replicates.
    pub(in crate::reference) fn add(&mut self, round: &RoundSums, samples: u64) -> bool {
        // One replicate says nothing of its own error: beside earlier rounds it is no use.
        if round.replicates > 1 || self.rounds.samples() == 0 {
            self.rounds.add(round, samples);
        }
        round.replicates == self.replicates
    }

    /// The estimate of all rounds, and the report on them.
    pub(in crate::reference) fn estimate(self, incomplete: bool) -> (Estimate, PathReport) {
        let rounds = self.rounds;
        let report = PathReport {
            samples: rounds.samples(),
            cut_off: rounds.cut_off,
        };
        let incomplete = incomplete || report.samples == 0;
        (self.setup.estimate(&rounds, incomplete), report)
    }
}

impl rounds::Rounds for Run<'_, '_> {
    fn trace(&mut self, number: u64, each: u64, deadline: Option<Instant>) -> Result<bool, Error> {
        let round = Round {
            number,
            replicates: self.replicates,
            each,
            before: self.done(),
        };
        let setup = self.setup;
        let sums = setup.round(round, setup.all_rows(), deadline)?;
        Ok(self.add(&sums, each))
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
