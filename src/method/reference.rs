//! The interface of a reference, as the table of methods sees it.

use crate::run::{Budget, Context, Cost, Error, Refusal, Rendering};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values};

/// Facts of a reference that no scene changes.
pub(super) struct About {
    /// The name, as on the command line.
    pub name: &'static str,
    /// One line: the light that it measures, and how.
    pub meaning: &'static str,
    /// The limits of a run, the error and the time first if it has them.
    pub limits: &'static [Setting],
    /// The key of the limit on work; `None` for methods whose work is fixed.
    pub work_key: Option<&'static str>,
    /// All other settings.
    pub settings: &'static [Setting],
    /// True if it fills cameras only.
    pub is_of_cameras: bool,
}

/// A reference: one of the methods that compute the truth.
pub(super) trait Reference: Sync {
    /// Facts that no scene changes.
    fn about(&self) -> &'static About;

    /// True if it traces light of one wavelength where an index depends on it.
    fn follows_dispersion(&self) -> bool {
        false
    }

    /// Refuses scenes and sensors that it cannot work on, without running it.
    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal>;

    /// Memory and counted work of a run.
    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost;

    /// Memory \[bytes\] of a run whose light is that which a pilot finds: at most that of the
    /// [`cost`](Self::cost), and nearer to what it takes.
    ///
    /// # Errors
    ///
    /// As of a run.
    fn pilot(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<u64, Error> {
        Ok(self.cost(scene, sensor, values).bytes)
    }

    /// Fills a sensor.
    fn run(&self, job: &Job) -> Result<Rendering, Error>;
}

/// A run that is asked for.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub scene: &'a Scene,
    pub sensor: &'a Sensor,
    pub values: &'a Values,
    pub budget: &'a Budget,
    pub context: &'a Context,
}
