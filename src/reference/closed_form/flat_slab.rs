//! A pane of glass between a light and a floor.

use std::f64::consts::TAU;

use super::radial::STEEPEST;
use super::{KnownPath, RadialMap, RadialSheet};
use crate::numeric::math;
use crate::optics::dielectric_reflectance;

/// A horizontal plane-parallel slab without borders, over a plane.
///
/// A ray at the angle θ to the vertical crosses it at t, sin t = sin θ / n, leaves it at θ, and after k
/// internal reflections (k even: the rest goes up) has been carried on by (k + 1) d tan t instead of d tan θ:
///
/// ```text
/// r = (H − d) tan θ + (k + 1) d tan t,     dΦ = 2π I sin θ (1 − F)² F^k dθ
/// ```
///
/// for a point light H over the plane and a slab of thickness d, wherever the slab is. Summed over k the
/// transmitted fraction is (1 − F)² / (1 − F²) = (1 − F) / (1 + F).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatSlab {
    /// d (m).
    pub thickness: f64,
    /// The index n relative to the surroundings; at least 1.
    pub ior: f64,
}

impl FlatSlab {
    /// One path's light on the plane below, from a light on the vertical through the origin.
    ///
    /// Only [`KnownPath::Through`] an even number of reflections arrives. In parallel light along the axis
    /// nothing is shifted: use [`FlatSlab::transmitted_fraction`].
    pub fn sheet(&self, light_height: f64, intensity: f64, path: KnownPath) -> RadialSheet {
        RadialSheet::new(ThroughTheSlab {
            slab: *self,
            light_height,
            intensity,
            path,
        })
    }

    /// The fraction (0..=1) of the flux falling onto the slab that leaves it below, by one path;
    /// `cos_incident` as in air.
    pub fn transmitted_fraction(&self, cos_incident: f64, path: KnownPath) -> f64 {
        match path {
            KnownPath::Through(k) if k % 2 == 0 => {
                let reflectance = dielectric_reflectance(cos_incident, self.ior);
                math::powi(1.0 - reflectance, 2) * math::powf(reflectance, f64::from(k))
            }
            _ => 0.0,
        }
    }

    /// Distance (m) by which the slab moves a ray's foot on any plane below, against the direction of travel.
    ///
    /// It is relative to the same ray without the slab: d tan θ − (k + 1) d tan t, negative if k carries it
    /// further.
    pub fn foot_shift(&self, angle: f64, internal_reflections: u32) -> f64 {
        self.thickness
            * (math::tan(angle) - (f64::from(internal_reflections) + 1.0) * self.tan_inside(angle))
    }

    /// sin θ / √(n² − sin² θ), written so that nothing cancels at grazing incidence.
    fn tan_inside(&self, angle: f64) -> f64 {
        let (sin, cos) = math::sin_cos(angle);
        sin / ((self.ior - 1.0) * (self.ior + 1.0) + cos * cos).sqrt()
    }
}

struct ThroughTheSlab {
    slab: FlatSlab,
    light_height: f64,
    intensity: f64,
    path: KnownPath,
}

impl RadialMap for ThroughTheSlab {
    fn range(&self) -> (f64, f64) {
        (0.0, STEEPEST)
    }

    fn radius(&self, u: f64) -> Option<f64> {
        let KnownPath::Through(k) = self.path else {
            return None;
        };
        (k % 2 == 0).then(|| self.light_height * math::tan(u) - self.slab.foot_shift(u, k))
    }

    fn flux_density(&self, u: f64) -> f64 {
        TAU * self.intensity
            * math::sin(u)
            * self.slab.transmitted_fraction(math::cos(u), self.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::thin_slab_reflectance;

    const SLAB: FlatSlab = FlatSlab {
        thickness: 0.5,
        ior: 1.5,
    };

    #[test]
    fn all_reflections_together_are_a_panes_transmittance() {
        for angle in [0.0_f64, 0.5, 1.2, 1.5] {
            let cos = math::cos(angle);
            let sum: f64 = (0..200)
                .map(|k| SLAB.transmitted_fraction(cos, KnownPath::Through(2 * k)))
                .sum();
            // The series' rest is below F^400, at 1.5 rad 0.6^400.
            assert!((sum - (1.0 - thin_slab_reflectance(cos, 1.5))).abs() < 1e-14);
        }
    }

    #[test]
    fn straight_under_the_light_the_slab_brings_it_nearer() {
        // For small angles r = θ (H - d + d/n): the light seems to hang H - d (1 - 1/n) high.
        let sheet = SLAB.sheet(3.0, 10.0, KnownPath::Through(0));
        let apparent = 3.0 - 0.5 / 3.0;
        let exact = 10.0 * 0.96 * 0.96 / (apparent * apparent);
        let texel = super::super::TexelRect::new(-1e-4, -1e-4, 1e-4, 1e-4);
        // θ < 5e-5: corrections of second order below 1e-8.
        assert!((sheet.texel_irradiance(&texel) / exact - 1.0).abs() < 1e-8);
    }

    #[test]
    fn a_slab_of_index_one_shifts_nothing_and_lets_all_pass() {
        let air = FlatSlab { ior: 1.0, ..SLAB };
        assert!(air.foot_shift(0.7, 0).abs() < f64::EPSILON);
        assert_eq!(air.transmitted_fraction(0.3, KnownPath::Through(0)), 1.0);
        let total = air.sheet(1.0, 1.0, KnownPath::Through(0)).landed_flux();
        assert!((total / TAU - 1.0).abs() < 1e-11);
    }
}
