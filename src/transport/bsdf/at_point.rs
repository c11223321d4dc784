//! A material at one point of a surface, and its effect on light there.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::layer::{BsdfLayer, LayerList, LayerView};
use super::sample::{BsdfSample, Scattering, Transport, cosine_hemisphere};
use crate::geometry::Frame;
use crate::radiometry::Rgb;

/// The largest number below 1.
const BELOW_ONE: f64 = 1.0f64.next_down();

/// A material at one point of a surface.
#[derive(Clone, Debug)]
pub struct Bsdf<'a> {
    pub(super) geometric_normal: DVec3,
    /// Frame of the shading normal, before any texture turns it.
    pub(super) frame: Frame,
    /// The share that passes without an event.
    pub(super) passed: f64,
    /// What light on the front meets, and on the back, too, unless there is a `back`.
    pub(super) front: LayerList<'a>,
    /// What light on the back of a two-sided surface meets.
    pub(super) back: Option<LayerList<'a>>,
}

impl<'a> Bsdf<'a> {
    /// True if no direction has a density: there are delta lobes and passing light, or nothing at all.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.front.is_delta() && self.back.as_ref().is_none_or(LayerList::is_delta)
    }

    /// True if a path from `wi` meets a rough interface, with the normal of the surface: photons go on there.
    /// They do not from the rough parts of a blend.
    #[inline]
    pub fn is_glossy(&self, wi: DVec3) -> bool {
        let layers = self.layers(wi.dot(self.frame.n));
        let is_met = |it: &BsdfLayer| it.turned.is_none() && it.lobe.is_glossy();
        layers.one().is_some_and(is_met)
    }

    /// The same with black bases below its rough coats: what their facets reflect, alone.
    #[must_use]
    pub fn without_bases(mut self) -> Self {
        self.front.remove_bases();
        if let Some(back) = &mut self.back {
            back.remove_bases();
        }
        self
    }

    /// The share (0..=1) of light that goes straight on without an event: all of it at a null surface, one
    /// minus the opacity at a mask. The panes of `thindielectric` do not count: they are an interface.
    #[inline]
    pub fn passed(&self) -> Rgb {
        Rgb::grey(self.passed)
    }

    /// True if the shading normal and the true one agree on the sides that `wi` and `wo` are on.
    ///
    /// Mitsuba's `ptracer` and this program's photons count only such light. Mitsuba's `path` and
    /// [`eval`](Self::eval) make no such check. Always true if the two normals are one.
    #[inline]
    pub fn is_consistent(&self, wi: DVec3, wo: DVec3) -> bool {
        let agrees = |w: DVec3| w.dot(self.geometric_normal) * w.dot(self.frame.n) > 0.0;
        agrees(wi) && agrees(wo)
    }

    /// f |cos θ| \[1/sr\], the share of light that all lobes with a density scatter per solid angle.
    ///
    /// The cosine is that of `wo` for [`Transport::Radiance`]. For [`Transport::Flux`] the value is the
    /// adjoint (see the [module](super)). In both cases the quantity that a path carries is multiplied by
    /// this value and divided by the density of `wo`. The value is zero, never negative or NaN, for
    /// directions along the surface.
    pub fn eval(&self, wi: DVec3, wo: DVec3, mode: Transport) -> Rgb {
        match mode {
            Transport::Radiance => self.eval_radiance(wi, wo),
            Transport::Flux => self.eval_flux(wi, wo),
        }
    }

    fn eval_radiance(&self, wi: DVec3, wo: DVec3) -> Rgb {
        let [wi, wo] = [wi, wo].map(|w| self.frame.to_local(w));
        let opacity = 1.0 - self.passed;
        let layers = self.layers(wi.z).all().iter();
        let values = layers.map(|it| LayerView::new(it, wi).eval(wo, it.weight * opacity));
        values.fold(Rgb::BLACK, |sum, value| sum + value)
    }

    fn eval_flux(&self, wi: DVec3, wo: DVec3) -> Rgb {
        let arriving = wi.dot(self.geometric_normal).abs();
        let leaving = wo.dot(self.geometric_normal).abs();
        let value = self.eval_radiance(wo, wi) * (leaving / arriving);
        // No flux arrives along the surface.
        if value.is_finite() { value } else { Rgb::BLACK }
    }

    /// The density [1/sr] with which [`sample`](Self::sample) chooses `wo` from the lobes that have one.
    ///
    /// Its integral over the sphere is the probability that `sample` chooses such a lobe. That is below 1 if
    /// there are delta lobes or passing light beside it, or if some choices lead nowhere.
    ///
    /// Both transports sample alike, except for flux if a texture turns the normal, or at a thin sheet:
    /// [`BsdfSample::pdf_solid_angle`] is always the density of the sample.
    pub fn pdf_solid_angle(&self, wi: DVec3, wo: DVec3) -> f64 {
        let [wi, wo] = [wi, wo].map(|w| self.frame.to_local(w));
        let opacity = 1.0 - self.passed;
        let layers = self.layers(wi.z).all().iter();
        layers
            .map(|it| LayerView::new(it, wi).pdf(wo, it.weight * opacity))
            .sum()
    }

    /// A direction to go on along; `None` if the path ends.
    ///
    /// `u` are uniform in [0, 1): the first chooses among the lobes, the others a direction. The mean of the
    /// weights, with zero for `None`, is the albedo of the surface as seen along `wi`.
    pub fn sample(&self, wi: DVec3, u: [f64; 3], mode: Transport) -> Option<BsdfSample> {
        let opacity = 1.0 - self.passed;
        if u[0] >= opacity {
            return Some(BsdfSample {
                wo: -wi,
                weight: Rgb::WHITE,
                pdf_solid_angle: self.passed,
                is_delta: true,
                eta: 1.0,
                scattering: Scattering::Passed,
            });
        }
        let u = [(u[0] / opacity).min(BELOW_ONE), u[1], u[2]];
        let local = self.frame.to_local(wi);
        match mode {
            Transport::Radiance => self.sample_radiance(wi, local, u).map(|(sample, _)| sample),
            Transport::Flux if self.has_gaps(local) => self.sample_flux_all_round(wi, local, u),
            Transport::Flux => {
                let (sample, view) = self.sample_radiance(wi, local, u)?;
                let weight = if sample.is_delta {
                    self.adjoint_weight(&view, wi, &sample)?
                } else {
                    self.eval_flux(wi, sample.wo) / sample.pdf_solid_angle
                };
                Some(BsdfSample { weight, ..sample })
            }
        }
    }

    /// True if light from `local`, in the shading frame, goes on along directions to which no sample for
    /// radiance leads: see [`Self::sample_flux_all_round`].
    fn has_gaps(&self, local: DVec3) -> bool {
        let mut layers = self.layers(local.z).all().iter();
        layers.any(|it| it.turned.is_some() && !it.lobe.is_delta() || it.lobe.is_lopsided())
    }

    /// A direction, and the layer that sent the path there. `local` is `wi` in the shading frame.
    fn sample_radiance(
        &self,
        wi: DVec3,
        local: DVec3,
        u: [f64; 3],
    ) -> Option<(BsdfSample, LayerView<'_, 'a>)> {
        let layers = self.layers(local.z);
        let (layer, choice) = layers.choose(u[0]);
        let view = LayerView::new(layer, local);
        let sampled = layer.lobe.sample(view.wi, [choice, u[1], u[2]])?;
        let to = view.leave_lobe(sampled.wo)?;
        let mut sample = BsdfSample {
            wo: self.frame.to_world(to.unmirrored),
            weight: sampled.weight * view.shadowing(&to),
            pdf_solid_angle: sampled.pdf * (layer.weight * (1.0 - self.passed)),
            is_delta: sampled.is_delta,
            eta: sampled.eta,
            scattering: sampled.scattering,
        };
        if layers.one().is_none() && !sample.is_delta {
            // Other layers may send paths there, too.
            sample.pdf_solid_angle = self.pdf_solid_angle(wi, sample.wo);
            if sample.pdf_solid_angle <= 0.0 {
                return None;
            }
            sample.weight = self.eval_radiance(wi, sample.wo) / sample.pdf_solid_angle;
        }
        Some((sample, view))
    }

    /// Samples for flux with a turned normal: half of them as for radiance, half with the cosine's density.
    ///
    /// A turned normal that faces away from the viewer is turned back towards him. So light from `wi` also
    /// goes on to viewers that the normal as seen from `wi` faces away from. That normal never samples them.
    /// Facets of a thin sheet are seen from one end of a path and not from the other, at grazing angles.
    fn sample_flux_all_round(&self, wi: DVec3, local: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let opacity = 1.0 - self.passed;
        let own = 2.0 * u[0];
        let mut sample = if own < 1.0 {
            let (mut sample, view) = self.sample_radiance(wi, local, [own, u[1], u[2]])?;
            if sample.is_delta {
                sample.weight = self.adjoint_weight(&view, wi, &sample)? * 2.0;
                sample.pdf_solid_angle *= 0.5;
                return Some(sample);
            }
            sample
        } else {
            let mut local = cosine_hemisphere([u[1], u[2]]);
            // Light may leave on either side: the second half of the number is as good as a new one.
            if own < 1.5 {
                local.z = -local.z;
            }
            BsdfSample {
                wo: self.frame.to_world(local),
                weight: Rgb::BLACK,
                pdf_solid_angle: 0.0,
                is_delta: false,
                eta: 1.0,
                scattering: Scattering::Diffuse,
            }
        };
        let cosine = sample.wo.dot(self.frame.n).abs();
        let even = 0.5 * opacity * FRAC_1_PI * cosine;
        sample.pdf_solid_angle = 0.5 * (self.pdf_solid_angle(wi, sample.wo) + even);
        if sample.pdf_solid_angle <= 0.0 {
            return None;
        }
        sample.weight = self.eval_flux(wi, sample.wo) / sample.pdf_solid_angle;
        Some(sample)
    }

    /// A delta lobe's weight for flux, given that for radiance; `None` for light along the true surface.
    ///
    /// With c the cosines in the lobe's frame, the factor is η² |cᵢ wo·n| / |cₒ wi·n|. The bumps' shadow is
    /// that of the path the other way round.
    fn adjoint_weight(&self, view: &LayerView, wi: DVec3, sample: &BsdfSample) -> Option<Rgb> {
        let n = self.geometric_normal;
        let wo = self.frame.to_local(sample.wo);
        let to = view.to_lobe(wo)?;
        let veach = (view.wi.z * sample.wo.dot(n)) / (to.wo.z * wi.dot(n));
        let back = LayerView::new(view.layer, wo);
        let shadowing = back.shadowing_of(self.frame.to_local(wi)) / view.shadowing(&to);
        let factor = sample.eta * sample.eta * veach.abs() * shadowing;
        (factor.is_finite() && factor > 0.0).then(|| sample.weight * factor)
    }

    /// The layers that a path meets from a direction with this height over the shading plane.
    #[inline]
    fn layers(&self, height: f64) -> &LayerList<'a> {
        match &self.back {
            Some(back) if height < 0.0 => back,
            _ => &self.front,
        }
    }
}
