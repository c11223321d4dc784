//! How a surface scatters light: what a path that starts at a camera needs of every material.
//!
//! A [`Bsdf`] is a material at one point of a surface: textures are looked up, masks are weighed, bump
//! and normal maps have turned the normal. All directions are unit vectors in world space and point
//! *away* from the surface. `wi` is the side a path comes from, `wo` the side it goes on to; which
//! of them light travels along is the meaning of [`Transport`].
//!
//! Light goes on in three ways, kept apart since an estimator can do different things with each:
//!
//! | part | what it is | how it is found |
//! |---|---|---|
//! | [`passed`](Bsdf::passed) | the share that goes straight on, as if nothing were there | [`sample`](Bsdf::sample), or by looking through |
//! | delta lobes | mirror reflection and refraction | [`sample`](Bsdf::sample) only |
//! | the rest | all that has a density over solid angle | [`eval`](Bsdf::eval), [`pdf_solid_angle`](Bsdf::pdf_solid_angle), [`sample`](Bsdf::sample) |
//!
//! The meaning of every parameter is that of Mitsuba 3.9.1, checked against it direction by direction
//! (`tests/scattering/mitsuba_oracle.rs`). In particular everything happens in the *shading* frame: which side a
//! direction is on is asked of the shading normal, as Mitsuba's `path` does. Where that and the true
//! normal disagree, [`Bsdf::is_consistent`] says so: Mitsuba's `ptracer` and this program's photons
//! leave such light out.
//!
//! # Light that travels along `wi`
//!
//! [`Transport::Flux`] is by definition the adjoint of [`Transport::Radiance`]. With n the true normal,
//!
//! ```text
//! eval_flux(wi, wo) = eval_radiance(wo, wi) |wo·n| / |wi·n|
//! ```
//!
//! for this makes what a camera's path and a photon's path count the same integral. The equation
//! holds two well-known rules: radiance that is refracted scales by (nᵢ/nₜ)² and flux does not, and
//! flux at a shading normal s scales by |wi·s wo·n| / |wi·n wo·s| (Veach 1997, 5.2 and 5.3).

mod check;
mod lobe;
mod plastic;
mod resolve;
mod rough;
mod smooth;
mod turned;
mod view;

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use crate::geometry::{Frame, Hit, SurfacePoint};
use crate::radiometry::Rgb;
use crate::scene::Scene;
pub use check::{UnknownColor, check_colors};
use lobe::{Lobe, cosine_hemisphere};
use turned::Turned;
use view::View;

/// The largest number below 1.
const BELOW_ONE: f64 = 1.0f64.next_down();

/// Which quantity a path carries from `wi` to `wo`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Transport {
    /// The path starts at a camera: light travels along it backwards, in through `wo` and out through
    /// `wi`, and its radiance scales by (nᵢ/nₜ)² where it is refracted.
    Radiance,
    /// The path starts at a light: flux arrives from `wi` and leaves towards `wo`.
    Flux,
}

/// What a sampled direction belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scattering {
    /// Straight on, as if nothing were there: no event.
    Passed,
    /// Reflected at an interface, smooth or rough.
    Reflected,
    /// Refracted or passed through an interface, smooth or rough.
    Transmitted,
    /// Scattered by what is below the interface, or by a matt surface.
    Diffuse,
}

/// A direction that a path may go on along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// A unit vector that points away from the surface.
    pub wo: DVec3,
    /// The factor on what the path carries: f |cos θ| / density, or the share by its probability for
    /// delta lobes and passing light.
    pub weight: Rgb,
    /// For directions with a density, that density [1/sr]: for radiance [`Bsdf::pdf_solid_angle`]. For delta
    /// lobes and passing light the probability of the choice.
    pub pdf_solid_angle: f64,
    /// Whether the direction was chosen from finitely many; `eval` knows nothing of those.
    pub is_delta: bool,
    /// `n_transmitted / n_incident` as the path goes, from wi's side to wo's; 1 where it stays on its
    /// side or nothing bends it. Russian roulette on radiance divides it out.
    pub eta: f64,
    /// What happened.
    pub scattering: Scattering,
}

