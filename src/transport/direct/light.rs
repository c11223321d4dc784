//! A view from the receiver towards the emitters.

use glam::{DVec2, DVec3};

use crate::geometry::{SurfacePoint, TraversalCounters};
use crate::scene::Scene;
use crate::transport::domain::normal_light::NormalLight;
use crate::transport::receiver::{Receiver, ReceiverPatch};
use crate::transport::visibility::transmittance;

/// A view from the receiver towards the emitters, with the work that it took.
pub(super) struct DirectLight<'a> {
    pub(super) scene: &'a Scene,
    pub(super) receiver: &'a Receiver,
    /// Tells when to give up; values measured after that are thrown away.
    pub(super) stop: &'a (dyn Fn() -> bool + Sync),
    /// The surface that bounds the light of an emitter without a size, if there is one.
    pub(super) part: Option<&'a NormalLight>,
    pub(super) counters: TraversalCounters,
}

impl DirectLight<'_> {
    /// The receiver at fractions `at` across a texel; `None` if it has no surface there.
    pub(super) fn patch(&self, texel: usize, at: DVec2) -> Option<ReceiverPatch> {
        self.receiver.patch(self.scene, texel, at)
    }

    /// The share of light that reaches `point` along `-towards` past null surfaces and masks.
    pub(super) fn transmittance(
        &mut self,
        point: &SurfacePoint,
        towards: DVec3,
        distance: f64,
    ) -> f64 {
        transmittance(self.scene, point, towards, distance, &mut self.counters)
    }
}
