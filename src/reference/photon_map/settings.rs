//! Settings of a run of photon maps.

use crate::reference::photons::PhotonSettings;

/// Settings of how photon maps are made and looked up.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PhotonMapSettings {
    /// Settings of photons, whose replicates' scatter is the standard error.
    pub photons: PhotonSettings,
    /// Photons started for each map: memory grows with it, and nothing else does.
    pub map_photons: u64,
    /// Radius of the first map's look-ups, in pixels of the width at the looked-up point.
    pub radius: f64,
    /// α of [`radius_squared_factor`]: the share of new photons that smaller radii keep, in (0, 1).
    pub alpha: f64,
    /// Caustics that are measured.
    pub seen: Seen,
    /// True if light of rough interfaces counts where it meets another one, too.
    #[serde(skip)]
    pub gloss_on_rough: bool,
}

/// The way in which the camera sees the diffuse surface that a caustic falls on.
///
/// The first two are disjoint, and the third is both: light that is connected to the camera finds paths
/// L S+ D E, the photon map alone L S+ D S+ E.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Seen {
    /// Directly: L S+ D E.
    Directly,
    /// By way of mirrors or glass: L S+ D S+ E.
    BySpecular,
    /// Either.
    Anyhow,
}

impl Seen {
    /// True if paths count, with or without a specular event between camera and diffuse surface.
    #[inline]
    pub fn includes(self, by_specular: bool) -> bool {
        match self {
            Self::Directly => !by_specular,
            Self::BySpecular => by_specular,
            Self::Anyhow => true,
        }
    }
}

impl Default for PhotonMapSettings {
    /// 16 replicates, maps of 2¹⁶ photons, a first radius of one pixel, α = 2/3, and the caustics that no
    /// other method finds.
    fn default() -> Self {
        Self {
            photons: PhotonSettings {
                replicates: 16,
                ..PhotonSettings::default()
            },
            map_photons: 1 << 16,
            radius: 1.0,
            alpha: 2.0 / 3.0,
            seen: Seen::BySpecular,
            gloss_on_rough: true,
        }
    }
}

/// The most maps of a replicate in a run that is made in parts: the radius of the last takes a second to
/// tell.
pub(in crate::reference) const MOST_MAPS: u64 = 1 << 28;

/// The largest map: an index of 32 bits counts its photons, of which each may have many ends.
pub(super) const MAX_MAP_PHOTONS: u64 = 1 << 24;

/// r²ₚ / r²₀ of pass `p`, counted from 0: r²ₚ₊₁ = r²ₚ (p + 1 + α) / (p + 2), dimensionless.
///
/// Knaus and Zwicker, *Progressive Photon Mapping: A Probabilistic Approach* (ACM TOG 30(3), 2011): of
/// independent maps so looked up, the mean's variance falls as n^-α and its bias as n^(α-1). With α = 2/3
/// both parts of the squared error fall alike, as n^(-2/3), which no other schedule betters (Kaplanyan and
/// Dachsbacher, *Adaptive Progressive Photon Mapping*, ACM TOG 32(2), 2013).
pub fn radius_squared_factor(pass: u64, alpha: f64) -> f64 {
    (1..=pass)
        .map(|k| (k as f64 + alpha) / (k as f64 + 1.0))
        .product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_shrink_with_the_sixth_root_of_the_number_of_passes() {
        assert_eq!(radius_squared_factor(0, 2.0 / 3.0), 1.0);
        // The product is Γ(n + 1 + α) / (Γ(1 + α) Γ(n + 2)) ~ n^(α-1): eight times the passes halve r².
        let ratio = radius_squared_factor(8000, 2.0 / 3.0) / radius_squared_factor(1000, 2.0 / 3.0);
        assert!((ratio - 0.5).abs() < 1e-3, "{ratio}");
        // α = 1 keeps the radius, and so the bias.
        assert_eq!(radius_squared_factor(100, 1.0), 1.0);
    }

    #[test]
    fn what_is_seen_directly_and_by_specular_surfaces_is_all_and_disjoint() {
        for by_specular in [false, true] {
            let one = Seen::Directly.includes(by_specular);
            assert!(one != Seen::BySpecular.includes(by_specular));
            assert!(Seen::Anyhow.includes(by_specular));
        }
    }
}
