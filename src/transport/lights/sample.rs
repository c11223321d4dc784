//! A sampled direction towards light.

use glam::DVec3;

use crate::radiometry::Rgb;

/// A direction from which light may come to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit vector from the point to the light.
    pub direction: DVec3,
    /// Distance of the light; infinite for parallel light and environments.
    pub distance: f64,
    /// Length of a shadow ray: up to the light but not onto it, with room for rounding.
    pub reach: f64,
    /// Radiance [W/m²/sr] divided by `pdf_solid_angle`, if nothing is in the way. For a delta light it is
    /// irradiance across the direction [W/m²] divided by the probability of the light's choice.
    pub radiance_over_pdf: Rgb,
    /// The density of `direction` [1/sr], the choice of the emitter included. For a delta light it is the
    /// probability of that choice.
    pub pdf_solid_angle: f64,
    /// True if no other sampling can find this light: a delta light, of weight 1.
    pub is_delta: bool,
    /// Index into [`Scene::emitters`](crate::scene::Scene::emitters).
    pub emitter: usize,
}
