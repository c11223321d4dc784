//! Real-time techniques: pipelines of named stages, each of which has an exact twin.
//!
//! An [`Approximation`] fills a sensor, as a reference does, but by a published technique with its errors. Its
//! stages can be made exact one by one ([`Approximation::with_exact`]): what error goes with a stage is that stage's. Each run counts the work of
//! every stage ([`Work`]), which whoever writes for another device can map to it.
//!
//! | file | what |
//! |---|---|
//! | [`stage`] | stages by name, settings by text, work |
//! | [`sensor`] | a field of irradiance on a sensor's texels |
//! | [`error`] | what cannot be run, and why |
//! | [`caustic_map`] | Wyman and Davis 2006; Wyman and Dachsbacher 2006 |
//!
//! Nothing here knows the references, which judge it: see `study`.

pub mod caustic_map;
pub mod error;
pub mod sensor;
pub mod stage;

use crate::radiometry::Rgb;
use crate::scene::{Scene, Sensor};
use crate::transport::signature::Signature;

pub use crate::setting::SettingError;
pub use caustic_map::CausticMap;
pub use error::ApproximationError;
pub use sensor::{IrradianceField, SensorFilm};
pub use stage::{Stage, StageWork, Work};

/// A technique with its settings.
pub trait Approximation: Clone + Send + Sync {
    /// The technique's name, as on the command line.
    fn name(&self) -> &'static str;

    /// Its stages in the order in which they run.
    fn stages(&self) -> Vec<Stage>;

    /// All settings, as [`set`](Self::set) takes them.
    fn settings(&self) -> Vec<(&'static str, String)>;

    /// Changes one setting.
    ///
    /// # Errors
    ///
    /// For a key that is none, and for a value that it cannot have.
    fn set(&mut self, key: &str, value: &str) -> Result<(), SettingError>;

    /// The same technique with one stage exact.
    ///
    /// # Errors
    ///
    /// For a name that is none of [`stages`](Self::stages).
    fn with_exact(&self, stage: &str) -> Result<Self, SettingError> {
        let mut changed = self.clone();
        let stages = self.stages();
        let found = stages.iter().find(|one| one.name == stage);
        let found = found.ok_or_else(|| {
            SettingError::unknown("stage", stage, stages.iter().map(|one| one.name))
        })?;
        changed.set(found.name, found.exact)?;
        Ok(changed)
    }

    /// Fills a sensor.
    ///
    /// # Errors
    ///
    /// Where the technique cannot work on this scene, or a setting contradicts it.
    fn run(&self, scene: &Scene, sensor: &Sensor) -> Result<Rendering, ApproximationError>;
}

/// What a technique delivers.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// Texels a row.
    pub width: usize,
    /// Rows, as the sensor counts them.
    pub height: usize,
    /// The only light that the technique models; all other is missing.
    pub signature: Signature,
    /// Texel averages, row by row: irradiance [W/m²] of a receiver, radiance [W/m²/sr] of a camera.
    pub values: Vec<Rgb>,
    /// What each stage did, in order.
    pub work: Vec<StageWork>,
}

impl Rendering {
    /// All stages together.
    pub fn total_work(&self) -> Work {
        self.work
            .iter()
            .fold(Work::default(), |sum, stage| sum + stage.work)
    }

    /// From the start of the first stage to the end of the last \[s\], preparations that a frame does not
    /// repeat left out.
    pub fn seconds(&self) -> f64 {
        self.work.iter().map(|stage| stage.seconds).sum()
    }
}
