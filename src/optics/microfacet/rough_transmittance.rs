//! Transmittance of rough interfaces, over all directions together.

use glam::DVec3;

use super::facets::{FacetDistribution, Microfacets};
use crate::numeric::quadrature::GaussLegendre;
use crate::optics::{dielectric_reflectance, reflect, refract};

/// Transmittance and internal reflectance of plastic's rough coat, tabulated as Mitsuba's `roughplastic`
/// does.
#[derive(Clone, Debug, PartialEq)]
pub struct RoughTransmittance {
    /// The share of light that enters, at cosines evenly spaced over 0..=1.
    entering: Vec<f64>,
    /// The share of diffuse light from below that is reflected back.
    internal_reflectance: f64,
}

/// Mitsuba's number of cosines.
const ENTRIES: usize = 64;

impl RoughTransmittance {
    /// The table for a rough interface with `eta` = `n_inside / n_outside`, other than 1.
    ///
    /// Single scattering: light that would meet a second facet counts neither as reflected nor as
    /// transmitted.
    pub fn new(distribution: FacetDistribution, alpha: f64, eta: f64) -> Self {
        let facets = Microfacets::new(distribution, [alpha; 2]);
        let cosines = (0..ENTRIES).map(|i| (i as f64 / (ENTRIES - 1) as f64).max(1e-6));
        let [from_outside, from_inside] = [eta, 1.0 / eta].map(Rule::new);
        let entering = cosines
            .clone()
            .map(|cos| from_outside.mean(&facets, cos, |v, m| transmitted(&facets, v, m, eta)))
            .collect();
        let kept: f64 = cosines
            .map(|cos| {
                cos * from_inside.mean(&facets, cos, |v, m| reflected(&facets, v, m, 1.0 / eta))
            })
            .sum();
        Self {
            entering,
            internal_reflectance: 2.0 * kept / ENTRIES as f64,
        }
    }

    /// The share of light that enters at an angle, by linear interpolation; `cos` in 0..=1.
    #[inline]
    pub fn entering(&self, cos: f64) -> f64 {
        let place = cos * (ENTRIES - 1) as f64;
        let index = (place as usize).min(ENTRIES - 2);
        let weight = place - index as f64;
        self.entering[index] * (1.0 - weight) + self.entering[index + 1] * weight
    }

    /// The share of diffuse light from below that the interface reflects back: 2 ∫ F(μ) μ dμ, as the mean
    /// over the table's cosines.
    #[inline]
    pub fn internal_reflectance(&self) -> f64 {
        self.internal_reflectance
    }
}

/// A quadrature over visible normals.
struct Rule {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

impl Rule {
    /// The rule with as many nodes as Mitsuba takes: total reflection makes an edge, which needs more.
    fn new(eta: f64) -> Self {
        let count = if eta > 1.0 { 32 } else { 128 };
        let rule = GaussLegendre::new(count).into_iter();
        let (nodes, weights) = rule
            .flat_map(|rule| rule.on(0.0, 1.0).collect::<Vec<_>>())
            .unzip();
        Self { nodes, weights }
    }

    /// The mean of `share` over the visible normals of a direction at an angle.
    fn mean(&self, facets: &Microfacets, cos: f64, share: impl Fn(DVec3, DVec3) -> f64) -> f64 {
        let v = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        let normals = facets.visible_normals(v, &self.nodes);
        let mut sum = 0.0;
        for (row, weight_x) in normals.chunks(self.nodes.len()).zip(&self.weights) {
            for (&m, weight_y) in row.iter().zip(&self.weights) {
                sum += weight_x * weight_y * share(v, m);
            }
        }
        sum
    }
}

/// The share of a facet's light that it mirrors to the upper side, past all other facets.
fn reflected(facets: &Microfacets, v: DVec3, m: DVec3, eta: f64) -> f64 {
    let wo = reflect(-v, m);
    if wo.z <= 0.0 {
        return 0.0;
    }
    dielectric_reflectance(v.dot(m), eta) * facets.shadowing(wo, m)
}

/// The share of a facet's light that it refracts to the lower side, past all other facets.
fn transmitted(facets: &Microfacets, v: DVec3, m: DVec3, eta: f64) -> f64 {
    match refract(-v, m, eta) {
        Some(wo) if wo.z < 0.0 => {
            (1.0 - dielectric_reflectance(v.dot(m), eta)) * facets.shadowing(wo, m)
        }
        _ => 0.0,
    }
}
