//! The map from light to the receiver point's surroundings.

use glam::DVec2;

use super::settings::ProbeSettings;
use super::target::{ProbeTarget, TargetImage};
use crate::geometry::TraversalCounters;
use crate::scene::Scene;
use crate::transport::differentials::{ChainStep, Follower, Landing, ThinBeam};
use crate::transport::domain::{DeltaEmission, LightSpace};

/// A place in light space: a chart, and coordinates on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightPlace {
    pub chart: usize,
    pub at: DVec2,
}

/// The scene, light, target and settings of one probe.
pub(super) struct LightMap<'a> {
    pub scene: &'a Scene,
    pub light: &'a LightSpace,
    pub target: &'a ProbeTarget,
    pub settings: &'a ProbeSettings,
}

/// The map as one thread traces it.
pub(super) struct MapTracer<'a> {
    map: &'a LightMap<'a>,
    follower: Follower<'a>,
}

impl<'a> LightMap<'a> {
    pub fn new(
        scene: &'a Scene,
        light: &'a LightSpace,
        target: &'a ProbeTarget,
        settings: &'a ProbeSettings,
    ) -> Self {
        Self {
            scene,
            light,
            target,
            settings,
        }
    }

    /// The ray that starts at a place. Only emitters without size are allowed, and that was checked.
    pub fn emission(&self, place: LightPlace) -> Option<DeltaEmission> {
        self.light.charts()[place.chart].delta_emission(place.at)
    }

    pub fn tracer(&'a self) -> MapTracer<'a> {
        self.tracer_to(self.settings.max_depth)
    }

    /// A tracer of fewer events.
    pub fn tracer_to(&'a self, max_depth: u32) -> MapTracer<'a> {
        MapTracer {
            map: self,
            follower: Follower::new(
                self.scene,
                self.target.shape(),
                max_depth,
                self.settings.shading_normals,
            ),
        }
    }
}

impl MapTracer<'_> {
    /// The landings of a place's light, by chain, over all of the Fresnel tree.
    pub fn images(
        &mut self,
        place: LightPlace,
        mut found: impl FnMut(&[ChainStep], TargetImage, &Landing),
    ) {
        let target = self.map.target;
        if let Some(beam) = self.beam(place) {
            self.follower.every_path(&beam, &mut |chain, landing| {
                if let Some(image) = target.image(landing) {
                    found(chain, image, landing);
                }
            });
        }
    }

    /// The first shape that light of a place meets.
    pub fn first_shape(&mut self, place: LightPlace) -> Option<u32> {
        let beam = self.beam(place)?;
        self.follower.first_shape(&beam)
    }

    /// The landing of a place's light by one chain, whatever is in the way.
    pub fn image_along(&mut self, place: LightPlace, chain: &[ChainStep]) -> Option<TargetImage> {
        let beam = self.beam(place)?;
        let landing = self.follower.along(&beam, chain)?;
        self.map.target.image(&landing)
    }

    /// The path of a place's light by one chain through the scene as it is.
    pub fn retrace(
        &mut self,
        place: LightPlace,
        chain: &[ChainStep],
    ) -> Option<(
        Vec<(crate::geometry::Hit, crate::geometry::SurfacePoint)>,
        Landing,
    )> {
        let beam = self.beam(place)?;
        self.follower.retrace(&beam, chain)
    }

    pub fn counters(&self) -> TraversalCounters {
        self.follower.counters
    }

    fn beam(&self, place: LightPlace) -> Option<ThinBeam> {
        let emission = self.map.emission(place)?;
        // Outside a spot's cone there is no light to follow.
        (emission.falloff > 0.0).then(|| ThinBeam::new(&emission))
    }
}
