//! Light with nothing in its way.

use std::f64::consts::TAU;

use glam::DVec3;

use super::radial::STEEPEST;
use super::{RadialMap, RadialSheet, TexelRect};
use crate::numeric::math;

/// The irradiance [W/m²] of a surface point from a uniform diffuse polygon, by Lambert's formula.
///
/// ```text
/// E = L/2 Σ_j Θ_j (Γ_j · n),   Θ_j = angle between v_j and v_j+1,   Γ_j = (v_j+1 × v_j) / |v_j+1 × v_j|
/// ```
///
/// with vⱼ the unit vectors to the corners (Lambert, *Photometria*, 1760; Schröder and Hanrahan, *On the form
/// factor between two polygons*, 1993, eq. 4). The part of the polygon below the point's horizon is cut off
/// first.
///
/// - `normal`: the unit normal of the lit surface.
/// - `corners`: of a planar polygon, counter-clockwise as seen from `point`; clockwise corners (the polygon's
///   back side) give 0.
/// - `radiance`: L [W/m²/sr].
///
/// A point in the polygon's plane receives 0.
pub fn lambert_irradiance(point: DVec3, normal: DVec3, corners: &[DVec3], radiance: f64) -> f64 {
    let above = above_horizon(point, normal, corners);
    let Some(&last) = above.last() else {
        return 0.0;
    };
    let mut before = last.normalize();
    let mut sum = 0.0;
    for corner in above {
        let here = corner.normalize();
        let cross = here.cross(before);
        let sin = cross.length();
        if sin > 0.0 {
            // The angle over its sine: atan2 is exact for small and for obtuse angles.
            sum += math::atan2(sin, before.dot(here)) / sin * cross.dot(normal);
        }
        before = here;
    }
    (0.5 * radiance * sum).max(0.0)
}

/// The polygon's part above the horizon, relative to `point`.
fn above_horizon(point: DVec3, normal: DVec3, corners: &[DVec3]) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    let Some(&last) = corners.last() else {
        return kept;
    };
    let mut before = last - point;
    for &corner in corners {
        let here = corner - point;
        let (height_before, height) = (before.dot(normal), here.dot(normal));
        if (height_before < 0.0) != (height < 0.0) {
            kept.push(before + (here - before) * (height_before / (height_before - height)));
        }
        if height >= 0.0 {
            kept.push(here);
        }
        before = here;
    }
    kept.retain(|corner| *corner != DVec3::ZERO);
    kept
}

/// The irradiance [W/m²], averaged over a texel of the plane z = 0 (facing up), from a point of `intensity` I
/// [W/sr] above it.
///
/// I Ω / A with Ω the texel's solid angle: exact, as the sum over the corners of
/// ± atan(x y / (h √(h² + x² + y²))). A light on or below the plane gives 0.
pub fn point_irradiance(position: DVec3, intensity: f64, texel: &TexelRect) -> f64 {
    let height = position.z;
    if height <= 0.0 {
        return 0.0;
    }
    let (min, max) = (
        texel.min - position.truncate(),
        texel.max - position.truncate(),
    );
    let corner =
        |x: f64, y: f64| math::atan(x * y / (height * (height * height + x * x + y * y).sqrt()));
    let solid_angle =
        corner(max.x, max.y) - corner(min.x, max.y) - corner(max.x, min.y) + corner(min.x, min.y);
    intensity * solid_angle / texel.area()
}

/// The irradiance [W/m²] of a plane in parallel light: E |cos| on its front side, 0 on its back.
///
/// - `direction`: of travel, a unit vector; `normal`: of the plane, a unit vector.
/// - `irradiance`: E across the light [W/m²].
pub fn parallel_irradiance(direction: DVec3, irradiance: f64, normal: DVec3) -> f64 {
    irradiance * (-direction.dot(normal)).max(0.0)
}

/// A spot light's intensity at an angle to its axis, as a fraction of that on the axis: 1 up to `beam_width`,
/// then falling linearly in the angle to 0 at `cutoff_angle` (Mitsuba's `spot`). All angles in radians.
pub fn spot_falloff(angle: f64, cutoff_angle: f64, beam_width: f64) -> f64 {
    if angle <= beam_width {
        1.0
    } else if angle < cutoff_angle {
        (cutoff_angle - angle) / (cutoff_angle - beam_width)
    } else {
        0.0
    }
}

/// A spot light that looks straight down onto the plane z = 0 from the z axis, with a round obstacle on the
/// axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialSpot {
    /// Height over the plane (m).
    pub height: f64,
    /// Intensity on the axis [W/sr].
    pub intensity: f64,
    /// Angle (rad) to the axis at which the light ends.
    pub cutoff_angle: f64,
    /// Angle (rad) to the axis up to which the light is constant.
    pub beam_width: f64,
    /// Angle (rad) to the axis within which light is stopped; 0 for no obstacle.
    pub blocked_angle: f64,
}

impl AxialSpot {
    /// The direct light as the sum of two sheets: the constant middle and the fading border.
    pub fn sheets(&self) -> [RadialSheet; 2] {
        let knee = self.beam_width.max(self.blocked_angle);
        let ring = |from: f64, to: f64| {
            RadialSheet::new(SpotRing {
                spot: *self,
                from,
                to: to.max(from).min(STEEPEST),
            })
        };
        [
            ring(self.blocked_angle, knee),
            ring(knee, self.cutoff_angle),
        ]
    }
}

