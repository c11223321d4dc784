//! A glass ball on the axis of a light, and the plane behind it.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::radial::STEEPEST;
use super::{KnownPath, RadialMap, RadialSheet};
use crate::numeric::math;
use crate::optics::dielectric_reflectance;

/// A light on the axis of a round scene, shining along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxialLight {
    /// A point on the axis.
    Point {
        /// Height above the receiver's plane (m).
        height: f64,
        /// Radiant intensity [W/sr].
        intensity: f64,
    },
    /// Parallel light along the axis.
    Parallel {
        /// Irradiance on a plane across the axis [W/m²].
        irradiance: f64,
    },
}

/// A glass ball between a light on its axis and a plane across that axis: all light on the plane.
///
/// By symmetry every ray stays in a plane through the axis. Let θ be its angle to the axis (0: straight down)
/// and i its angle of incidence on the ball of radius R whose centre is D below the light. Then
///
/// ```text
/// sin θ = (R/D) sin i,   sin t = sin i / n,   a₀ = i − θ
/// ```
///
/// with a₀ the place of the hit, as an angle at the centre, from the top. A chord inside spans π − 2t at the
/// centre, so after k internal reflections the ray leaves at a = a₀ + (k + 1)(π − 2t). It is
/// turned by i − t on the way in and again on the way out, by π − 2t at each reflection:
///
/// ```text
/// δ = θ − 2(i − t) − k (π − 2t)         from straight down
/// r = R sin a + (h + R cos a) tan δ     where it meets the plane, h below the centre; only if cos δ > 0
/// dΦ = 2π I sin θ dθ · (1 − F)² F^k = 2π I (R/D)² (sin i cos i / cos θ) (1 − F)² F^k di
/// ```
///
/// with F(i) Fresnel's reflectance, the same inside and outside. A ray reflected from outside leaves at a₀
/// and δ = θ + π − 2i, with F. In i (instead of θ) all of it is smooth up to grazing incidence. For parallel
/// light θ = 0 and dΦ = 2π E R² sin i cos i di. (The deflections are those of the rainbow: van de Hulst,
/// *Light Scattering by Small Particles*, 12.22.)
///
/// The ball must lie above the plane and below the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlassBall {
    /// Radius R (m).
    pub radius: f64,
    /// The centre's height h over the plane (m), more than R.
    pub center_height: f64,
    /// The index n of the ball relative to its surroundings; at least 1.
    pub ior: f64,
    /// The light over it.
    pub light: AxialLight,
}

impl GlassBall {
    /// The ball of the shipped scene `glass-ball`.
    pub const SHIPPED: Self = Self {
        radius: 1.0,
        center_height: 1.4,
        ior: 1.5,
        light: AxialLight::Point {
            height: 4.0,
            intensity: 100.0,
        },
    };

    /// One path's light on the plane.
    pub fn sheet(&self, path: KnownPath) -> RadialSheet {
        match path {
            KnownPath::Direct => RadialSheet::new(PastTheBall(*self)),
            _ => RadialSheet::new(ByTheBall { ball: *self, path }),
        }
    }

    /// The radius (m) of the disc on the plane that sees nothing of the light directly.
    pub fn shadow_radius(&self) -> f64 {
        match self.light {
            AxialLight::Point { height, .. } => height * math::tan(self.widest_angle()),
            AxialLight::Parallel { .. } => self.radius,
        }
    }

    /// The flux (W) that falls on the ball.
    pub fn intercepted_flux(&self) -> f64 {
        match self.light {
            AxialLight::Point { intensity, .. } => {
                let half_sin = math::sin(0.5 * self.widest_angle());
                2.0 * TAU * intensity * half_sin * half_sin
            }
            AxialLight::Parallel { irradiance } => irradiance * PI * self.radius * self.radius,
        }
    }

    /// The angle to the axis of a ray that grazes the ball.
    fn widest_angle(&self) -> f64 {
        match self.light {
            AxialLight::Point { height, .. } => {
                math::asin(self.radius / (height - self.center_height))
            }
            AxialLight::Parallel { .. } => 0.0,
        }
    }

