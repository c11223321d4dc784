//! Settings of a photon run.

use crate::numeric::StreamKind;
use crate::transport::chain::ChainSettings;
use crate::transport::direct::AREA_SAMPLES;

/// Settings of how photons are started, followed and counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct PhotonSettings {
    /// Layout of sample points.
    pub stream: StreamKind,
    /// Seed of all random choices; every seed gives its own, equally good answer.
    pub seed: u64,
    /// Independent randomisations; at least 2 for an error bar, 16 for one worth its name.
    ///
    /// The error bar has `replicates - 1` degrees of freedom: z-scores against it have a
    /// variance of (R - 1) / (R - 3), 1.07 at 32.
    pub replicates: u32,
    /// Settings of chains.
    pub chains: ChainSettings,
    /// Path signatures with a layer of their own; the brightest of a pilot run get one.
    pub max_layers: usize,
    /// Samples of a texel and an area light for their direct light on a receiver, if a shadow's edge is near
    /// or the samples scatter much; otherwise [`AREA_SAMPLES`], which is also the least.
    pub direct_samples: u32,
}

impl Default for PhotonSettings {
    /// 32 replicates of Sobol' points, seed 0, eight layers, direct light by [`AREA_SAMPLES`].
    fn default() -> Self {
        Self {
            stream: StreamKind::Sobol,
            seed: 0,
            replicates: 32,
            chains: ChainSettings::default(),
            max_layers: 8,
            direct_samples: AREA_SAMPLES,
        }
    }
}

/// Photons of a run without any limit: 2²⁴.
pub const DEFAULT_PHOTONS: u64 = 1 << 24;
