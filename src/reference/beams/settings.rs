//! Settings of a beam run.

use crate::run::Budget;
use crate::setting::words::words;
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
    /// Who measures light that beams would take long for.
    pub chaotic: Chaotic,
    /// Seed of photons that measure some of the light.
    pub seed: u64,
}

words! {
    /// Who measures light of chaotic chains, which beams would take most of their work for.
    Chaotic {
        /// Photons: its bounds hold with their confidence
        Photons = "photons",
        /// Beams, however long that takes
        Beams = "beams",
    }
}

impl Default for BeamSettings {
    /// 16 events, eight layers, chaotic light by photons of seed 0.
    fn default() -> Self {
        Self {
            max_depth: 16,
            shading_normals: ShadingNormals::Flux,
            max_layers: 8,
            chaotic: Chaotic::Photons,
            seed: 0,
        }
    }
}

/// The error that a run without any limit aims at: 0.1 %.
pub const DEFAULT_ERROR: f64 = 1e-3;

/// The likely error to stop at: with a limit on time or rays alone there is none.
pub(super) fn target_error(budget: &Budget) -> Option<f64> {
    let is_unlimited = budget.time.is_none() && budget.work.is_none();
    budget
        .relative_error
        .or_else(|| is_unlimited.then_some(DEFAULT_ERROR))
}
