//! Disney's principled material.
//!
//! B. Burley, "Physically-Based Shading at Disney" (SIGGRAPH 2012 course) and "Extending the Disney BRDF to a
//! BSDF with Integrated Subsurface Scattering" (2015), with the choices of Mitsuba 3.9.1. The main interface
//! is of GGX facets with Fresnel's formulas. On its front are a matt base, a sheen and a second coat (GTR1).
//! With metallic m and transparent part t,
//!
//! ```text
//! f cos θₒ = F D G / (4 cos θᵢ)  +  (1 − m) t √c (1 − F) D G …  +  (1 − m)(1 − t) c/π (…) cos θₒ
//!          + (1 − m) sheen …     +  clearcoat/4 F D G cos θₒ
//! ```
//!
//! It is no closed budget: at grazing angles the parts together may send more light back than arrives.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::DVec3;

use super::disney::{matt_shape, schlick, sheen, tinted};
use super::rough::{spread, weighed};
use super::sample::{LobeSample, Scattering, cosine_hemisphere};
use crate::numeric::math;
use crate::optics::{Microfacets, dielectric_reflectance, reflect, refract};
use crate::radiometry::Rgb;

/// The material at a point. All numbers but `eta` are in 0..=1.
#[derive(Clone, Debug)]
pub(super) struct PrincipledLobe {
    pub base_color: Rgb,
    pub roughness: f64,
    /// The main interface's facets.
    pub facets: Microfacets,
    pub metallic: f64,
    pub spec_trans: f64,
    /// Index behind the surface divided by the index before it.
    pub eta: f64,
    pub spec_tint: f64,
    pub sheen: f64,
    pub sheen_tint: f64,
    pub flatness: f64,
    pub clearcoat: f64,
    pub clearcoat_gloss: f64,
}

/// Two directions, and the facet that sends light from one to the other.
struct Pair {
    wi: DVec3,
    wo: DVec3,
    /// The facet's normal, on the upper side.
    m: DVec3,
    /// nₒ / nᵢ for light that goes through, seen from `wi`'s side.
    eta: f64,
    /// Fresnel's reflectance of the facet.
    reflectance: f64,
    /// True if both are on one side.
    stays: bool,
    /// True if both directions see the side of the facet that they see of the surface.
    is_seen: bool,
}

/// The probabilities of a sample's parts.
struct Shares {
    diffuse: f64,
    clearcoat: f64,
    transmitted: f64,
    reflected: f64,
}

impl PrincipledLobe {
    /// The share of the matt base.
    fn base(&self) -> f64 {
        (1.0 - self.metallic) * (1.0 - self.spec_trans)
    }

    /// The share that light passes through.
    fn glass(&self) -> f64 {
        (1.0 - self.metallic) * self.spec_trans
    }

    /// `None` along the surface, and from behind what lets nothing through.
    fn pair(&self, wi: DVec3, wo: DVec3) -> Option<Pair> {
        if wi.z == 0.0 || wo.z == 0.0 || (wi.z < 0.0 && self.glass() <= 0.0) {
            return None;
        }
        let eta = self.eta_towards(wi);
        let stays = wi.z * wo.z > 0.0;
        let m = (wi + wo * if stays { 1.0 } else { eta }).try_normalize()?;
        let m = m * m.z.signum();
        Some(Pair {
            wi,
            wo,
            m,
            eta,
            reflectance: dielectric_reflectance(wi.dot(m).abs(), eta),
            stays,
            is_seen: wi.dot(m) * wi.z > 0.0 && wo.dot(m) * wo.z > 0.0,
        })
    }

    fn eta_towards(&self, wi: DVec3) -> f64 {
        if wi.z > 0.0 { self.eta } else { 1.0 / self.eta }
    }

    fn shares(&self, front: bool, reflectance: f64) -> Shares {
        if !front {
            return Shares {
                diffuse: 0.0,
                clearcoat: 0.0,
                transmitted: 1.0 - reflectance,
                reflected: reflectance,
            };
        }
        // The coat sends back a quarter of what the main interface does.
        let (base, coat) = (self.base(), 0.25 * self.clearcoat);
        let whole = 1.0 + base + coat;
        let transmitted = self.glass() * (1.0 - reflectance);
        Shares {
            diffuse: base / whole,
            clearcoat: coat / whole,
            transmitted: transmitted / whole,
            reflected: (1.0 - transmitted) / whole,
        }
    }

    /// f |cos θₒ| from `wi` to `wo`; radiance that goes through is scaled by 1/η².
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> Rgb {
        let Some(pair) = self.pair(wi, wo) else {
            return Rgb::BLACK;
        };
        let shape = || {
            let shadowing = self.facets.shadowing(wi, pair.m) * self.facets.shadowing(wo, pair.m);
            self.facets.density(pair.m) * shadowing / wi.z.abs()
        };
        if !pair.stays {
            if !pair.is_seen || self.glass() <= 0.0 {
                return Rgb::BLACK;
            }
            let bent = spread(wi, wo, pair.m, pair.eta) / (pair.eta * pair.eta);
            let through = (1.0 - pair.reflectance) * shape() * wi.dot(pair.m).abs() * bent;
            return finite(self.base_color.map(f64::sqrt) * (self.glass() * through));
        }
        let front = wi.z > 0.0;
        let mut value = Rgb::BLACK;
        if pair.is_seen {
            value += self.fresnel(&pair, front) * (0.25 * shape());
            if front && self.clearcoat > 0.0 {
                value += Rgb::grey(self.coat(&pair));
            }
        }
        if front && self.base() > 0.0 {
            value += self.matt(&pair);
        }
        finite(value)
    }

