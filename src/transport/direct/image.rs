//! Light that sends one ray to each point and has a pattern: randomised quasi-Monte Carlo over a texel.

use super::arriving::unshadowed;
use super::glance::Glance;
use super::light::DirectLight;
use super::sampled::Sampled;
use crate::numeric::Stream;
use crate::scene::Emitter;
use crate::transport::domain::normal_light::NormalLight;

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
    /// The same for a part that shines along its normals by a texture; `emitter` is that of
    /// [`NormalLight::without_size`]. Beyond the part, its light counts as hidden.
    pub(super) fn patterned(
        &mut self,
        texel: usize,
        (emitter, part): (&Emitter, &NormalLight),
        stream: &Stream,
        each: u32,
    ) -> Sampled<3> {
        self.sampled(texel, stream, each, |at, point, _| {
            let (irradiance, towards, _) = unshadowed(point, emitter);
            match part.meets(point) {
                None => (irradiance.0, 0.0),
                Some(ray) => {
                    let passed = at.transmittance(point, towards, ray.reach);
                    ((irradiance * ray.value).0, passed)
                }
            }
        })
    }
}
