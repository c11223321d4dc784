//! The interface of a real-time technique.

use std::path::{Path, PathBuf};

use super::Stage;
use crate::film::atomic::WriteError;
use crate::radiometry::Rgb;
use crate::run::{Context, Cost, Counters, Error, FluxEntry, Light, Refusal, StageWork};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values};

/// A setting that says how well exact twins of stages are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Twins {
    /// A relative standard error over the sensor: they take samples until it is reached.
    Error(&'static str),
    /// A number of halvings, from 0 on: each leaves less of an error that is not known beforehand.
    Halvings(&'static str),
}

impl Twins {
    /// The setting's key.
    pub fn key(self) -> &'static str {
        match self {
            Self::Error(key) | Self::Halvings(key) => key,
        }
    }
}

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

    /// The setting that says how well exact twins are known. `None` if they are but for rounding.
    fn twins(&self) -> Option<Twins> {
        None
    }

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

    /// Memory \[bytes\] of a frame with the light that a pilot finds: at most that of the
    /// [`cost`](Self::cost).
    ///
    /// # Errors
    ///
    /// As of a frame.
    fn pilot(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<u64, Error> {
        Ok(self.cost(scene, sensor, values).bytes)
    }

    /// Why a run does not fit into `available` bytes, and what would; `None` if only its film matters.
    fn too_large(
        &self,
        _scene: &Scene,
        _sensor: &Sensor,
        _values: &Values,
        _available: u64,
    ) -> Option<String> {
        None
    }

    /// Refuses settings whose tables do not outlive a frame. A technique without a setting `tables` has none.
    ///
    /// # Errors
    ///
    /// Names what would be kept.
    fn keeps_tables(&self, _values: &Values) -> Result<(), Refusal> {
        Err(Refusal::new(format!(
            "{} makes no tables that outlive a frame",
            self.name()
        )))
    }

    /// Settings whose tables take up to `bytes` and are likely to err least, by pilots. Settings that were
    /// typed stay as they are.
    ///
    /// # Errors
    ///
    /// If the technique makes no tables, or none so small; and as [`prepare`](Self::prepare).
    fn within_bytes(
        &self,
        _scene: &Scene,
        _sensor: &Sensor,
        _values: &Values,
        _bytes: u64,
        _context: &Context,
    ) -> Result<TableChoices, Error> {
        Err(Refusal::new(format!(
            "{} makes no tables of a size to choose",
            self.name()
        ))
        .into())
    }

    /// What a few photons say of the settings, a line each: what they lose in this scene, and what would do
    /// better. Empty if the technique has no such pilot. It is asked of scenes that the technique
    /// [supports](Self::supports).
    ///
    /// # Errors
    ///
    /// If a setting does not suit the scene.
    fn advice(&self, _scene: &Scene, _values: &Values) -> Result<Vec<String>, Error> {
        Ok(Vec::new())
    }

    /// True if a frame of an animation may use what is left of those before it. Otherwise each frame is
    /// prepared anew, as if it were the only one.
    fn keeps_frames(&self, _values: &Values) -> bool {
        false
    }

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

    /// What became of the tables that outlive a frame.
    fn tables(&self) -> TableReport {
        TableReport::default()
    }

    /// Writes these tables for other programs into a folder that is there. Returns the files.
    ///
    /// # Errors
    ///
    /// If a file cannot be written.
    fn export(&self, _scene: &Scene, _folder: &Path) -> Result<Vec<PathBuf>, WriteError> {
        Ok(Vec::new())
    }

    /// Fills a sensor. The scene may be the next of an animation: the one of the preparation with other
    /// places, lights or parameters.
    ///
    /// # Errors
    ///
    /// As [`Technique::prepare`].
    fn frame(&mut self, scene: &Scene, sensor: &Sensor, context: &Context) -> Result<Frame, Error>;
}

/// Tables that outlive a frame: counts and bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TableAccount {
    /// Tables that were made.
    pub made: u64,
    /// Tables that were read from files.
    pub read: u64,
    /// Tables that lack photons, or that were not begun: the run was stopped.
    pub missing: u64,
    /// Files that could not be written.
    pub unwritten: u64,
    /// Bytes of all tables.
    pub bytes: u64,
}

impl TableAccount {
    /// Adds a table that was made.
    pub fn add_made(&mut self, bytes: u64) {
        self.made += 1;
        self.bytes += bytes;
    }

    /// Adds a table that was read.
    pub fn add_read(&mut self, bytes: u64) {
        self.read += 1;
        self.bytes += bytes;
    }
}

/// What became of tables that outlive a frame.
#[derive(Clone, Debug, Default)]
pub struct TableReport {
    /// Counts.
    pub account: TableAccount,
    /// Oddities.
    pub warnings: Vec<String>,
}

/// Settings of tables, with what they take and how much they err.
#[derive(Clone, Debug, PartialEq)]
pub struct TableChoice {
    /// Settings by key.
    pub settings: Vec<(&'static str, String)>,
    /// Bytes of all tables.
    pub bytes: u64,
    /// The likely L1 of an image against one without tables' errors, by its light.
    pub likely: f64,
    /// The same as measured, where it was.
    pub measured: Option<f64>,
}

/// Choices of tables' settings, by their bytes: each is likely to err less than those before.
#[derive(Clone, Debug, PartialEq)]
pub struct TableChoices {
    /// The choices.
    pub front: Vec<TableChoice>,
    /// The number of the one that was asked for.
    pub chosen: usize,
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
