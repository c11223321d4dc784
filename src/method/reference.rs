//! The interface of a reference, as the table of methods sees it.

use crate::run::{Budget, Context, Cost, Error, Refusal, Rendering};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values};

/// A reference: one of the methods that compute the truth.
pub(super) trait Reference: Sync {
    /// The name, as on the command line.
    fn name(&self) -> &'static str;

    /// One line: the light that it measures, and how.
    fn meaning(&self) -> &'static str;

    /// The limits of a run, the error and the time first if it has them.
    fn limits(&self) -> &'static [Setting];

    /// The key of the limit on work; `None` for methods whose work is fixed.
    fn work_key(&self) -> Option<&'static str>;

    /// All other settings.
    fn settings(&self) -> &'static [Setting];

    /// True if a setting has no effect in a scene.
    fn ignores(&self, _scene: &Scene, _key: &str) -> bool {
        false
    }

    /// True if it fills cameras only.
    fn is_of_cameras(&self) -> bool {
        false
    }

    /// Refuses scenes and sensors that it cannot work on, without running it.
    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal>;

    /// Memory and counted work of a run.
    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost;

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
