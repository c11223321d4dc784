//! The distribution of facets' normals, and the share of facets that others hide.

use glam::DVec3;

use super::{beckmann, ggx};
use crate::numeric::math;

/// The shape of the distribution of facets' slopes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FacetDistribution {
    /// Slopes of a Gaussian random surface; α/√2 is their standard deviation along an axis.
    Beckmann,
    /// Slopes with long tails, those of a stretched sphere (Trowbridge and Reitz).
    Ggx,
}

/// A rough surface: the distribution of its facets' normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets {
    distribution: FacetDistribution,
    /// Roughness along x and y.
    alpha: [f64; 2],
}

impl Microfacets {
    /// Mitsuba's lower limit of α, which replaces all smaller values.
    pub const SMALLEST_ALPHA: f64 = 1e-4;

    /// Facets with roughness `alpha` along x and y; numbers below [`Self::SMALLEST_ALPHA`] mean that, as in
    /// Mitsuba.
    pub fn new(distribution: FacetDistribution, alpha: [f64; 2]) -> Self {
        Self {
            distribution,
            alpha: alpha.map(|alpha| alpha.max(Self::SMALLEST_ALPHA)),
        }
    }

    /// Area of facets with normal `m`, by solid angle and by area of the surface: D(m) [1/sr].
    ///
    /// With a² = `(m_x/α_x)² + (m_y/α_y)²`,
    ///
    /// ```text
    /// Beckmann: D = exp(−a²/m_z²) / (π α_x α_y m_z⁴)
    /// GGX:      D = 1 / (π α_x α_y (a² + m_z²)²)
    /// ```
    ///
    /// (Walter et al. 2007, equations 25 and 33; with two α Heitz, *Understanding the Masking-Shadowing
    /// Function*, JCGT 2014, equations 80 and 85.) Its integral over the upper half of directions, times
    /// `m_z`, is 1. Zero for `m_z` ≤ 0.
    #[inline]
    pub fn density(&self, m: DVec3) -> f64 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let [x, y] = [m.x / self.alpha[0], m.y / self.alpha[1]];
        let squared = x * x + y * y;
        let scale = std::f64::consts::PI * self.alpha[0] * self.alpha[1];
        match self.distribution {
            FacetDistribution::Beckmann => {
                let z_squared = m.z * m.z;
                let density = math::exp(-squared / z_squared) / (scale * z_squared * z_squared);
                // The quotient of two zeros far out on the rim.
                if density.is_finite() { density } else { 0.0 }
            }
            FacetDistribution::Ggx => {
                let sum = squared + m.z * m.z;
                1.0 / (scale * sum * sum)
            }
        }
    }

    /// α tan θ of a direction, squared: the surface's roughness as seen along it.
    #[inline]
    fn slant_squared(&self, v: DVec3) -> f64 {
        let [x, y] = [v.x * self.alpha[0], v.y * self.alpha[1]];
        (x * x + y * y) / (v.z * v.z)
    }

    /// The share (0..=1) of facets with normal `m`, seen along `v`, that others do not hide: Smith's G₁ as
    /// Mitsuba computes it.
    ///
    /// Zero if `v` sees the back of such a facet from the front of the surface, or its front from the back.
    /// For Beckmann's distribution this is the rational fit of Walter et al. 2007, equation 27. It is within
    /// 0.35 % of the exact function, which [`Self::visible_density`] uses.
    #[inline]
    pub fn shadowing(&self, v: DVec3, m: DVec3) -> f64 {
        if v.dot(m) * v.z <= 0.0 {
            return 0.0;
        }
        match self.distribution {
            FacetDistribution::Beckmann => beckmann::fitted_shadowing(self.slant_squared(v)),
            FacetDistribution::Ggx => ggx::shadowing(self.slant_squared(v)),
        }
    }

    /// [`Self::shadowing`] without a fit, with which the visible normals are a distribution.
    #[inline]
    fn exact_shadowing(&self, v: DVec3, m: DVec3) -> f64 {
        if v.dot(m) * v.z <= 0.0 {
            return 0.0;
        }
        match self.distribution {
            FacetDistribution::Beckmann => beckmann::shadowing(self.slant_squared(v)),
            FacetDistribution::Ggx => ggx::shadowing(self.slant_squared(v)),
        }
    }

    /// The density [1/sr] of the normals that [`Self::sample_visible`] draws: `G₁(v, m) D(m) (v·m) / v_z`.
    ///
    /// `v` must be on the upper side.
    #[inline]
    pub fn visible_density(&self, v: DVec3, m: DVec3) -> f64 {
        let density = self.density(m) * self.exact_shadowing(v, m) * v.dot(m) / v.z;
        if density.is_finite() { density } else { 0.0 }
    }

    /// A facet normal, drawn from those seen along `v` in proportion to the area they show.
    ///
    /// Heitz and d'Eon, *Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible
    /// Normals* (EGSR 2014): stretch the surface until α = 1, draw a slope there, undo the stretch. `v` must
    /// be on the upper side; `u` uniform in [0, 1).
    pub fn sample_visible(&self, v: DVec3, u: [f64; 2]) -> DVec3 {
        let view = StretchedView::new(self, v);
        let slope = match self.distribution {
            FacetDistribution::Beckmann => [
                beckmann::slope_along(view.sin, view.cos, u[0]),
                beckmann::slope_across(u[1]),
            ],
            FacetDistribution::Ggx => ggx::visible_slope(view.sin, view.cos, u),
        };
        view.normal(self, slope)
    }

    /// [`Self::sample_visible`] for all pairs of `nodes`, the second number running faster.
    pub(super) fn visible_normals(&self, v: DVec3, nodes: &[f64]) -> Vec<DVec3> {
        let view = StretchedView::new(self, v);
        let pairs = |of: &dyn Fn(usize, usize) -> [f64; 2]| {
            let all = (0..nodes.len()).flat_map(|i| (0..nodes.len()).map(move |j| (i, j)));
            all.map(|(i, j)| view.normal(self, of(i, j))).collect()
        };
        match self.distribution {
            FacetDistribution::Beckmann => {
                let along = |&u: &f64| beckmann::slope_along(view.sin, view.cos, u);
                let along: Vec<f64> = nodes.iter().map(along).collect();
                let across: Vec<f64> = nodes.iter().map(|&u| beckmann::slope_across(u)).collect();
                pairs(&|i, j| [along[i], across[j]])
            }
            FacetDistribution::Ggx => {
                pairs(&|i, j| ggx::visible_slope(view.sin, view.cos, [nodes[i], nodes[j]]))
            }
        }
    }
}

/// A view of the surface, stretched so that α = 1.
struct StretchedView {
    /// Sine and cosine of the angle off the normal.
    sin: f64,
    cos: f64,
    /// Sine and cosine of the azimuth.
    sin_phi: f64,
    cos_phi: f64,
}

impl StretchedView {
    fn new(facets: &Microfacets, v: DVec3) -> Self {
        let [alpha_x, alpha_y] = facets.alpha;
        let stretched = DVec3::new(alpha_x * v.x, alpha_y * v.y, v.z).normalize();
        let sin = math::hypot(stretched.x, stretched.y);
        let (cos_phi, sin_phi) = if sin > 0.0 {
            (stretched.x / sin, stretched.y / sin)
        } else {
            (1.0, 0.0)
        };
        Self {
            sin,
            cos: stretched.z,
            sin_phi,
            cos_phi,
        }
    }

    /// The normal of the facet with a slope along and across the view.
    fn normal(&self, facets: &Microfacets, [along, across]: [f64; 2]) -> DVec3 {
        let x = (self.cos_phi * along - self.sin_phi * across) * facets.alpha[0];
        let y = (self.sin_phi * along + self.cos_phi * across) * facets.alpha[1];
        DVec3::new(-x, -y, 1.0).normalize()
    }
}
