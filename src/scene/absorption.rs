//! Light within the media of a scene.

use glam::DVec3;

use super::{MediumId, Scene};
use crate::radiometry::Rgb;

impl Scene {
    /// The share of light, per channel, that is left after `length` \[m\] in a medium.
    #[inline]
    pub fn transmittance(&self, medium: MediumId, length: f64) -> Rgb {
        match medium.index() {
            None => Rgb::WHITE,
            Some(index) => self.media()[index].transmittance(length),
        }
    }

    /// The medium in which light goes on that leaves a surface along `direction`. It stays in `medium` unless
    /// the shape bounds one, as in Mitsuba.
    #[inline]
    pub fn medium_beyond(
        &self,
        shape: u32,
        geometric_normal: DVec3,
        direction: DVec3,
        medium: MediumId,
    ) -> MediumId {
        match self.objects()[shape as usize].boundary {
            None => medium,
            Some(boundary) => boundary.beyond(geometric_normal, direction),
        }
    }
}
