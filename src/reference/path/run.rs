//! Spending a budget on replicates.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::error::PathError;
use super::settings::{PathBudget, PathSettings};
use super::sums::{RoundSums, Rounds};
use super::tiles::Job;
use super::tracer::shining_shapes;
use crate::numeric::Stream;
use crate::reference::{Estimate, Progress, Quantity};
use crate::scene::{Scene, Sensor};
use crate::transport::bsdf::check_colors;
use crate::transport::camera::Camera;
use crate::transport::ledger::Ledger;
use crate::transport::lights::Lights;

/// A run, set up: everything its paths need.
pub struct Setup<'a> {
    scene: &'a Scene,
    settings: PathSettings,
    camera: Camera,
    lights: Lights<'a>,
    shines: Vec<bool>,
    progress: &'a Progress,
}

/// What there is to know of a run beside its image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct PathReport {
    /// Samples a pixel.
    pub samples: u64,
    /// Paths ended because they met 65536 surfaces: what light they had yet to find is missing.
    pub cut_off: u64,
}

/// How often a round works out its error so far, for whoever watches: it takes a while.
const SHOW_EVERY: Duration = Duration::from_millis(500);

/// Replicates at most, as of photons.
const MAX_REPLICATES: u32 = 255;

impl<'a> Setup<'a> {
    /// Checks the settings, and whether the sensor is a camera and all that it may see is known.
    ///
    /// # Errors
    ///
    /// See [`PathError`].
    pub fn new(
        scene: &'a Scene,
        sensor: &Sensor,
        settings: PathSettings,
        progress: &'a Progress,
    ) -> Result<Self, PathError> {
        if !(1..=MAX_REPLICATES).contains(&settings.replicates) {
            return Err(PathError::Setting {
                name: "the number of replicates",
                value: settings.replicates.into(),
                allowed: "1 to 255",
            });
        }
        if settings.rr_depth == 0 {
            return Err(PathError::Setting {
                name: "the leg from which on roulette may end paths",
                value: 0,
                allowed: "1 and more",
            });
        }
        let camera = Camera::of_sensor(sensor)?;
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

    /// Spends the budget and delivers the estimate.
    ///
    /// With only samples limited there is one round. Otherwise there are several, each of all
    /// replicates with twice the samples of the one before, until the next would not fit.
    ///
    /// # Errors
    ///
    /// Where a sample is not a finite number.
    pub fn run(&self, budget: &PathBudget) -> Result<(Estimate, PathReport), PathError> {
        let start = Instant::now();
        // A time beyond what the clock can tell is no limit.
        let deadline = budget.time.and_then(|time| start.checked_add(time));
        self.progress.count_camera_paths();
        let mut rounds = Rounds::new(self.camera.width() * self.camera.height());
        let incomplete = if budget.is_samples_only() {
            let samples = budget.samples.unwrap_or(PathBudget::DEFAULT_SAMPLES);
            let (replicates, each) = self.division(samples);
            let round = self.round(&rounds, 0, each, replicates, None)?;
            rounds.add(&round, each);
            round.replicates() < replicates
        } else {
            self.rounds(budget, start, deadline, &mut rounds)?
        };
        let report = PathReport {
            samples: rounds.samples(),
            cut_off: rounds.cut_off,
        };
        let estimate = self.estimate(&rounds, incomplete || rounds.samples() == 0);
        Ok((estimate, report))
    }

    /// How many replicates of how many samples a pixel make a run of `samples`.
    pub fn division(&self, samples: u64) -> (u32, u64) {
        let replicates = u64::from(self.settings.replicates).min(samples.max(1));
        (replicates as u32, samples.max(1) / replicates)
    }

    /// Traces rounds until the budget is used up. Returns whether the run was stopped before.
    fn rounds(
        &self,
        budget: &PathBudget,
        start: Instant,
        deadline: Option<Instant>,
        rounds: &mut Rounds,
    ) -> Result<bool, PathError> {
        let (replicates, most) = self.division(budget.samples.unwrap_or(u64::MAX));
        let mut each = 1;
        for number in 0.. {
            let round = self.round(rounds, number, each, replicates, deadline)?;
            let complete = round.replicates() == replicates;
            // One replicate says nothing of its own error: beside earlier rounds it is no use.
            if round.replicates() > 1 || rounds.samples() == 0 {
                rounds.add(&round, each);
            }
            let error = rounds.relative_error();
            self.progress.set_relative_error(error);
            let goal = budget.relative_error;
            let is_good = matches!((error, goal), (Some(error), Some(goal)) if error <= goal);
            if !complete || is_good {
                break;
            }
            // Where nothing shines there is no error to reach.
            let is_hopeless = error.is_none() && rounds.samples() >= PathBudget::DEFAULT_SAMPLES;
            if is_hopeless && budget.time.is_none() {
                return Ok(true);
            }
            let used = rounds.samples() / u64::from(replicates);
            each = (2 * each).min(most - used.min(most));
            if let Some(time) = budget.time {
                each = each.min(fitting(used, start.elapsed(), time));
            }
            if each == 0 {
                break;
            }
        }
        Ok(self.progress.is_stopped())
    }

    /// Traces one round; fewer replicates where it is stopped.
    fn round(
        &self,
        rounds: &Rounds,
        number: u64,
        samples: u64,
        replicates: u32,
        deadline: Option<Instant>,
    ) -> Result<RoundSums, PathError> {
        let stop = || {
            self.progress.is_stopped() || deadline.is_some_and(|deadline| Instant::now() > deadline)
        };
        let finished = |paths: u64| {
            self.progress.paths.fetch_add(paths, Ordering::Relaxed);
        };
        let root = Stream::new(self.settings.stream, self.settings.seed).split(number);
        let mut sums = RoundSums::new(self.camera.width() * self.camera.height());
        let mut shown = Instant::now();
        for replicate in 0..replicates {
            let job = Job {
                scene: self.scene,
                lights: &self.lights,
                shines: &self.shines,
                camera: &self.camera,
                settings: &self.settings,
                stream: root.split(u64::from(replicate)),
                samples,
                stop: &stop,
                finished: &finished,
            };
            if replicate == 0 {
                let started = self.progress.paths.load(Ordering::Relaxed);
                let expected = started + job.paths() * u64::from(replicates);
                self.progress
                    .expected_paths
                    .store(expected, Ordering::Relaxed);
            }
            let Some(image) = job.trace() else { break };
            sums.add(&image);
            if let Some((count, at)) = sums.not_finite {
                return Err(PathError::NotFinite {
                    count,
                    x: at.x,
                    y: at.y,
                });
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

/// How many samples each replicate may take in the time left, at the rate so far: a power of two, which suits Sobol' points.
fn fitting(used: u64, elapsed: Duration, time: Duration) -> u64 {
    let rate = used as f64 / elapsed.as_secs_f64();
    let left = time.saturating_sub(elapsed).as_secs_f64();
    // A round that ends early is of little use.
    let fits = (0.9 * rate * left) as u64;
    fits.checked_ilog2().map_or(0, |log| 1 << log)
}

/// Measures what a camera sees.
///
/// # Errors
///
/// See [`PathError`].
pub fn run(
    scene: &Scene,
    sensor: &Sensor,
    settings: PathSettings,
    budget: &PathBudget,
    progress: &Progress,
) -> Result<(Estimate, PathReport), PathError> {
    Setup::new(scene, sensor, settings, progress)?.run(budget)
}