struct SpotRing {
    spot: AxialSpot,
    from: f64,
    to: f64,
}

impl RadialMap for SpotRing {
    fn range(&self) -> (f64, f64) {
        (self.from, self.to)
    }

    fn radius(&self, u: f64) -> Option<f64> {
        Some(self.spot.height * math::tan(u))
    }

    fn flux_density(&self, u: f64) -> f64 {
        TAU * self.spot.intensity
            * math::sin(u)
            * spot_falloff(u, self.spot.cutoff_angle, self.spot.beam_width)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_4, PI};

    use super::*;

    fn square(half: f64, height: f64) -> [DVec3; 4] {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
            .map(|(x, y)| DVec3::new(half * x, half * y, height))
    }

    #[test]
    fn under_an_endless_ceiling_the_irradiance_is_pi_times_the_radiance() {
        let irradiance = lambert_irradiance(DVec3::ZERO, DVec3::Z, &square(1e9, 1.0), 3.0);
        // What is missing is the view beyond 1e9 heights: a few times 1e-18; the angles are right to an ulp
        // each.
        assert!((irradiance - 3.0 * PI).abs() < 1e-14, "{irradiance}");
        assert_eq!(
            lambert_irradiance(DVec3::new(0.0, 0.0, 2.0), DVec3::Z, &square(1.0, 1.0), 3.0),
            0.0
        );
    }

    #[test]
    fn lamberts_formula_is_the_integral_over_the_lamp() {
        let point = DVec3::new(0.4, -0.3, 0.1);
        let normal = DVec3::new(0.2, 0.1, 1.0).normalize();
        let lamp = square(0.25, 1.98);
        let side = 400;
        let cell = 0.5 / f64::from(side);
        let mut sum = 0.0;
        for i in 0..side * side {
            let (x, y) = (f64::from(i % side), f64::from(i / side));
            let on_lamp = DVec3::new(-0.25 + cell * (x + 0.5), -0.25 + cell * (y + 0.5), 1.98);
            let to = on_lamp - point;
            let distance = to.length();
            sum += 40.0 * cell * cell * (to.z / distance) * (to.dot(normal) / distance)
                / (distance * distance);
        }
        let exact = lambert_irradiance(point, normal, &lamp, 40.0);
        // Midpoint rule: relative error of about cell²/24 · 12/d² ~ 3e-7.
        assert!((sum / exact - 1.0).abs() < 1e-6, "{sum} {exact}");
    }

    #[test]
    fn a_lamp_half_below_the_horizon_counts_by_its_upper_half() {
        // A wall facing the point from x = 1, seen from a floor: only z > 0 counts.
        let wall = |low: f64| {
            [(1.0, low), (-1.0, low), (-1.0, 1.0), (1.0, 1.0)].map(|(y, z)| DVec3::new(1.0, y, z))
        };
        let facing = lambert_irradiance(DVec3::ZERO, DVec3::Z, &wall(0.0), 1.0);
        assert!(facing > 0.0);
        let cut = lambert_irradiance(DVec3::ZERO, DVec3::Z, &wall(-1.0), 1.0);
        assert!((cut - facing).abs() < 4.0 * f64::EPSILON);
    }

    #[test]
    fn a_small_texel_under_a_point_obeys_the_inverse_square() {
        let position = DVec3::new(1.0, 2.0, 2.0);
        let texel = TexelRect::new(-1e-4, -1e-4, 1e-4, 1e-4);
        // Distance 3, cosine 2/3.
        let exact = 5.0 * (2.0 / 3.0) / 9.0;
        // Differences of angles of size 0.3 over 4e-8/13: 1e-16 · 4 / 3e-9.
        assert!((point_irradiance(position, 5.0, &texel) / exact - 1.0).abs() < 2e-7);
    }

    #[test]
    fn a_spots_whole_flux_is_its_intensity_over_its_cone() {
        let spot = AxialSpot {
            height: 0.56,
            intensity: 10.0,
            cutoff_angle: 0.15,
            beam_width: 0.12,
            blocked_angle: 0.05,
        };
        let flux: f64 = spot.sheets().iter().map(RadialSheet::landed_flux).sum();
        // ∫ 2π I sin θ over the middle, and with (c - θ)/(c - b) over the border, by parts.
        let middle = math::cos(0.05_f64) - math::cos(0.12_f64);
        let border = math::cos(0.12_f64) - (math::sin(0.15_f64) - math::sin(0.12_f64)) / 0.03;
        let exact = TAU * 10.0 * (middle + border);
        // The border's formula differences numbers of size 1 to 1e-3, over 0.03.
        assert!((flux / exact - 1.0).abs() < 1e-11, "{flux} {exact}");
    }

    #[test]
    fn parallel_light_lights_one_side() {
        let direction = DVec3::new(1.0, 0.0, -1.0).normalize();
        assert!(
            (parallel_irradiance(direction, 2.0, DVec3::Z) - 2.0 * math::cos(FRAC_PI_4)).abs()
                < 1e-15
        );
        assert_eq!(parallel_irradiance(direction, 2.0, DVec3::NEG_Z), 0.0);
    }
}
