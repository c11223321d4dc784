//! A plano-convex lens on the axis of a light.

use std::f64::consts::TAU;

use super::{AxialLight, RadialMap, RadialSheet};
use crate::numeric::math;
use crate::optics::dielectric_reflectance;

/// A plano-convex lens, curved side towards a light on its axis: the light it lets through (path `LTTD`) on
/// the plane behind it.
///
/// Let a be the angle of a point of the curved side (radius R) at its centre, from the axis. The point lies
/// at x = R sin a; light that meets it at the angle θ to the axis has the incidence i = θ + a, is refracted
/// to sin t = sin i / n, and goes on towards the axis at δ₁ = a − t. The flat side bends it to sin δ₂ = n sin
/// δ₁ (or reflects it totally), and it lands at
///
/// ```text
/// r = x − (z − z₀) tan δ₁ − z₀ tan δ₂,
/// dΦ = 2π I sin θ (dθ/da) (1 − F(i)) (1 − F(δ₁)) da,   dθ/da = R (H cos a − R) / (H² + R² − 2 H R cos a)
/// ```
///
/// with z₀ the flat side's height and H the distance of the light from the centre. In parallel light θ = 0,
/// and the flux is 2π E R² sin a cos a da. This is meridional ray tracing in closed form (Born and Wolf,
/// 4.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanoConvexLens {
    /// R (m).
    pub curvature: f64,
    /// Half the lens's width (m), less than R.
    pub aperture: f64,
    /// The height z₀ of the flat side over the plane (m).
    pub flat_height: f64,
    /// The index n relative to the surroundings.
    pub ior: f64,
    /// The light over it. A spot that is constant over the lens counts as a point.
    pub light: AxialLight,
}

impl PlanoConvexLens {
    /// The light of path `LTTD` on the plane.
    pub fn sheet(&self) -> RadialSheet {
        RadialSheet::new(ThroughTheLens(*self))
    }

    /// The angle to the axis (rad) of light that just grazes the rim: within it nothing is direct.
    pub fn rim_angle(&self) -> f64 {
        match self.light {
            AxialLight::Point { height, .. } => {
                math::atan(self.aperture / (height - self.flat_height))
            }
            AxialLight::Parallel { .. } => 0.0,
        }
    }

    fn center_height(&self) -> f64 {
        self.flat_height - (self.curvature * self.curvature - self.aperture * self.aperture).sqrt()
    }

    /// The angles θ, i, t, δ₁ of the ray through the point at the angle `a`.
    fn angles(&self, a: f64) -> (f64, f64, f64) {
        let (sin, cos) = math::sin_cos(a);
        let incoming = match self.light {
            AxialLight::Point { height, .. } => math::atan2(
                self.curvature * sin,
                height - self.center_height() - self.curvature * cos,
            ),
            AxialLight::Parallel { .. } => 0.0,
        };
        let incidence = incoming + a;
        (
            incoming,
            incidence,
            a - math::asin(math::sin(incidence) / self.ior),
        )
    }
}

struct ThroughTheLens(PlanoConvexLens);

impl RadialMap for ThroughTheLens {
    fn range(&self) -> (f64, f64) {
        (0.0, math::asin(self.0.aperture / self.0.curvature))
    }

    fn radius(&self, u: f64) -> Option<f64> {
        let lens = &self.0;
        let (_, _, inside) = lens.angles(u);
        let (sin, cos) = math::sin_cos(u);
        let above_flat = lens.center_height() + lens.curvature * cos - lens.flat_height;
        let at_flat = lens.curvature * sin - above_flat * math::tan(inside);
        let sin_out = lens.ior * math::sin(inside);
        let leaves = sin_out.abs() < 1.0 && at_flat.abs() <= lens.aperture;
        leaves.then(|| {
            at_flat - lens.flat_height * sin_out / ((1.0 - sin_out) * (1.0 + sin_out)).sqrt()
        })
    }

    fn flux_density(&self, u: f64) -> f64 {
        let lens = &self.0;
        let (incoming, incidence, inside) = lens.angles(u);
        let (sin, cos) = math::sin_cos(u);
        let radius = lens.curvature;
        let flux = match lens.light {
            AxialLight::Point { height, intensity } => {
                let distance = height - lens.center_height();
                let turn = radius * (distance * cos - radius)
                    / (distance * distance + radius * radius - 2.0 * distance * radius * cos);
                TAU * intensity * math::sin(incoming) * turn
            }
            AxialLight::Parallel { irradiance } => TAU * irradiance * radius * radius * sin * cos,
        };
        let enter = dielectric_reflectance(math::cos(incidence), lens.ior);
        let leave = dielectric_reflectance(math::cos(inside), lens.ior.recip());
        flux * (1.0 - enter) * (1.0 - leave)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: PlanoConvexLens = PlanoConvexLens {
        curvature: 0.06,
        aperture: 0.05,
        flat_height: 0.06,
        ior: 1.5,
        light: AxialLight::Point {
            height: 0.56,
            intensity: 10.0,
        },
    };

    #[test]
    fn near_the_axis_the_lens_makers_formula_holds() {
        // Parallel light: the back focal distance of a plano-convex lens, curved side first, is
        // f - d/n behind the flat side, with f = R / (n - 1) and d its thickness.
        let thickness = 0.06 - (math::powi(0.06_f64, 2) - math::powi(0.05_f64, 2)).sqrt();
        let lens = PlanoConvexLens {
            flat_height: 0.06 / 0.5 - thickness / 1.5,
            light: AxialLight::Parallel { irradiance: 1.0 },
            ..LENS
        };
        let map = ThroughTheLens(lens);
        let ratio = map.radius(2e-2).unwrap() / map.radius(1e-2).unwrap();
        // Spherical aberration is of third order in a; the next order is 4e-4 of it, times a few.
        assert!((ratio - 8.0).abs() < 8.0 * 10.0 * 4e-4, "{ratio}");
    }

    #[test]
    fn an_index_of_one_leaves_a_point_lights_irradiance() {
        let sheet = PlanoConvexLens { ior: 1.0, ..LENS }.sheet();
        // 2π I (1 - cos θ) within the radius r.
        let exact = TAU * 10.0 * (1.0 - 0.56 / math::hypot(0.56_f64, 0.03));
        assert!(
            (sheet.disc_flux(0.03) / exact - 1.0).abs() < 1e-11,
            "{exact}"
        );
    }

    #[test]
    fn the_light_that_enters_is_what_the_rims_cone_holds_less_what_is_reflected() {
        let sheet = LENS.sheet();
        let cone = TAU * 10.0 * (1.0 - math::cos(LENS.rim_angle()));
        let through = sheet.sent_flux() / cone;
        // At normal incidence each side lets 0.96 pass; the rim's incidence is asin(5/6) + 5.7°, where F <
        // 0.15.
        assert!(through < 0.96 * 0.96 && through > 0.85 * 0.85, "{through}");
        assert_eq!(sheet.fold_radii().len(), 1);
    }
}
