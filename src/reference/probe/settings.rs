//! Settings of a probe.

use crate::transport::scatter::ShadingNormals;

/// Limits of a probe: the depth of its paths, and the fineness and cost of its search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ProbeSettings {
    /// Specular events after which light is cut off, at most
    /// [`MAX_EVENTS`](crate::transport::signature::MAX_EVENTS).
    pub max_depth: u32,
    /// Effect of interpolated normals on flux.
    pub shading_normals: ShadingNormals,
    /// Number of times that every cell of light space is divided before anything is decided.
    pub first_level: u32,
    /// Rays after which no more patches are divided.
    pub max_rays: u64,
}

impl Default for ProbeSettings {
    /// 16 events, undivided cells, 2²⁵ rays (some seconds): more than a search away from foci takes in most
    /// scenes. In the shipped `glass-ball`, where three sheets of light meet, it takes 2²⁴·³.
    fn default() -> Self {
        Self {
            max_depth: 16,
            shading_normals: ShadingNormals::Flux,
            first_level: 0,
            max_rays: 1 << 25,
        }
    }
}
