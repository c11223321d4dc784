//! Points that shine through an image: randomised quasi-Monte Carlo over a texel.

use super::arriving::unshadowed;
use super::glance::Glance;
use super::light::DirectLight;
use crate::numeric::Stream;
use crate::scene::Emitter;

impl DirectLight<'_> {
    /// Average irradiance of an emitter with an image over a texel, with `each` samples in each replicate.
    ///
    /// The image's texels have edges anywhere: points at fixed places would not tell how wrong they are.
    pub(super) fn image(
        &mut self,
        texel: usize,
        emitter: &Emitter,
        stream: &Stream,
        each: u32,
    ) -> Glance {
        self.sampled(texel, stream, each, |at, point, _| {
            let (irradiance, towards, distance) = unshadowed(point, emitter);
            if irradiance.is_black() {
                return ([0.0; 3], 0.0);
            }
            (irradiance.0, at.transmittance(point, towards, distance))
        })
        .into()
    }
}