    /// The angle θ to the axis, and the flux per unit of i, of light that falls onto the ball at the
    /// incidence i.
    fn incoming(&self, incidence: f64) -> (f64, f64) {
        let (sin, cos) = math::sin_cos(incidence);
        match self.light {
            AxialLight::Point { height, intensity } => {
                let ratio = self.radius / (height - self.center_height);
                let angle = math::asin(ratio * sin);
                (
                    angle,
                    TAU * intensity * ratio * ratio * sin * cos / math::cos(angle),
                )
            }
            AxialLight::Parallel { irradiance } => (
                0.0,
                TAU * irradiance * self.radius * self.radius * sin * cos,
            ),
        }
    }
}

/// Light that meets the ball; u = i.
struct ByTheBall {
    ball: GlassBall,
    path: KnownPath,
}

impl RadialMap for ByTheBall {
    fn range(&self) -> (f64, f64) {
        (0.0, FRAC_PI_2)
    }

    fn radius(&self, u: f64) -> Option<f64> {
        let GlassBall {
            radius,
            center_height,
            ior,
            ..
        } = self.ball;
        let (angle, _) = self.ball.incoming(u);
        let hit = u - angle;
        let (place, direction) = match self.path {
            KnownPath::Through(reflections) => {
                let refracted = math::asin(math::sin(u) / ior);
                let turn = PI - 2.0 * refracted;
                let k = f64::from(reflections);
                (
                    hit + (k + 1.0) * turn,
                    angle - 2.0 * (u - refracted) - k * turn,
                )
            }
            _ => (hit, angle + PI - 2.0 * u),
        };
        let (sin, cos) = math::sin_cos(direction);
        let height = center_height + radius * math::cos(place);
        (cos > 1e-12).then(|| radius * math::sin(place) + height * sin / cos)
    }

    fn flux_density(&self, u: f64) -> f64 {
        let (_, flux) = self.ball.incoming(u);
        let reflectance = dielectric_reflectance(math::cos(u), self.ball.ior);
        flux * match self.path {
            KnownPath::Through(reflections) => {
                math::powi(1.0 - reflectance, 2) * math::powf(reflectance, f64::from(reflections))
            }
            // A ball reflects a ray from outside once at most.
            KnownPath::Reflected(1) => reflectance,
            _ => 0.0,
        }
    }
}

/// Light that misses the ball; u = θ, or the distance from the axis in parallel light.
struct PastTheBall(GlassBall);

impl RadialMap for PastTheBall {
    fn range(&self) -> (f64, f64) {
        match self.0.light {
            AxialLight::Point { .. } => (self.0.widest_angle(), STEEPEST),
            // Parallel light has no end: far beyond any receiver.
            AxialLight::Parallel { .. } => (self.0.radius, 1e3 * self.0.center_height),
        }
    }

    fn radius(&self, u: f64) -> Option<f64> {
        match self.0.light {
            AxialLight::Point { height, .. } => Some(height * math::tan(u)),
            AxialLight::Parallel { .. } => Some(u),
        }
    }

