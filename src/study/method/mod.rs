//! Methods by name, with settings as text.
//!
//! The one place where a study knows how light is computed. A method is a variant of [`Method`]: it is made from
//! `key=value` text, says all its settings as such text, and fills a sensor with a [`Product`]. Keys are the flags of
//! `nephroid render` without their dashes. A further method is a further variant, and a line in [`Method::NAMES`].

pub mod approximations;
pub mod keys;
mod product;
mod references;

use serde_json::Value;

pub use keys::{SettingError, Settings};
pub use product::{Counter, Facts, LedgerRow, LedgerTable, Product, Spread};
pub use references::{Beams, Full, Path, PhotonMap, Photons};

use crate::approximation::{Approximation, ApproximationError, CausticMap, Stage};
use crate::reference::Progress;
use crate::reference::beams::BeamError;
use crate::reference::full::FullError;
use crate::reference::path::PathError;
use crate::reference::photon_map::PhotonMapError;
use crate::reference::photons::RunError;
use crate::scene::{Scene, Sensor};

/// A method with its settings.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// Deterministic beams.
    Beams(Beams),
    /// Photons.
    Photons(Photons),
    /// Paths from a camera.
    Path(Path),
    /// Photon maps.
    PhotonMap(PhotonMap),
    /// All that a camera sees, each class of light paths by the method that finds it best.
    Full(Full),
    /// Caustic maps, an approximation.
    CausticMap(CausticMap),
}

/// Why a method filled no sensor.
#[derive(Debug, thiserror::Error)]
pub enum MethodError {
    /// Beams.
    #[error(transparent)]
    Beams(#[from] BeamError),
    /// Photons.
    #[error(transparent)]
    Photons(#[from] RunError),
    /// Paths.
    #[error(transparent)]
    Path(#[from] PathError),
    /// Photon maps.
    #[error(transparent)]
    PhotonMap(#[from] PhotonMapError),
    /// All methods.
    #[error(transparent)]
    Full(#[from] FullError),
    /// An approximation.
    #[error(transparent)]
    Approximation(#[from] ApproximationError),
}

impl Method {
    /// The names of all methods.
    pub const NAMES: [&str; 6] = [
        "beams",
        "photons",
        "path",
        "photon-map",
        "full",
        "caustic-map",
    ];

    /// The method of a name, with settings; those not given are the defaults of `nephroid render`.
    ///
    /// # Errors
    ///
    /// For a name that is none, a setting that the method does not have, and a value that it cannot have.
    pub fn new(name: &str, settings: &Settings) -> Result<Self, SettingError> {
        Ok(match name {
            "beams" => Self::Beams(Beams::new(settings)?),
            "photons" => Self::Photons(Photons::new(settings)?),
            "path" => Self::Path(Path::new(settings)?),
            "photon-map" => Self::PhotonMap(PhotonMap::new(settings)?),
            "full" => Self::Full(Full::new(settings)?),
            "caustic-map" => Self::CausticMap(approximations::with(settings)?),
            _ => return Err(SettingError::unknown("method", name, Self::NAMES)),
        })
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Beams(_) => "beams",
            Self::Photons(_) => "photons",
            Self::Path(_) => "path",
            Self::PhotonMap(_) => "photon-map",
            Self::Full(_) => "full",
            Self::CausticMap(it) => it.name(),
        }
    }

    /// All its settings, those not given included: runs with the same settings have the same bits.
    pub fn settings(&self) -> Value {
        match self {
            Self::Beams(it) => it.settings(),
            Self::Photons(it) => it.settings(),
            Self::Path(it) => it.settings(),
            Self::PhotonMap(it) => it.settings(),
            Self::Full(it) => it.settings(),
            Self::CausticMap(it) => approximations::settings(it),
        }
    }

    /// The stages of an approximation, in the order in which they run; a reference has none.
    pub fn stages(&self) -> Vec<Stage> {
        match self {
            Self::CausticMap(it) => it.stages(),
            _ => Vec::new(),
        }
    }

    /// Whether it measures on cameras only.
    pub fn is_of_cameras(&self) -> bool {
        matches!(self, Self::Path(_) | Self::PhotonMap(_) | Self::Full(_))
    }

    /// Fills a sensor. Setting `progress.stop` ends it soon, with what there is.
    ///
    /// # Errors
    ///
    /// Where the method cannot work on the scene or the sensor.
    pub fn run(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        progress: &Progress,
    ) -> Result<Product, MethodError> {
        Ok(match self {
            Self::Beams(it) => it.run(scene, sensor, progress)?,
            Self::Photons(it) => it.run(scene, sensor, progress)?,
            Self::Path(it) => it.run(scene, sensor, progress)?,
            Self::PhotonMap(it) => it.run(scene, sensor, progress)?,
            Self::Full(it) => it.run(scene, sensor, progress)?,
            Self::CausticMap(it) => approximations::run(it, scene, sensor)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_makes_the_method_of_that_name() {
        for name in Method::NAMES {
            assert_eq!(Method::new(name, &Settings::new()).unwrap().name(), name);
        }
    }

    #[test]
    fn an_unknown_method_is_refused_and_the_nearest_one_suggested() {
        let error = Method::new("beam", &Settings::new())
            .unwrap_err()
            .to_string();
        assert!(error.contains("did you mean \"beams\"?"), "{error}");
    }
}
