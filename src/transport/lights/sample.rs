//! A sampled direction towards light.

use glam::DVec3;

use crate::radiometry::Rgb;

/// A direction from which light may come to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// From the point to the light, a unit vector.
    pub direction: DVec3,
    /// How far away the light is; infinite for parallel light and environments.
    pub distance: f64,
    /// How far a shadow ray goes: up to the light but not onto it, whatever was rounded.
    pub reach: f64,
    /// What the light brings if nothing is in the way: radiance [W/m²/sr] by `pdf_solid_angle`, that is
    /// irradiance across the direction [W/m²] for a delta light, by the probability of its choice.
    pub radiance_over_pdf: Rgb,
    /// The density of `direction` [1/sr], the choice of the emitter included; for a delta light the probability
    /// of that choice.
    pub pdf_solid_angle: f64,
    /// Whether no other sampling can find this light: a delta light, of weight 1.
    pub is_delta: bool,
    /// Index into [`Scene::emitters`].
    pub emitter: usize,
}
