//! The interface of a real-time technique.

use super::Stage;
use crate::radiometry::Rgb;
use crate::run::{Context, Cost, Counters, Error, FluxEntry, Light, Refusal, StageWork};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values};

/// A real-time technique: a pipeline of named stages, each with an exact twin.
///
/// A technique is a folder that implements this, and one line in [`TECHNIQUES`](super::TECHNIQUES). Values
/// are always checked against [`settings`](Self::settings).
pub trait Technique: Sync {
    /// The name, as on the command line.
    fn name(&self) -> &'static str;

    /// One line: the technique and its source.
    fn meaning(&self) -> &'static str;

    /// The unit of a frame's work, in the plural: one of its frames' counters, for the summary.
    fn unit(&self) -> &'static str;

    /// The table of settings. A stage's key chooses its variant.
    fn settings(&self) -> &'static [Setting];

    /// The stages in the order in which they run.
    fn stages(&self) -> &'static [Stage];

    /// The settings of a default study: a key, and its values from coarse to fine.
    fn sweep(&self) -> (&'static str, &'static [&'static str]);

    /// The set of light paths that the technique models in a scene.
    ///
    /// # Errors
    ///
    /// If the scene has none of them.
    fn light(&self, scene: &Scene, values: &Values) -> Result<Light, Refusal>;

    /// Refuses scenes and sensors that the technique cannot work on, without running it.
    ///
    /// # Errors
    ///
    /// Names what the scene lacks, or has too much.
    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal>;

    /// Memory and counted work of a frame and its preparation, before anything is traced.
    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost;

    /// Makes everything that outlives a frame: tables, trees, buffers of what does not change.
    ///
    /// # Errors
    ///
    /// As [`supports`](Self::supports), and if memory, a file or a number does not suffice.
    fn prepare(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        values: &Values,
        context: &Context,
    ) -> Result<Box<dyn Prepared>, Error>;
}

/// A technique that is ready to make frames.
pub trait Prepared: Send {
    /// Work of the preparation, by stage: its cost is apart from a frame's.
    fn work(&self) -> &[StageWork];

    /// Fills a sensor. The scene may be the next of an animation: the one of the preparation with other
    /// places, lights or parameters.
    ///
    /// # Errors
    ///
    /// As [`Technique::prepare`].
    fn frame(&mut self, scene: &Scene, sensor: &Sensor, context: &Context) -> Result<Frame, Error>;
}

/// One frame of a technique.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Texel averages, row by row: irradiance [W/m²] of a receiver, radiance [W/m²/sr] of a camera.
    pub values: Vec<Rgb>,
    /// Work by stage, and by pass if a stage has several, in order.
    pub work: Vec<StageWork>,
    /// Work of the whole frame, in the order of importance.
    pub counters: Counters,
    /// Flux \[W\] from the light to the image, in the order of stages: together what the image has. Empty if
    /// the technique does not account for it.
    pub flux: Vec<FluxEntry>,
    /// Oddities of the frame. A frame without any light says why, with figures, in its first words.
    pub warnings: Vec<String>,
}
