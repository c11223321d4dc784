//! What a run of all methods is asked to do.

use std::time::Duration;

use crate::reference::beams::{BeamSettings, Chaotic};
use crate::reference::path::PathSettings;
use crate::reference::photon_map::{PhotonMapSettings, Seen};
use crate::reference::photons::PhotonSettings;
use crate::run::Budget;
use crate::transport::followed::Followed;
use crate::transport::path_class::PathClass;
use crate::transport::scatter::ShadingNormals;
use crate::transport::signature::MAX_EVENTS;

/// The settings of all methods, one scene's light in mind.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct FullSettings {
    /// Of paths. Its classes are not looked at: the [plan](super::Plan) says which they are.
    pub path: PathSettings,
    /// Of photons that are connected to the camera.
    pub photons: PhotonSettings,
    /// Of photon maps; which caustics they measure is the plan's.
    pub photon_map: PhotonMapSettings,
    /// Of beams.
    pub beams: BeamSettings,
    /// The most connected photons, and the most photons of maps. The budget's work is samples of paths.
    #[serde(skip)]
    pub most_photons: Option<u64>,
}

impl Default for FullSettings {
    /// Each method's default, made to [agree](FullSettings::agreeing).
    fn default() -> Self {
        Self {
            path: PathSettings::default(),
            photons: PhotonSettings::default(),
            photon_map: PhotonMapSettings::default(),
            beams: BeamSettings::default(),
            most_photons: None,
        }
        .agreeing()
    }
}

/// Seeds of methods are this far apart. The same seed would start the same photons twice, connected and in
/// maps, and errors of one image would not be independent.
const SEED_STEP: u64 = 1 << 62;

impl FullSettings {
    /// The same with what one image asks of all: the depth and the seed of its paths, shading normals that do
    /// to flux what paths from a camera do to radiance, and rough coats left to these paths. Layers are
    /// classes, so that none is given to signatures.
    #[must_use]
    pub fn agreeing(mut self) -> Self {
        let seed = |step: u64| self.path.seed.wrapping_add(step.wrapping_mul(SEED_STEP));
        let light = [
            (&mut self.photons, seed(1)),
            (&mut self.photon_map.photons, seed(2)),
        ];
        let depth = self.path.max_depth.map(|legs| legs.saturating_sub(2));
        for (photons, seed) in light {
            photons.seed = seed;
            photons.max_layers = 0;
            photons.chains.shading_normals = ShadingNormals::Adjoint;
            photons.chains.followed = Followed::Rough;
            if let Some(depth) = depth {
                photons.chains.max_depth = depth.min(MAX_EVENTS as u32);
            }
        }
        // Paths measure what is seen of it.
        self.photon_map.gloss_on_rough = false;
        self.beams = BeamSettings {
            max_depth: self.photons.chains.max_depth,
            shading_normals: ShadingNormals::Adjoint,
            max_layers: 0,
            chaotic: Chaotic::Photons,
            seed: seed(3),
        };
        self
    }

    /// Those of photon maps of a class.
    pub(super) fn map_of(&self, class: PathClass) -> PhotonMapSettings {
        let seen = if class == PathClass::Caustic {
            Seen::Directly
        } else {
            Seen::BySpecular
        };
        let mut settings = PhotonMapSettings {
            seen,
            ..self.photon_map
        };
        if seen == Seen::Directly {
            // Instead of photons that are connected: never the maps of the other class.
            settings.photons.seed = self.photons.seed;
        }
        settings
    }
}

/// The error that beams aim at if nothing limits time or error: 1 %, about what the default numbers of
/// samples come to.
pub const DEFAULT_BEAM_ERROR: f64 = 1e-2;

impl FullSettings {
    /// The limits of the part by paths, for its share of the time.
    pub(super) fn budget_of_paths(budget: &Budget, time: Option<Duration>) -> Budget {
        Budget { time, ..*budget }
    }

    /// The limits of a part by photons or photon maps.
    pub(super) fn budget_of_photons(&self, budget: &Budget, time: Option<Duration>) -> Budget {
        Budget {
            work: self.most_photons,
            time,
            ..*budget
        }
    }

    /// The limits of the part by beams.
    pub(super) fn budget_of_beams(budget: &Budget, time: Option<Duration>) -> Budget {
        let default = time.is_none().then_some(DEFAULT_BEAM_ERROR);
        Budget {
            relative_error: budget.relative_error.or(default),
            time,
            work: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_agree_on_depth_and_normals_and_share_no_random_numbers() {
        let path = PathSettings {
            max_depth: Some(7),
            seed: u64::MAX,
            ..PathSettings::default()
        };
        let settings = FullSettings {
            path,
            ..FullSettings::default()
        }
        .agreeing();
        // L S⁵ D E has six surfaces, and so seven legs.
        assert_eq!(settings.photons.chains.max_depth, 5);
        assert_eq!(settings.photon_map.photons.chains.max_depth, 5);
        assert_eq!(settings.beams.max_depth, 5);
        let directly = settings.map_of(PathClass::Caustic).photons.seed;
        let behind = settings.map_of(PathClass::SeenCaustic).photons.seed;
        assert!(directly != behind && behind != path.seed && directly != path.seed);
        for normals in [
            settings.photons.chains.shading_normals,
            settings.photon_map.photons.chains.shading_normals,
            settings.beams.shading_normals,
        ] {
            assert_eq!(normals, ShadingNormals::Adjoint);
        }
    }

    #[test]
    fn beams_have_an_aim_unless_time_or_error_is_limited() {
        let aim =
            |budget: Budget| FullSettings::budget_of_beams(&budget, budget.time).relative_error;
        assert_eq!(aim(Budget::default()), Some(0.01));
        let timed = Budget::time(Duration::from_secs(1));
        assert_eq!(aim(timed), None);
        assert_eq!(aim(timed.or(Budget::error(0.1))), Some(0.1));
    }
}
