//! How far a run is.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// The units of work of methods without passes.
const UNITS: [&str; 3] = ["photons", "paths", "texels"];

/// How far a run is, and the wish that it stop: shared between the run and whoever watches it.
///
/// # Example: stop a run from another thread
///
/// ```
/// let progress = nephroid::Progress::default();
/// assert!(!progress.stop(), "nobody had stopped it before");
/// assert!(progress.is_stopped());
/// ```
#[derive(Debug, Default)]
pub struct Progress {
    /// Photons or camera paths finished; of beams the pieces of light space that the pass has done.
    done: AtomicU64,
    /// The number that `done` is expected to come to; 0 while unknown.
    expected: AtomicU64,
    /// The pass of beams under way, from 1; 0 for other methods, and before the first.
    passes: AtomicU64,
    /// The place of the unit of work in [`UNITS`], for methods without passes.
    unit: AtomicUsize,
    /// Bits of the relative error so far; zero while unknown.
    relative_error: AtomicU64,
    /// Milliseconds that the run is likely to take; zero while unknown.
    forecast: AtomicU64,
    stopped: AtomicBool,
}

impl Progress {
    /// Ends the run soon, with the result so far. Returns true if it was stopped already.
    pub fn stop(&self) -> bool {
        self.stopped.swap(true, Ordering::Relaxed)
    }

    /// True if the run is to end.
    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// True if the run is to end, or beyond its deadline.
    pub(crate) fn is_over(&self, deadline: Option<Instant>) -> bool {
        self.is_stopped() || deadline.is_some_and(|deadline| Instant::now() > deadline)
    }

    /// Work done, in the [`unit`](Self::unit).
    ///
    /// # Example: a percentage
    ///
    /// ```
    /// # use nephroid::{Budget, Context, Method};
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = Method::new("photons", &Default::default())?;
    /// # let context = Context::default();
    /// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &context)?;
    /// // Another thread can ask while the run goes on.
    /// let progress = &context.progress;
    /// if let Some(expected) = progress.expected() {
    ///     println!("{} of {expected} {}", progress.done(), progress.unit());
    /// }
    /// assert_eq!((progress.done(), progress.unit()), (4096, "photons"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// The number that [`done`](Self::done) is expected to come to; `None` while unknown.
    pub fn expected(&self) -> Option<u64> {
        let expected = self.expected.load(Ordering::Relaxed);
        (expected > 0).then_some(expected)
    }

    /// The unit of work, in the plural: `photons`, `paths`, `texels`, or `patches` of beams.
    pub fn unit(&self) -> &'static str {
        match self.pass() {
            Some(_) => "patches",
            None => UNITS[self.unit.load(Ordering::Relaxed)],
        }
    }

    /// The pass of beams under way, from 1; `None` for other methods.
    #[doc(hidden)]
    pub fn pass(&self) -> Option<u64> {
        let pass = self.passes.load(Ordering::Relaxed);
        (pass > 0).then_some(pass)
    }

    /// The relative error so far; `None` while unknown.
    pub fn relative_error(&self) -> Option<f64> {
        let error = f64::from_bits(self.relative_error.load(Ordering::Relaxed));
        (error > 0.0).then_some(error)
    }

    /// Time that the run is likely to take, from its first pass on; `None` while unknown. Beams without a
    /// limit know it before that pass.
    #[doc(hidden)]
    pub fn forecast(&self) -> Option<Duration> {
        let milliseconds = self.forecast.load(Ordering::Relaxed);
        (milliseconds > 0).then(|| Duration::from_millis(milliseconds))
    }

    /// Begins the next of several runs, or of several methods that make one estimate.
    pub(crate) fn begin_part(&self) {
        for counter in [&self.done, &self.expected, &self.passes] {
            counter.store(0, Ordering::Relaxed);
        }
        self.unit.store(0, Ordering::Relaxed);
        self.set_relative_error(None);
        self.set_forecast(None);
    }

    /// Begins a pass of beams over so many pieces of light space.
    pub(crate) fn begin_pass(&self, patches: u64) {
        self.done.store(0, Ordering::Relaxed);
        self.expect(patches);
        self.passes.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts paths from a camera from now on.
    pub(crate) fn count_camera_paths(&self) {
        self.unit.store(1, Ordering::Relaxed);
    }

    /// Counts texels of layers from now on.
    pub(crate) fn count_texels(&self) {
        self.unit.store(2, Ordering::Relaxed);
    }

    /// Sets the number that work is expected to come to.
    pub(crate) fn expect(&self, expected: u64) {
        self.expected.store(expected, Ordering::Relaxed);
    }

    /// Expects so much work beside what is done.
    pub(crate) fn expect_more(&self, work: u64) {
        self.expect(self.done().saturating_add(work));
    }

    /// Adds finished work.
    pub(crate) fn add(&self, work: u64) {
        self.done.fetch_add(work, Ordering::Relaxed);
    }

    pub(crate) fn set_forecast(&self, time: Option<Duration>) {
        let milliseconds = time.map_or(0, |time| {
            u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
        });
        self.forecast.store(milliseconds, Ordering::Relaxed);
    }

    pub(crate) fn set_relative_error(&self, error: Option<f64>) {
        self.relative_error
            .store(error.unwrap_or(0.0).to_bits(), Ordering::Relaxed);
    }
}
