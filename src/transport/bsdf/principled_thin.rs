//! Disney's principled material for sheets without thickness.
//!
//! B. Burley, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering" (SIGGRAPH 2015
//! course), with the choices of Mitsuba 3.9.1. Both sides are the same. With the share t of what mirrors or
//! passes, the part d of the rest that leaves on the other side, and m the half vector of wi and of wo
//! mirrored to wi's side,
//!
//! ```text
//! same side:   t F D G / (4 cos θᵢ)            +  (1 − t)(1 − d) (c/π (…) + sheen …) cos θₒ
//! other side:  t c (1 − F) D' G' / (4 cos θᵢ)  +  (1 − t) d c/π cos θₒ
//! ```
//!
//! D' is less rough than D, or rougher, by 0.65 η − 0.35 (Burley's figure 15).

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::disney::{alphas, matt_shape, sheen, tinted};
use super::rough::weighed;
use super::sample::{LobeSample, Scattering, cosine_hemisphere};
use crate::optics::{FacetDistribution, Microfacets, dielectric_reflectance, reflect};
use crate::radiometry::Rgb;

/// The sheet at a point. All numbers but `eta` are in 0..=1.
#[derive(Clone, Debug)]
pub(super) struct PrincipledThinLobe {
    pub base_color: Rgb,
    pub roughness: f64,
    pub anisotropic: f64,
    pub spec_trans: f64,
    /// Index inside divided by that outside.
    pub eta: f64,
    pub spec_tint: f64,
    pub sheen: f64,
    pub sheen_tint: f64,
    pub flatness: f64,
    /// Of the matt part, the share that leaves on the other side.
    pub crossing: f64,
}

/// Two directions as seen from `wi`'s side, and the half vector.
struct SheetPair {
    wi: DVec3,
    wo: DVec3,
    /// The half vector, after `wo` is mirrored to wi's side.
    m: DVec3,
    /// True if both are on one side.
    stays: bool,
    /// True if a facet with normal `m` has `wo` on the side where the surface has it.
    is_seen: bool,
}

/// A direction mirrored at the plane of the sheet.
fn across(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, -w.z)
}

impl PrincipledThinLobe {
    /// The facets of the mirror, or of what passes it.
    fn facets(&self, stays: bool) -> Microfacets {
        let scale = if stays { 1.0 } else { 0.65 * self.eta - 0.35 };
        let alphas = alphas(scale * self.roughness, self.anisotropic);
        Microfacets::new(FacetDistribution::Ggx, alphas)
    }

    /// `None` along the surface.
    fn pair(wi: DVec3, wo: DVec3) -> Option<SheetPair> {
        if wi.z == 0.0 || wo.z == 0.0 {
            return None;
        }
        let side = wi.z.signum();
        let (wi, wo) = (wi * side, wo * side);
        let stays = wo.z > 0.0;
        let mirrored = if stays { wo } else { across(wo) };
        let m = (wi + mirrored).try_normalize()?;
        let is_seen = wi.dot(m) > 0.0 && wo.dot(m) * wo.z > 0.0;
        Some(SheetPair {
            wi,
            wo,
            m,
            stays,
            is_seen,
        })
    }

    /// The shares of the mirror, what passes it, and light that leaves matt on this side and on the other.
    fn shares(&self) -> [f64; 4] {
        let (half, matt) = (0.5 * self.spec_trans, 1.0 - self.spec_trans);
        [
            half,
            half,
            matt * (1.0 - self.crossing),
            matt * self.crossing,
        ]
    }

    /// f |cos θₒ| from `wi` to `wo`: nothing bends, so radiance does not scale.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> Rgb {
        let Some(pair) = Self::pair(wi, wo) else {
            return Rgb::BLACK;
        };
        let [.., matt, crossing] = self.shares();
        let mut value = Rgb::BLACK;
        if self.spec_trans > 0.0 && pair.is_seen {
            value += self.interface(&pair) * self.spec_trans;
        }
        if pair.stays {
            value += self.matt(&pair) * matt;
        } else {
            value += self.base_color * (crossing * FRAC_1_PI * -pair.wo.z);
        }
        // Quotients of two zeros at grazing angles are not finite.
        if value.is_finite() { value } else { Rgb::BLACK }
    }

    fn interface(&self, pair: &SheetPair) -> Rgb {
        let facets = self.facets(pair.stays);
        let shadowing = facets.shadowing(pair.wi, pair.m) * facets.shadowing(pair.wo, pair.m);
        let shape = 0.25 * facets.density(pair.m) * shadowing / pair.wi.z;
        let cos = pair.wi.dot(pair.m);
        let reflectance = dielectric_reflectance(cos, self.eta);
        if !pair.stays {
            return self.base_color * ((1.0 - reflectance) * shape);
        }
        let tinted = tinted(self.base_color, cos, self.eta) * self.spec_tint;
        (tinted + Rgb::grey((1.0 - self.spec_tint) * reflectance)) * shape
    }

    fn matt(&self, pair: &SheetPair) -> Rgb {
        let cos_o = pair.wo.z;
        let cos_d = pair.m.dot(pair.wo);
        let shape = matt_shape([pair.wi.z, cos_o], cos_d, self.roughness, self.flatness);
        let sheen = sheen(self.base_color, self.sheen_tint, self.sheen, cos_d);
        (self.base_color * (FRAC_1_PI * shape) + sheen) * cos_o
    }

    /// The density of [`Self::sample`] at `wo`.
    pub fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        let Some(pair) = Self::pair(wi, wo) else {
            return 0.0;
        };
        let [mirror, passing, matt, crossing] = self.shares();
        let (facets, matt) = if pair.stays {
            (mirror, matt)
        } else {
            (passing, crossing)
        };
        let mut pdf = matt * FRAC_1_PI * pair.wo.z.abs();
        if facets > 0.0 && pair.is_seen {
            let visible = self.facets(pair.stays).visible_density(pair.wi, pair.m);
            // The half vector has wi and the mirrored wo at the same angle.
            pdf += facets * visible * 0.25 / pair.wi.dot(pair.m);
        }
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// A direction; the first number chooses the part.
    pub fn sample(&self, wi: DVec3, [choice, u, v]: [f64; 3]) -> Option<LobeSample> {
        if wi.z == 0.0 {
            return None;
        }
        let side = wi.z.signum();
        let view = wi * side;
        let [mirror, passing, matt, _] = self.shares();
        let mirrored = |stays| reflect(-view, self.facets(stays).sample_visible(view, [u, v]));
        let (wo, scattering) = if choice < mirror {
            (mirrored(true), Scattering::Reflected)
        } else if choice < mirror + passing {
            (across(mirrored(false)), Scattering::Transmitted)
        } else if choice < mirror + passing + matt {
            (cosine_hemisphere([u, v]), Scattering::Diffuse)
        } else {
            (-cosine_hemisphere([u, v]), Scattering::Diffuse)
        };
        let wo = wo * side;
        let pair = Self::pair(wi, wo)?;
        // Light that a facet sends to the wrong side of the sheet, or of itself, is lost.
        let is_lost = match scattering {
            Scattering::Reflected => !(pair.stays && pair.is_seen),
            Scattering::Transmitted => pair.stays || !pair.is_seen,
            _ => false,
        };
        if is_lost {
            return None;
        }
        weighed(self.eval(wi, wo), self.pdf(wi, wo), wo, 1.0, scattering)
    }
}
