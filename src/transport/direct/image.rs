//! Light that sends one ray to each point and has a pattern: randomised quasi-Monte Carlo over a texel.

use std::cell::Cell;

use super::arriving::unshadowed;
use super::glance::Glance;
use super::light::DirectLight;
use super::sampled::unseen_part;
use super::window::Window;
use crate::numeric::Stream;
use crate::radiometry::Rgb;
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
    ///
    /// Samples may miss what is brightest, and the end of the part. So the error has what the texture's
    /// largest value on the texel may send where no sample is, unless all samples are in a shadow.
    pub(super) fn patterned(
        &mut self,
        texel: usize,
        (emitter, part, window): (&Emitter, &NormalLight, Option<&Window>),
        stream: &Stream,
        each: u32,
    ) -> Glance {
        let most = Cell::new(Rgb::BLACK);
        let exact = window.filter(|it| it.is_exact);
        let peak = part.peak(exact.and_then(|it| it.origins.as_ref()));
        let found = self.sampled(texel, stream, each, |at, point, _| {
            let (irradiance, towards, _) = unshadowed(point, emitter);
            let whole = irradiance * peak;
            most.set(Rgb(std::array::from_fn(|c| {
                most.get().0[c].max(whole.0[c])
            })));
            match part.meets(point) {
                None => (whole.0, 0.0),
                Some(ray) => {
                    let passed = at.transmittance(point, towards, ray.reach);
                    ((irradiance * ray.value).0, passed)
                }
            }
        });
        if found.mean.iter().all(|it| *it == 0.0) {
            let divided = window.filter(|it| it.is_divided());
            let seen = divided.map(|it| self.through(texel, (emitter, part), it).passed);
            if seen.is_none_or(|it| it.most == 0.0) {
                return found.into();
            }
        }
        let missed = |c: usize| {
            let above = (most.get().0[c] - found.mean[c]).max(0.0) * unseen_part(each);
            exact.map_or(above, |it| above.min(most.get().0[c] * it.share))
        };
        let missed = Rgb(std::array::from_fn(missed));
        found.with_missed(missed).into()
    }
}
