//! The report of a run.

use super::pass::SignatureReport;

/// The report of a run beside its estimate.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct BeamReport {
    /// One entry a signature followed, the brightest first.
    pub signatures: Vec<SignatureReport>,
    /// Number of passes; the last one is the result.
    pub passes: u32,
    /// Misplaced flux that a cell of the last pass may have, relative to the flux on the film.
    pub relative_tolerance: f64,
    /// Flux \[W\] of signatures too dim to be followed, as found by the discovery; in no layer and no bar.
    pub not_followed: f64,
    /// The sampling of area lights, if the scene has any.
    #[serde(rename = "lamps", skip_serializing_if = "Option::is_none")]
    pub area_lights: Option<AreaLightReport>,
}

/// The sampling of area lights in the last pass.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct AreaLightReport {
    /// Places on each light, in each replicate.
    pub points: u64,
    /// Independent randomisations.
    pub replicates: u32,
    /// The two-sided confidence with which bounds hold, as far as they are random.
    pub confidence: f64,
    /// Standard errors by which bounds were widened for it: Student's t with replicates − 1 degrees of
    /// freedom.
    pub standard_errors: f64,
    /// The part of the relative error that the division into cells is likely to have.
    pub deterministic_error: f64,
    /// The part that the random choice of places has: one standard error.
    pub random_error: f64,
}