/// A material at one point of a surface.
#[derive(Clone, Debug)]
pub struct Bsdf<'a> {
    geometric_normal: DVec3,
    /// Of the shading normal, before any texture turns it.
    frame: Frame,
    /// The share that passes without an event.
    passed: f64,
    /// What stands on the front; light on the back meets it, too, unless there is a `back`.
    front: Layer<'a>,
    /// What stands on the back of a two-sided surface.
    back: Option<Layer<'a>>,
}

/// A lobe, and the texture that turns its normal, if any.
#[derive(Clone, Copy, Debug)]
struct Layer<'a> {
    lobe: Lobe<'a>,
    turned: Option<Turned>,
}

impl<'a> Bsdf<'a> {
    /// The material that a ray met at `hit`. Colours that are unknown are black: see [`check_colors`].
    ///
    /// `point` must be [`World::surface_point`] of it, for its `uv`.
    ///
    /// [`World::surface_point`]: crate::geometry::World::surface_point
    pub fn at(scene: &'a Scene, hit: &Hit, point: &SurfacePoint) -> Self {
        resolve::at(scene, hit, point)
    }

    /// Whether no direction has a density: there are delta lobes and passing light, or nothing at all.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.front.lobe.is_delta() && self.back.as_ref().is_none_or(|back| back.lobe.is_delta())
    }

    /// The share (0..=1) of light that goes straight on without an event: all of it at a null
    /// surface, one minus the opacity at a mask. The panes of `thindielectric` are an interface, not this.
    #[inline]
    pub fn passed(&self) -> Rgb {
        Rgb::grey(self.passed)
    }

    /// Whether the shading normal and the true one agree on the sides that `wi` and `wo` are on.
    ///
    /// Mitsuba's `ptracer` and this program's photons count only such light; Mitsuba's `path` and
    /// [`eval`](Self::eval) do not ask. Always true where the two normals are one.
    #[inline]
    pub fn is_consistent(&self, wi: DVec3, wo: DVec3) -> bool {
        let agrees = |w: DVec3| w.dot(self.geometric_normal) * w.dot(self.frame.n) > 0.0;
        agrees(wi) && agrees(wo)
    }

    /// f |cos θ| \[1/sr\], the share of light scattered per solid angle: of all lobes with a density.
    ///
    /// For [`Transport::Radiance`] the cosine is that of `wo`, and for [`Transport::Flux`] the value is
    /// the adjoint (see the [module](self)); in both, what a path carries is multiplied by this and
    /// divided by the density of `wo`. Zero, never negative or NaN, for directions along the surface.
    pub fn eval(&self, wi: DVec3, wo: DVec3, mode: Transport) -> Rgb {
        match mode {
            Transport::Radiance => self.eval_radiance(wi, wo),
            Transport::Flux => self.eval_flux(wi, wo),
        }
    }

    fn eval_radiance(&self, wi: DVec3, wo: DVec3) -> Rgb {
        let view = self.view(wi);
        match view.to_lobe(self.frame.to_local(wo)) {
            Some(to) => {
                let shadowing = view.shadowing(&to);
                view.layer.lobe.eval(view.wi, to.wo) * (shadowing * (1.0 - self.passed))
            }
            None => Rgb::BLACK,
        }
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
    /// Its integral over the sphere is the probability that `sample` chooses such a lobe: below
    /// 1 where there are delta lobes or passing light beside it, or where some choices lead nowhere.
    /// Both transports sample alike, but for flux where a texture turns the normal:
    /// [`BsdfSample::pdf_solid_angle`] is always that of the sample.
    pub fn pdf_solid_angle(&self, wi: DVec3, wo: DVec3) -> f64 {
        let view = self.view(wi);
        view.to_lobe(self.frame.to_local(wo)).map_or(0.0, |to| {
            view.layer.lobe.pdf(view.wi, to.wo) * (1.0 - self.passed)
        })
    }

    /// A direction to go on along; `None` where the path ends.
    ///
    /// `u` are uniform in [0, 1): the first chooses among the lobes, the others a direction. The mean of
    /// the weights, those of `None` being zero, is the albedo of the surface as seen along `wi`.
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
        let view = self.view(wi);
        match mode {
            Transport::Radiance => self.sample_radiance(&view, u),
            Transport::Flux if view.is_turned() && !view.layer.lobe.is_delta() => {
                self.sample_turned_flux(&view, wi, u)
            }
            Transport::Flux => {
                let sample = self.sample_radiance(&view, u)?;
                let weight = if sample.is_delta {
                    self.adjoint_weight(&view, wi, &sample)?
                } else {
                    self.eval_flux(wi, sample.wo) / sample.pdf_solid_angle
                };
                Some(BsdfSample { weight, ..sample })
            }
        }
    }

    fn sample_radiance(&self, view: &View, u: [f64; 3]) -> Option<BsdfSample> {
        let sampled = view.layer.lobe.sample(view.wi, u)?;
        let to = view.leave_lobe(sampled.wo)?;
        Some(BsdfSample {
            wo: self.frame.to_world(to.unmirrored),
            weight: sampled.weight * view.shadowing(&to),
            pdf_solid_angle: sampled.pdf * (1.0 - self.passed),
            is_delta: sampled.is_delta,
            eta: sampled.eta,
            scattering: sampled.scattering,
        })
    }

    /// Half of the samples as for radiance, half with the cosine's density.
    ///
    /// A turned normal that faces away from the viewer is turned back towards him: so light from `wi`
    /// goes on to viewers that the normal as seen from `wi` faces away from, and that it never samples.
    fn sample_turned_flux(&self, view: &View, wi: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let opacity = 1.0 - self.passed;
        let own = 2.0 * u[0];
        let mut sample = if own < 1.0 {
            self.sample_radiance(view, [own, u[1], u[2]])?
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
        if sample.is_delta {
            sample.weight = self.adjoint_weight(view, wi, &sample)? * 2.0;
            sample.pdf_solid_angle *= 0.5;
            return Some(sample);
        }
        let cosine = sample.wo.dot(self.frame.n).abs();
        let even = 0.5 * opacity * FRAC_1_PI * cosine;
        sample.pdf_solid_angle = 0.5 * (self.pdf_solid_angle(wi, sample.wo) + even);
        if sample.pdf_solid_angle <= 0.0 {
            return None;
        }
        sample.weight = self.eval_flux(wi, sample.wo) / sample.pdf_solid_angle;
        Some(sample)
    }

    /// A delta lobe's weight for flux, given that for radiance. With c the cosines in the lobe's
    /// frame, the factor is η² |cᵢ wo·n| / |cₒ wi·n|, and the bumps' shadow is that of the
    /// path the other way round. `None` for light along the true surface.
    fn adjoint_weight(&self, view: &View, wi: DVec3, sample: &BsdfSample) -> Option<Rgb> {
        let n = self.geometric_normal;
        let to = view.to_lobe(self.frame.to_local(sample.wo))?;
        let veach = (view.wi.z * sample.wo.dot(n)) / (to.wo.z * wi.dot(n));
        let shadowing =
            self.view(sample.wo).shadowing_of(self.frame.to_local(wi)) / view.shadowing(&to);
        let factor = sample.eta * sample.eta * veach.abs() * shadowing;
        (factor.is_finite() && factor > 0.0).then(|| sample.weight * factor)
    }

    /// What a path that comes from `wi` meets.
    #[inline]
    fn view(&self, wi: DVec3) -> View<'_, 'a> {
        View::new(&self.front, self.back.as_ref(), self.frame.to_local(wi))
    }
}
