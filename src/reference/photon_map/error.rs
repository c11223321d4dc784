//! Why photon maps cannot be made.

use crate::reference::photons::RunError;
use crate::reference::photons::sums::SumsError;

/// Why a run of photon maps cannot start or came to nothing.
#[derive(Debug, thiserror::Error)]
pub enum PhotonMapError {
    /// As for photons.
    #[error(transparent)]
    Photons(#[from] RunError),
    /// The sums are worth nothing.
    #[error(transparent)]
    Sums(#[from] SumsError),
    /// Some contribution is not a number that the film can hold.
    #[error("{count} contributions to pixels are NaN, infinite or out of range")]
    NotRepresentable {
        /// How many, of one pass.
        count: u64,
    },
    /// The sensor is no camera.
    #[error(
        "sensor \"{id}\" is an irradiancemeter: photon maps are for cameras; on a receiver photons are counted \
         in texels, without bias"
    )]
    NotACamera {
        /// The sensor.
        id: String,
    },
    /// The search tree refuses its points.
    #[error("a photon map of {photons} photons cannot be built: {reason}")]
    Tree {
        /// How many.
        photons: usize,
        /// In the crate's words.
        reason: String,
    },
}
