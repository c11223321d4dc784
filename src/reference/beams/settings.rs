//! Settings of a beam run.

use std::time::Duration;

use crate::transport::scatter::ShadingNormals;

/// Settings of how beams are followed and counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct BeamSettings {
    /// Specular events after which flux is cut off.
    pub max_depth: u32,
    /// Effect of interpolated normals on flux.
    pub shading_normals: ShadingNormals,
    /// Path signatures with a layer of their own: the brightest.
    pub max_layers: usize,
    /// Independent randomisations, for scenes with area lights; their scatter is the random part of the
    /// error. At least 2.
    pub replicates: u32,
    /// Seed of all random choices, for scenes with area lights.
    pub seed: u64,
}

impl Default for BeamSettings {
    /// 16 events, eight layers; 16 replicates of seed 0.
    fn default() -> Self {
        Self {
            max_depth: 16,
            shading_normals: ShadingNormals::Flux,
            max_layers: 8,
            replicates: 16,
            seed: 0,
        }
    }
}

/// Limits of a run: it ends at the one that comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BeamBudget {
    /// The likely relative error over lit texels.
    pub relative_error: Option<f64>,
    /// Time from the start of the run.
    pub time: Option<Duration>,
    /// Rays, all passes together.
    pub rays: Option<u64>,
}

impl BeamBudget {
    /// The aim of a run without any limit: an error of 0.1 %.
    pub const DEFAULT_ERROR: f64 = 1e-3;

    /// The error to stop at; `None` if only time or rays are limited.
    pub fn target(&self) -> Option<f64> {
        let only_error = self.time.is_none() && self.rays.is_none();
        self.relative_error
            .or_else(|| only_error.then_some(Self::DEFAULT_ERROR))
    }
}