    /// The reflectance of the main interface: metal and tint by Schlick's formula, glass by Fresnel's. From
    /// behind there is glass only.
    fn fresnel(&self, pair: &Pair, front: bool) -> Rgb {
        if !front {
            return Rgb::grey(self.glass() * pair.reflectance);
        }
        let cos = pair.wi.dot(pair.m);
        let dielectric = 1.0 - self.metallic;
        self.base_color.map(|r0| schlick(r0, cos, self.eta)) * self.metallic
            + tinted(self.base_color, cos, self.eta) * (dielectric * self.spec_tint)
            + Rgb::grey(dielectric * (1.0 - self.spec_tint) * pair.reflectance)
    }

    /// The second coat's f cos θₒ.
    fn coat(&self, pair: &Pair) -> f64 {
        let fresnel = schlick(0.04, pair.wi.dot(pair.m), self.eta);
        let shadowing = coat_shadowing(pair.wi, pair.m) * coat_shadowing(pair.wo, pair.m);
        0.25 * self.clearcoat * fresnel * self.coat_density(pair.m) * shadowing * pair.wo.z.abs()
    }

    /// α² of the second coat.
    fn coat_alpha2(&self) -> f64 {
        let alpha = 0.1 + (0.001 - 0.1) * self.clearcoat_gloss;
        alpha * alpha
    }

    /// Burley's GTR1 [1/sr]: (α² − 1) / (π ln α² (1 + (α² − 1) cos²θ)).
    fn coat_density(&self, m: DVec3) -> f64 {
        let squared = self.coat_alpha2();
        (squared - 1.0) / (PI * math::ln(squared) * (1.0 + (squared - 1.0) * m.z * m.z))
    }

    /// A normal of the second coat with the density D cos θ.
    fn sample_coat(&self, [u, v]: [f64; 2]) -> DVec3 {
        let squared = self.coat_alpha2();
        let cos2 = (1.0 - math::powf(squared, 1.0 - v)) / (1.0 - squared);
        let (sin_phi, cos_phi) = math::sin_cos(TAU * u);
        let sin = (1.0 - cos2).max(0.0).sqrt();
        DVec3::new(cos_phi * sin, sin_phi * sin, cos2.max(0.0).sqrt())
    }

    /// The matt base and the sheen on it, f cos θₒ.
    fn matt(&self, pair: &Pair) -> Rgb {
        let cos_o = pair.wo.z;
        let cos_d = pair.m.dot(pair.wo);
        let shape = matt_shape([pair.wi.z, cos_o], cos_d, self.roughness, self.flatness);
        let base = self.base_color * (self.base() * FRAC_1_PI * shape);
        let strength = self.sheen * (1.0 - self.metallic);
        let sheen = sheen(self.base_color, self.sheen_tint, strength, cos_d);
        (base + sheen) * cos_o
    }

    /// The density of [`Self::sample`] at `wo`.
    pub fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        let Some(pair) = self.pair(wi, wo) else {
            return 0.0;
        };
        let shares = self.shares(wi.z > 0.0, pair.reflectance);
        // Facets look the same from below.
        let visible = || self.facets.visible_density(wi * wi.z.signum(), pair.m);
        let mut pdf = 0.0;
        if pair.stays {
            if pair.is_seen {
                let mirrored = 0.25 / wo.dot(pair.m).abs();
                pdf += shares.reflected * visible() * mirrored;
                pdf += shares.clearcoat * self.coat_density(pair.m) * pair.m.z * mirrored;
            }
            pdf += shares.diffuse * FRAC_1_PI * wo.z.abs();
        } else if pair.is_seen {
            pdf += shares.transmitted * visible() * spread(wi, wo, pair.m, pair.eta);
        }
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// A direction; the first number chooses the part.
    pub fn sample(&self, wi: DVec3, [choice, u, v]: [f64; 3]) -> Option<LobeSample> {
        if wi.z == 0.0 || (wi.z < 0.0 && self.glass() <= 0.0) {
            return None;
        }
        let side = wi.z.signum();
        // A facet's normal on wi's side.
        let m = self.facets.sample_visible(wi * side, [u, v]) * side;
        let towards = self.eta_towards(wi);
        let shares = self.shares(side > 0.0, dielectric_reflectance(wi.dot(m), towards));
        let coated = shares.diffuse + shares.clearcoat;
        let (wo, eta, scattering) = if choice < shares.diffuse {
            (cosine_hemisphere([u, v]), 1.0, Scattering::Diffuse)
        } else if choice < coated {
            let coat = self.sample_coat([u, v]);
            (reflect(-wi, coat), 1.0, Scattering::Reflected)
        } else if choice < coated + shares.transmitted {
            let wo = refract(-wi, m, towards)?.normalize();
            (wo, towards, Scattering::Transmitted)
        } else {
            (reflect(-wi, m), 1.0, Scattering::Reflected)
        };
        let crosses = scattering == Scattering::Transmitted;
        // Light that a facet sends to the wrong side of the surface is lost.
        if (wo.z * side < 0.0) != crosses {
            return None;
        }
        weighed(self.eval(wi, wo), self.pdf(wi, wo), wo, eta, scattering)
    }
}

/// Smith's visibility of GGX facets with α = 1/4, by which the second coat is shadowed.
fn coat_shadowing(v: DVec3, m: DVec3) -> f64 {
    if v.dot(m) * v.z <= 0.0 {
        return 0.0;
    }
    let cos2 = v.z * v.z;
    2.0 / (1.0 + (1.0 + 0.0625 * (1.0 - cos2) / cos2).sqrt())
}

/// Black where quotients of two zeros at grazing angles are not finite.
fn finite(value: Rgb) -> Rgb {
    if value.is_finite() { value } else { Rgb::BLACK }
}
