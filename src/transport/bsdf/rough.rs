//! Rough mirrors and rough interfaces: microfacets that reflect or refract light once.
//!
//! The model is that of Walter et al., *Microfacet Models for Refraction through Rough Surfaces* (EGSR 2007).
//! Light that meets a second facet is lost. So the albedo of a lossless surface is below 1, the more so the
//! rougher it is.

use glam::DVec3;

use super::sample::{LobeSample, Scattering};
use super::smooth::{Interface, SmoothMetal};
use crate::optics::{Microfacets, dielectric_reflectance, reflect, refract};
use crate::radiometry::Rgb;

/// A metal made of facets.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughMetal {
    pub metal: SmoothMetal,
    pub facets: Microfacets,
}

/// An interface made of facets.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughInterface {
    pub interface: Interface,
    pub facets: Microfacets,
}

impl RoughMetal {
    /// F D G / (4 cos θᵢ) (equation 20, times cos θₒ).
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> Rgb {
        match half(wi, wo) {
            Some(m) => {
                let shape = mirrored_share(&self.facets, wi, wo, m);
                self.metal.reflectance(wi.dot(m)) * shape
            }
            None => Rgb::BLACK,
        }
    }

    pub fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        half(wi, wo).map_or(0.0, |m| mirrored_density(&self.facets, wi, wo, m))
    }

    pub fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<LobeSample> {
        if wi.z <= 0.0 {
            return None;
        }
        let wo = reflect(-wi, self.facets.sample_visible(wi, u));
        weighed(
            self.eval(wi, wo),
            self.pdf(wi, wo),
            wo,
            1.0,
            Scattering::Reflected,
        )
    }
}

impl RoughInterface {
    /// f |cos θₒ| from `wi` to `wo`: on wi's side F D G / (4 |cos θᵢ|). On the other side, with η = nₒ / nᵢ
    /// and radiance scaled by 1/η²,
    ///
    /// ```text
    /// (1 − F) D G |wi·m| |wo·m| / (|cos θᵢ| (wi·m + η wo·m)²)
    /// ```
    ///
    /// (equations 20 and 21, times |cos θₒ|).
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> Rgb {
        let Some(bend) = self.bend(wi, wo) else {
            return Rgb::BLACK;
        };
        let (m, reflectance) = (bend.m, bend.reflectance);
        let Some(eta) = bend.eta else {
            let share = reflectance * mirrored_share(&self.facets, wi, wo, m);
            return self.interface.specular_reflectance * share;
        };
        let shadowing = self.facets.shadowing(wi, m) * self.facets.shadowing(wo, m);
        let shape = self.facets.density(m) * shadowing * (wi.dot(m) / wi.z).abs();
        let value = (1.0 - reflectance) * shape * spread(wi, wo, m, eta) / (eta * eta);
        self.interface.specular_transmittance * finite(value)
    }

    pub fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        let Some(bend) = self.bend(wi, wo) else {
            return 0.0;
        };
        let (m, reflectance) = (bend.m, bend.reflectance);
        // Facets look the same from below.
        let upper = wi * wi.z.signum();
        match bend.eta {
            None => reflectance * mirrored_density(&self.facets, upper, wo, m),
            Some(eta) => {
                let density = self.facets.visible_density(upper, m);
                finite((1.0 - reflectance) * density * spread(wi, wo, m, eta))
            }
        }
    }

    pub fn sample(&self, wi: DVec3, [choice, u, v]: [f64; 3]) -> Option<LobeSample> {
        if wi.z == 0.0 {
            return None;
        }
        let side = wi.z.signum();
        // A facet's normal on wi's side.
        let m = self.facets.sample_visible(wi * side, [u, v]) * side;
        let eta = self.interface.eta_towards(wi);
        let reflectance = dielectric_reflectance(wi.dot(m), eta);
        let (wo, eta, scattering) = if choice < reflectance {
            (reflect(-wi, m), 1.0, Scattering::Reflected)
        } else {
            (
                refract(-wi, m, eta)?.normalize(),
                eta,
                Scattering::Transmitted,
            )
        };
        let stays = scattering == Scattering::Reflected;
        // Light that a facet sends to the wrong side of the surface is lost.
        if (wo.z * side > 0.0) != stays {
            return None;
        }
        weighed(self.eval(wi, wo), self.pdf(wi, wo), wo, eta, scattering)
    }

    /// The facet that sends light from `wi` to `wo`; `None` if there is none.
    fn bend(&self, wi: DVec3, wo: DVec3) -> Option<Bend> {
        if wi.z == 0.0 || wo.z == 0.0 {
            return None;
        }
        let towards = self.interface.eta_towards(wi);
        let crosses = wi.z * wo.z < 0.0;
        let eta = crosses.then_some(towards);
        let m = (wi + wo * eta.unwrap_or(1.0)).try_normalize()?;
        let m = m * m.z.signum();
        // Both directions must see the side of the facet that they see of the surface.
        let is_seen = wi.dot(m) * wi.z > 0.0 && wo.dot(m) * wo.z > 0.0;
        is_seen.then(|| Bend {
            m,
            reflectance: dielectric_reflectance(wi.dot(m).abs(), towards),
            eta,
        })
    }
}

/// A facet that sends light from one direction to another.
struct Bend {
    /// Its normal, on the upper side.
    m: DVec3,
    /// Its Fresnel reflectance.
    reflectance: f64,
    /// nₒ / nᵢ if it refracts.
    eta: Option<f64>,
}

/// The normal of the facet that mirrors `wi` into `wo`, both on the upper side.
pub(super) fn half(wi: DVec3, wo: DVec3) -> Option<DVec3> {
    if wi.z > 0.0 && wo.z > 0.0 {
        (wi + wo).try_normalize()
    } else {
        None
    }
}

/// D G / (4 |cos θᵢ|) [1/sr], the share that perfect facets reflect from `wi` to `wo`.
pub(super) fn mirrored_share(facets: &Microfacets, wi: DVec3, wo: DVec3, m: DVec3) -> f64 {
    let shadowing = facets.shadowing(wi, m) * facets.shadowing(wo, m);
    finite(facets.density(m) * shadowing / (4.0 * wi.z.abs()))
}

/// The density [1/sr] of directions reflected at visible normals: the normals' own, divided by 4 wo·m.
pub(super) fn mirrored_density(facets: &Microfacets, wi: DVec3, wo: DVec3, m: DVec3) -> f64 {
    finite(facets.visible_density(wi, m) / (4.0 * wo.dot(m).abs()))
}

/// Solid angle of normals per solid angle of refracted directions: η² |wo·m| / (wi·m + η wo·m)² (equation
/// 17).
pub(super) fn spread(wi: DVec3, wo: DVec3, m: DVec3, eta: f64) -> f64 {
    let sum = wi.dot(m) + eta * wo.dot(m);
    eta * eta * wo.dot(m).abs() / (sum * sum)
}

/// A sample with a density; `None` if that is zero or infinite.
pub(super) fn weighed(
    value: Rgb,
    pdf: f64,
    wo: DVec3,
    eta: f64,
    scattering: Scattering,
) -> Option<LobeSample> {
    (pdf > 0.0 && pdf.is_finite()).then(|| LobeSample {
        wo,
        weight: value / pdf,
        pdf,
        is_delta: false,
        eta,
        scattering,
    })
}

/// Zero for values that are not finite: quotients of two zeros at grazing angles.
#[inline]
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}
