//! A matt base under a transparent coat.
//!
//! The base scatters the light that enters the coat, and the coat's inside throws part of it back to the
//! base, any number of times. With r the share thrown back and ρ the base's albedo, the series sums to ρ / (1
//! − ρ r). Mitsuba leaves ρ out of the denominator unless `nonlinear`, which keeps the colour of the base
//! unchanged.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::rough::{half, mirrored_density, mirrored_share, weighed};
use super::sample::{LobeSample, Scattering, cosine_hemisphere};
use crate::optics::{Microfacets, RoughTransmittance, dielectric_reflectance, reflect};
use crate::radiometry::Rgb;

/// The base, seen through its coat.
#[derive(Clone, Copy, Debug)]
pub(super) struct Base {
    /// The coat's index divided by that of its surroundings.
    pub eta: f64,
    pub diffuse_reflectance: Rgb,
    pub specular_reflectance: Rgb,
    pub nonlinear: bool,
}

/// A matt base under a smooth coat.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plastic {
    pub base: Base,
}

/// A matt base under a rough coat.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughPlastic<'a> {
    pub base: Base,
    pub facets: Microfacets,
    pub transmittance: &'a RoughTransmittance,
}

impl Base {
    /// ρ / (1 − ρ r), or ρ / (1 − r), given the share r that the coat's inside reflects.
    fn repeated(&self, internal_reflectance: f64) -> Rgb {
        self.diffuse_reflectance.map(|albedo| {
            let again = if self.nonlinear { albedo } else { 1.0 };
            albedo / (1.0 - again * internal_reflectance)
        })
    }

    /// The base's f cos θ [1/sr], with the share `entering` of light that enters the coat and the share
    /// `leaving` that leaves it at angle θ.
    ///
    /// 1/η² is the ratio of the solid angle outside of the coat to that inside.
    fn eval(&self, internal_reflectance: f64, entering: f64, leaving: f64, cos: f64) -> Rgb {
        let through = entering * leaving / (self.eta * self.eta);
        self.repeated(internal_reflectance) * (FRAC_1_PI * cos * through)
    }

    /// The probability that a sample belongs to the coat, of which the share `entering` enters.
    fn coat_probability(&self, entering: f64) -> f64 {
        let (base, coat) = (
            self.diffuse_reflectance.mean(),
            self.specular_reflectance.mean(),
        );
        let [base, coat] = [entering * base, (1.0 - entering) * coat];
        if base + coat > 0.0 {
            coat / (base + coat)
        } else {
            0.0
        }
    }
}

impl Plastic {
    fn entering(&self, cos: f64) -> f64 {
        1.0 - dielectric_reflectance(cos, self.base.eta)
    }

    /// f cos θ of the base only: the coat's mirror image is a delta lobe.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> Rgb {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return Rgb::BLACK;
        }
        let [entering, leaving] = [wi.z, wo.z].map(|cos| self.entering(cos));
        let inside = diffuse_reflectance_from_inside(self.base.eta);
        self.base.eval(inside, entering, leaving, wo.z)
    }

    pub fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let coat = self.base.coat_probability(self.entering(wi.z));
        (1.0 - coat) * FRAC_1_PI * wo.z
    }

    pub fn sample(&self, wi: DVec3, [choice, u, v]: [f64; 3]) -> Option<LobeSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let entering = self.entering(wi.z);
        let coat = self.base.coat_probability(entering);
        if choice < coat {
            return Some(LobeSample {
                wo: DVec3::new(-wi.x, -wi.y, wi.z),
                weight: self.base.specular_reflectance * ((1.0 - entering) / coat),
                pdf: coat,
                is_delta: true,
                eta: 1.0,
                scattering: Scattering::Reflected,
            });
        }
        let wo = cosine_hemisphere([u, v]);
        let (value, pdf) = (self.eval(wi, wo), self.pdf(wi, wo));
        weighed(value, pdf, wo, 1.0, Scattering::Diffuse)
    }
}

impl RoughPlastic<'_> {
    /// f cos θ of the coat's facets and of the base below.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> Rgb {
        let Some(m) = half(wi, wo) else {
            return Rgb::BLACK;
        };
        let reflectance = dielectric_reflectance(wi.dot(m), self.base.eta);
        let coat = self.base.specular_reflectance
            * (reflectance * mirrored_share(&self.facets, wi, wo, m));
        let [entering, leaving] = [wi.z, wo.z].map(|cos| self.transmittance.entering(cos));
        let inside = self.transmittance.internal_reflectance();
        coat + self.base.eval(inside, entering, leaving, wo.z)
    }

    pub fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        let Some(m) = half(wi, wo) else {
            return 0.0;
        };
        let coat = self
            .base
            .coat_probability(self.transmittance.entering(wi.z));
        coat * mirrored_density(&self.facets, wi, wo, m) + (1.0 - coat) * FRAC_1_PI * wo.z
    }

    pub fn sample(&self, wi: DVec3, [choice, u, v]: [f64; 3]) -> Option<LobeSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let coat = self
            .base
            .coat_probability(self.transmittance.entering(wi.z));
        let (wo, scattering) = if choice < coat {
            let m = self.facets.sample_visible(wi, [u, v]);
            (reflect(-wi, m), Scattering::Reflected)
        } else {
            (cosine_hemisphere([u, v]), Scattering::Diffuse)
        };
        weighed(self.eval(wi, wo), self.pdf(wi, wo), wo, 1.0, scattering)
    }
}

/// The share of diffuse light that a smooth surface reflects to the inside, as Mitsuba computes it.
///
/// For `eta` = `n_inside / n_outside` above 1 this is a fit of Egan and Hilgeman (1973), within 0.1 % up to
/// 1.5 and 0.6 % up to 2. Below 1 it is a fit of d'Eon and Irving (SIGGRAPH 2011), within 0.2 %.
fn diffuse_reflectance_from_inside(eta: f64) -> f64 {
    let seen = 1.0 / eta;
    if seen < 1.0 {
        0.0636 * eta + seen * (seen * -1.4399 + 0.7099) + 0.6681
    } else {
        [-1.36881, 4.98554, -7.80989, 6.75335, -3.4793, 0.919317]
            .into_iter()
            .fold(0.0, |sum, coefficient| sum * eta + coefficient)
    }
}
