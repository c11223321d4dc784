//! Settings of a probe.

use crate::transport::scatter::ShadingNormals;

/// How far paths are followed and how closely light is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ProbeSettings {
    /// Specular events after which light is cut off, at most [`MAX_EVENTS`].
    pub max_depth: u32,
    /// What interpolated normals do to flux.
    pub shading_normals: ShadingNormals,
    /// How often every cell of light space is divided before anything is decided.
    pub first_level: u32,
    /// Rays after which no more patches are divided.
    pub max_rays: u64,
}

impl Default for ProbeSettings {
    /// 16 events, cells as they are, 2²⁵ rays (some seconds): more than a search away from foci takes in
    /// most scenes, as 2²⁴·³ in the shipped `glass-ball` where three sheets of light meet.
    fn default() -> Self {
        Self {
            max_depth: 16,
            shading_normals: ShadingNormals::Flux,
            first_level: 0,
            max_rays: 1 << 25,
        }
    }
}