    fn flux_density(&self, u: f64) -> f64 {
        match self.0.light {
            AxialLight::Point { intensity, .. } => TAU * intensity * math::sin(u),
            AxialLight::Parallel { irradiance } => TAU * irradiance * u,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{TexelGrid, TexelRect};
    use super::*;

    /// The bundled scene.
    const BALL: GlassBall = GlassBall::SHIPPED;

    #[test]
    fn all_paths_together_carry_what_falls_on_the_ball() {
        for light in [BALL.light, AxialLight::Parallel { irradiance: 7.0 }] {
            let ball = GlassBall { light, ..BALL };
            let through: f64 = (0..40)
                .map(|k| ball.sheet(KnownPath::Through(k)).sent_flux())
                .sum();
            let all = ball.sheet(KnownPath::Reflected(1)).sent_flux() + through;
            // What 40 internal reflections leave: near grazing, F^40 (1 - F)² / (1 - F) < 0.01 of a sliver.
            let exact = ball.intercepted_flux();
            let rest = ball.sheet(KnownPath::Through(40)).sent_flux();
            assert!(all < exact * (1.0 + 1e-12));
            assert!(
                exact - all < 40.0 * rest && rest < 1e-4 * exact,
                "{all} {exact} {rest}"
            );
        }
    }

    #[test]
    fn near_the_axis_light_meets_at_the_thick_lenss_focus() {
        // A ball's focal length is n R / (2 (n - 1)) = 1.5 from the centre: with the plane there,
        // r = O(i³) for parallel light.
        let ball = GlassBall {
            center_height: 1.5,
            light: AxialLight::Parallel { irradiance: 1.0 },
            ..BALL
        };
        let map = ByTheBall {
            ball,
            path: KnownPath::Through(0),
        };
        let radius = |u: f64| map.radius(u).unwrap();
        let ratio = radius(2e-2) / radius(1e-2);
        // r = c i³ (1 + O(i²)): the ratio is 8 up to a few times 4e-4.
        assert!((ratio - 8.0).abs() < 8.0 * 10.0 * 4e-4, "{ratio}");
    }

    #[test]
    fn an_index_of_one_leaves_the_light_as_it_was() {
        let ball = GlassBall { ior: 1.0, ..BALL };
        let texel = TexelRect::new(0.11, 0.4, 0.13, 0.42);
        let solid_angle =
            |x: f64, y: f64| math::atan(x * y / (4.0 * (16.0 + x * x + y * y).sqrt()));
        let exact = 100.0
            * (solid_angle(0.13, 0.42) - solid_angle(0.11, 0.42) - solid_angle(0.13, 0.4)
                + solid_angle(0.11, 0.4));
        let flux = ball.sheet(KnownPath::Through(0)).texel_flux(&texel);
        // Four angles of size 0.05, each with an ulp of 1e-17 and its difference 2.5e-5 of their size.
        assert!((flux / exact - 1.0).abs() < 1e-10, "{flux} {exact}");
        assert_eq!(ball.sheet(KnownPath::Through(1)).texel_flux(&texel), 0.0);
    }

    #[test]
    fn the_plane_and_the_rays_that_miss_it_add_up() {
        let sheet = BALL.sheet(KnownPath::Through(0));
        let grid = TexelGrid::square(2.0, 64);
        let on_floor: f64 = grid.map(|texel| sheet.texel_flux(texel)).iter().sum();
        // The marginal ray lands at 1.23: all of it is on the floor.
        assert!((on_floor / sheet.sent_flux() - 1.0).abs() < 1e-10);
        assert!((sheet.landed_flux() / sheet.sent_flux() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_texel_on_the_ring_agrees_with_brute_force() {
        let map = ByTheBall {
            ball: BALL,
            path: KnownPath::Through(0),
        };
        let sheet = BALL.sheet(KnownPath::Through(0));
        let fold = sheet.fold_radii()[0];
        let texel = TexelRect::new(fold - 0.005, -0.002, fold + 0.003, 0.006);
        let count = 4_000_000;
        let step = FRAC_PI_2 / f64::from(count);
        let brute: f64 = (0..count)
            .map(|j| {
                let u = step * (f64::from(j) + 0.5);
                let radius = map.radius(u).unwrap().abs();
                let fraction: f64 = texel
                    .quadrant_parts()
                    .map(|part| super::super::circle::circle_fraction(radius, &part))
                    .sum();
                map.flux_density(u) * fraction * step
            })
            .sum();
        let flux = sheet.texel_flux(&texel);
        // The touching circle enters with a square root: the midpoint rule errs by about step^1.5 there,
        // 3e-10 times the slope's size, 100 W / 0.03, on 0.1 W.
        assert!((flux / brute - 1.0).abs() < 1e-5, "{flux} {brute}");
    }

    #[test]
    fn the_shadow_is_dark_and_beyond_it_the_inverse_square_holds() {
        let sheet = BALL.sheet(KnownPath::Direct);
        let shadow = BALL.shadow_radius();
        assert_eq!(sheet.texel_flux(&TexelRect::new(-0.1, -0.1, 0.1, 0.1)), 0.0);
        assert_eq!(sheet.disc_flux(shadow * (1.0 - 1e-12)), 0.0);
        let texel = TexelRect::new(1.9, 0.0, 1.9001, 0.0001);
        let distance_squared: f64 = 16.0 + 1.90005 * 1.90005 + 0.00005 * 0.00005;
        let exact = 100.0 * 4.0 / math::powf(distance_squared, 1.5);
        // The mean over a texel differs from the middle by E''·h²/24 ~ 1e-10.
        assert!((sheet.texel_irradiance(&texel) / exact - 1.0).abs() < 1e-9);
    }
}
