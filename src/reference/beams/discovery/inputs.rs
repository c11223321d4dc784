//! The inputs that all parts of a discovery share.

use super::places::{StartPlace, places_of};
use crate::reference::beams::light::BeamLight;
use crate::scene::Scene;
use crate::transport::fixed_signature::PathFollower;
use crate::transport::scatter::ShadingNormals;
use crate::transport::screen::Screen;
use crate::transport::signature::Signature;

/// Number of places, about, on all first surfaces.
pub(super) const PLACES: usize = 1 << 12;

/// Least number of places on each shape, all lights together: a small thing beside a large mesh has its own.
const LEAST_PLACES: usize = 1 << 7;

/// The inputs of a discovery.
pub struct DiscoveryInputs<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// All light that meets a specular surface first.
    pub lights: &'a [BeamLight],
    /// The sensor's film.
    pub screen: &'a Screen<'a>,
    /// Specular events after which flux is cut off.
    pub max_depth: u32,
    /// Effect of interpolated normals on flux.
    pub shading_normals: ShadingNormals,
}

impl DiscoveryInputs<'_> {
    /// A follower of one light. Its signature has no effect on
    /// [`follow_some`](PathFollower::follow_some).
    pub(super) fn follower(&self, light: usize, signature: Signature) -> PathFollower<'_, 3> {
        let source = &self.lights[light].source;
        PathFollower::new(
            self.scene,
            source,
            self.screen,
            signature,
            self.shading_normals,
        )
    }

    /// Places on the first surfaces of one light, of about `count` for all lights.
    pub(super) fn places(&self, light: usize, count: usize) -> Vec<StartPlace> {
        let lights = self.lights.len();
        let (each, least) = (count.div_ceil(lights), LEAST_PLACES / lights);
        places_of(self.scene, &self.lights[light], each, least)
    }
}
