//! Smooth interfaces and mirrors: delta lobes.

use glam::DVec3;

use super::sample::{LobeSample, Scattering};
use crate::optics::{
    conductor_reflectance, dielectric_reflectance, refract, thin_slab_reflectance,
};
use crate::radiometry::Rgb;

/// A border between two media, or a pane of one in another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    /// Index behind the surface (seen from +z) divided by the index before it.
    pub eta: f64,
    pub specular_reflectance: Rgb,
    pub specular_transmittance: Rgb,
}

/// A metal, and the factor on its reflection.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmoothMetal {
    pub eta: Rgb,
    pub k: Rgb,
    pub specular_reflectance: Rgb,
}

impl Interface {
    /// Index on the far side divided by the index on `wi`'s side.
    #[inline]
    pub fn eta_towards(&self, wi: DVec3) -> f64 {
        if wi.z > 0.0 { self.eta } else { 1.0 / self.eta }
    }

    /// Reflection with the probability F, else refraction, which scales radiance by 1/η².
    pub fn sample(&self, wi: DVec3, choice: f64) -> Option<LobeSample> {
        let eta = self.eta_towards(wi);
        let reflectance = dielectric_reflectance(wi.z.abs(), eta);
        if choice < reflectance {
            return self.reflected(wi, reflectance);
        }
        let normal = DVec3::new(0.0, 0.0, wi.z.signum());
        let wo = refract(-wi, normal, eta)?.normalize();
        leaves(wo).then(|| LobeSample {
            wo,
            weight: self.specular_transmittance / (eta * eta),
            pdf: 1.0 - reflectance,
            is_delta: true,
            eta,
            scattering: Scattering::Transmitted,
        })
    }

    /// Reflection or passage straight on: a pane does not shift rays and leaves them in the medium they were
    /// in.
    pub fn sample_pane(&self, wi: DVec3, choice: f64) -> Option<LobeSample> {
        let reflectance = thin_slab_reflectance(wi.z.abs(), self.eta);
        if choice < reflectance {
            return self.reflected(wi, reflectance);
        }
        leaves(wi).then(|| LobeSample {
            wo: -wi,
            weight: self.specular_transmittance,
            pdf: 1.0 - reflectance,
            is_delta: true,
            eta: 1.0,
            scattering: Scattering::Transmitted,
        })
    }

    fn reflected(&self, wi: DVec3, pdf: f64) -> Option<LobeSample> {
        leaves(wi).then(|| LobeSample {
            wo: DVec3::new(-wi.x, -wi.y, wi.z),
            weight: self.specular_reflectance,
            pdf,
            is_delta: true,
            eta: 1.0,
            scattering: Scattering::Reflected,
        })
    }
}

impl SmoothMetal {
    /// Fresnel reflectance of each channel, times its factor.
    pub fn reflectance(&self, cos_incident: f64) -> Rgb {
        let of = |c: usize| conductor_reflectance(cos_incident, self.eta.0[c], self.k.0[c]);
        let metal = if self.eta.is_grey() && self.k.is_grey() {
            Rgb::grey(of(0))
        } else {
            Rgb(std::array::from_fn(of))
        };
        self.specular_reflectance * metal
    }

    pub fn sample(&self, wi: DVec3) -> Option<LobeSample> {
        (wi.z > 0.0).then(|| LobeSample {
            wo: DVec3::new(-wi.x, -wi.y, wi.z),
            weight: self.reflectance(wi.z),
            pdf: 1.0,
            is_delta: true,
            eta: 1.0,
            scattering: Scattering::Reflected,
        })
    }
}

/// True if a direction leaves the surface at all, and does not run along it.
#[inline]
fn leaves(direction: DVec3) -> bool {
    direction.z != 0.0
}
