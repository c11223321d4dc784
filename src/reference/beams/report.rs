//! The report of a run.

use super::pass::SignatureReport;

/// The report of a run beside its estimate.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct BeamReport {
    /// One entry a signature followed, the brightest first.
    pub signatures: Vec<SignatureReport>,
    /// Number of passes; the last one that made a layer anew is its result.
    pub passes: u32,
    /// Misplaced flux that a cell of the finest layer may have, relative to the flux on the film.
    pub relative_tolerance: f64,
    /// Flux \[W\] of signatures too dim to be followed, as found by the discovery: in the upper bounds
    /// of the total, in no layer.
    pub not_followed: f64,
    /// True if the first pass was ended because it took many times its forecast.
    pub gave_up: bool,
    /// The light that photons measured, if they measured any.
    pub by_photons: Option<PhotonReport>,
}

/// The light that photons measured in the place of beams.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PhotonReport {
    /// Number of photons.
    pub photons: u64,
    /// Signatures that the discovery found and beams did not follow. There may be more.
    pub signatures: Vec<String>,
    /// Standard error over lit texels, relative to all light by way of mirrors and glass.
    pub relative_error: Option<f64>,
}
