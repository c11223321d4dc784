//! The plain materials, each in the frame of its normal.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;

use super::Scattering;
use super::smooth;
use crate::radiometry::Rgb;

/// A material without wrappers; +z is its normal, radiance is what it scatters.
#[derive(Clone, Copy, Debug)]
pub(super) enum Lobe<'a> {
    /// Scatters nothing.
    Black,
    /// Lambertian on the front.
    Diffuse(Rgb),
    /// A smooth interface.
    Dielectric(smooth::Interface),
    /// A thin pane.
    Pane(smooth::Interface),
    /// A mirror on the front.
    Conductor(smooth::Metal),
    #[allow(dead_code)]
    Later(std::marker::PhantomData<&'a ()>),
}

/// What a lobe answers when asked for a direction; as [`super::BsdfSample`], in its frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct LobeSample {
    pub wo: DVec3,
    pub weight: Rgb,
    pub pdf: f64,
    pub is_delta: bool,
    pub eta: f64,
    pub scattering: Scattering,
}

impl Lobe<'_> {
    #[inline]
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Black | Self::Dielectric(_) | Self::Pane(_) | Self::Conductor(_) => true,
            Self::Diffuse(_) | Self::Later(_) => false,
        }
    }

    pub fn eval(&self, wi: DVec3, wo: DVec3) -> Rgb {
        match self {
            Self::Diffuse(reflectance) if wi.z > 0.0 && wo.z > 0.0 => {
                *reflectance * (FRAC_1_PI * wo.z)
            }
            _ => Rgb::BLACK,
        }
    }

    pub fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        match self {
            Self::Diffuse(_) if wi.z > 0.0 && wo.z > 0.0 => FRAC_1_PI * wo.z,
            _ => 0.0,
        }
    }

    pub fn sample(&self, wi: DVec3, [choice, u, v]: [f64; 3]) -> Option<LobeSample> {
        match self {
            Self::Black | Self::Later(_) => None,
            Self::Diffuse(reflectance) => {
                if wi.z <= 0.0 {
                    return None;
                }
                let wo = cosine_hemisphere([u, v]);
                (wo.z > 0.0).then(|| LobeSample {
                    wo,
                    weight: *reflectance,
                    pdf: FRAC_1_PI * wo.z,
                    is_delta: false,
                    eta: 1.0,
                    scattering: Scattering::Diffuse,
                })
            }
            Self::Dielectric(interface) => interface.sample(wi, choice),
            Self::Pane(interface) => interface.sample_pane(wi, choice),
            Self::Conductor(metal) => metal.sample(wi),
        }
    }
}

/// A direction with density cos θ / π (Malley's method).
#[inline]
pub(super) fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    let radius = u[0].sqrt();
    let (sin, cos) = (TAU * u[1]).sin_cos();
    DVec3::new(radius * cos, radius * sin, (1.0 - u[0]).sqrt())
}
