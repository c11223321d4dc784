//! Plain materials, each in the frame of its normal.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::plastic::{Plastic, RoughPlastic};
use super::principled::PrincipledLobe;
use super::principled_thin::PrincipledThinLobe;
use super::rough::{RoughInterface, RoughMetal};
use super::sample::{LobeSample, Scattering, cosine_hemisphere};
use super::smooth::{Interface, SmoothMetal};
use crate::radiometry::Rgb;

/// A material without wrappers, with +z as its normal, that scatters radiance.
#[derive(Clone, Debug)]
pub(super) enum Lobe<'a> {
    /// Scatters nothing.
    Black,
    /// Lambertian on the front.
    Diffuse(Rgb),
    Dielectric(Interface),
    Pane(Interface),
    Conductor(SmoothMetal),
    RoughDielectric(RoughInterface),
    RoughConductor(RoughMetal),
    Plastic(Plastic),
    RoughPlastic(RoughPlastic<'a>),
    /// Apart, since it is much larger than the others.
    Principled(Box<PrincipledLobe>),
    /// Apart, too.
    PrincipledThin(Box<PrincipledThinLobe>),
}

impl Lobe<'_> {
    /// True if no direction has a density.
    #[inline]
    pub fn is_delta(&self) -> bool {
        matches!(
            self,
            Self::Black | Self::Dielectric(_) | Self::Pane(_) | Self::Conductor(_)
        )
    }

    /// True of rough interfaces.
    #[inline]
    pub fn is_glossy(&self) -> bool {
        matches!(self, Self::RoughDielectric(_) | Self::RoughConductor(_))
    }

    /// True if light goes on from one direction to another, and by the same lobe none the other way round.
    #[inline]
    pub fn is_lopsided(&self) -> bool {
        matches!(self, Self::PrincipledThin(sheet) if sheet.spec_trans > 0.0)
    }

    /// f |cos θₒ| of all lobes but delta lobes.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> Rgb {
        match self {
            Self::Black | Self::Dielectric(_) | Self::Pane(_) | Self::Conductor(_) => Rgb::BLACK,
            Self::Diffuse(reflectance) => *reflectance * lambert(wi, wo),
            Self::RoughDielectric(interface) => interface.eval(wi, wo),
            Self::RoughConductor(metal) => metal.eval(wi, wo),
            Self::Plastic(plastic) => plastic.eval(wi, wo),
            Self::RoughPlastic(plastic) => plastic.eval(wi, wo),
            Self::Principled(principled) => principled.eval(wi, wo),
            Self::PrincipledThin(sheet) => sheet.eval(wi, wo),
        }
    }

    /// The density of `sample` at `wo`.
    pub fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        match self {
            Self::Black | Self::Dielectric(_) | Self::Pane(_) | Self::Conductor(_) => 0.0,
            Self::Diffuse(_) => lambert(wi, wo),
            Self::RoughDielectric(interface) => interface.pdf(wi, wo),
            Self::RoughConductor(metal) => metal.pdf(wi, wo),
            Self::Plastic(plastic) => plastic.pdf(wi, wo),
            Self::RoughPlastic(plastic) => plastic.pdf(wi, wo),
            Self::Principled(principled) => principled.pdf(wi, wo),
            Self::PrincipledThin(sheet) => sheet.pdf(wi, wo),
        }
    }

    /// A direction; the first number chooses among lobes.
    pub fn sample(&self, wi: DVec3, u: [f64; 3]) -> Option<LobeSample> {
        match self {
            Self::Black => None,
            Self::Diffuse(reflectance) => {
                let wo = cosine_hemisphere([u[1], u[2]]);
                let pdf = lambert(wi, wo);
                (pdf > 0.0).then_some(LobeSample {
                    wo,
                    weight: *reflectance,
                    pdf,
                    is_delta: false,
                    eta: 1.0,
                    scattering: Scattering::Diffuse,
                })
            }
            Self::Dielectric(interface) => interface.sample(wi, u[0]),
            Self::Pane(interface) => interface.sample_pane(wi, u[0]),
            Self::Conductor(metal) => metal.sample(wi),
            Self::RoughDielectric(interface) => interface.sample(wi, u),
            Self::RoughConductor(metal) => metal.sample(wi, [u[1], u[2]]),
            Self::Plastic(plastic) => plastic.sample(wi, u),
            Self::RoughPlastic(plastic) => plastic.sample(wi, u),
            Self::Principled(principled) => principled.sample(wi, u),
            Self::PrincipledThin(sheet) => sheet.sample(wi, u),
        }
    }
}

/// cos θₒ / π if both directions are on the front, else zero.
#[inline]
fn lambert(wi: DVec3, wo: DVec3) -> f64 {
    if wi.z > 0.0 && wo.z > 0.0 {
        FRAC_1_PI * wo.z
    } else {
        0.0
    }
}
