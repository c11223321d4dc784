//! A parabolic dish in parallel light.

use std::f64::consts::{SQRT_2, TAU};

use glam::DVec2;

use super::circle::circle_fraction;
use super::quadrature::{integrate, simpson};
use super::{RadialMap, RadialSheet, TexelGrid, TexelRect};
use crate::numeric::math;
use crate::optics::conductor_reflectance;

/// A metal dish z = r²/(4f) in light that falls straight down: the light (path `LRD`) on a plane below its
/// focus.
///
/// Every ray is reflected through the focus (0, 0, f). From the dish's point at r it meets the plane z = p at
///
/// ```text
/// x = r (f − p) / (f − r²/(4f)),     dΦ = 2π r E F(θ) dr,     tan θ = r / (2f)
/// ```
///
/// with θ the angle of incidence on the dish and F the metal's reflectance. A square receiver above the dish
/// shades the part |x|, |y| ≤ s of it: of the circle of radius r that part is missing, and so, in the same
/// directions, of the circle that it lands on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParabolicMirror {
    /// f (m).
    pub focal_length: f64,
    /// The dish's radius (m), at most 2 f (where the rim is as high as the focus).
    pub aperture: f64,
    /// The height p of the receiver's plane (m); not exactly f, where all light falls on one point.
    pub receiver_height: f64,
    /// E on a horizontal plane [W/m²].
    pub irradiance: f64,
    /// Half the width s of the square, receiver or not, that shades the dish's middle (m); 0 for none.
    pub shade_half_width: f64,
    /// The metal's index, real part.
    pub eta: f64,
    /// The metal's index, imaginary part.
    pub k: f64,
}

impl ParabolicMirror {
    /// The reflected light on the receiver's plane, the shade left out of account.
    pub fn sheet(&self) -> RadialSheet {
        RadialSheet::new(ByTheDish(*self))
    }

    /// The irradiance [W/m²] averaged over a texel of the receiver's plane, shade included.
    ///
    /// Beside the shade's image it is [`RadialSheet::texel_irradiance`]; across it, adaptive quadrature to
    /// about 1e-9 of the unshaded value.
    pub fn texel_irradiance(&self, sheet: &RadialSheet, texel: &TexelRect) -> f64 {
        let whole = sheet.texel_flux(texel);
        let dish = ByTheDish(*self);
        let shade = self.shade_half_width;
        let corner = (shade * SQRT_2).min(self.aperture);
        // From which r light lands at a distance: x = r c / (f − r²/(4f)) solved for r.
        let below_focus = (self.focal_length - self.receiver_height).abs();
        let source =
            |x: f64| 2.0 * self.focal_length * x / (below_focus + math::hypot(below_focus, x));
        let mut lost = 0.0;
        for part in texel.quadrant_parts() {
            let missing = |r: f64| {
                let Some(radius) = dish.radius(r) else {
                    return 0.0;
                };
                // The shade's image for light from the circle r: the square, scaled like the circle.
                let scaled = if r > 0.0 {
                    shade * radius.abs() / r
                } else {
                    0.0
                };
                let (min, max) = (part.min, part.max.min(DVec2::splat(scaled)));
                if min.x >= max.x || min.y >= max.y {
                    return 0.0;
                }
                dish.flux_density(r) * circle_fraction(radius.abs(), &TexelRect { min, max })
            };
            // Cut where the circle leaves the square, and finely: at the square's corners only a narrow
            // range of r counts.
            let (from, to) = (
                source(part.min.length()),
                source(part.max.length()).min(corner),
            );
            let cut = shade.clamp(from, to.max(from));
            for (from, to) in [(from, cut), (cut, to)] {
                let width = (to - from).max(0.0) / 16.0;
                for i in 0..16 {
                    let start = from + width * f64::from(i);
                    lost += simpson(start, start + width, 1e-10 * whole, &missing);
                }
            }
        }
        (whole - lost) / texel.area()
    }

    /// The irradiance [W/m²] of every texel of a grid, in the order of [`TexelGrid::map`].
    pub fn map(&self, grid: &TexelGrid) -> Vec<f64> {
        let sheet = self.sheet();
        grid.map(|texel| self.texel_irradiance(&sheet, texel))
    }

    /// The flux (W) onto the receiver's plane, shade included.
    pub fn received_flux(&self) -> f64 {
        let part = TexelRect::new(0.0, 0.0, self.shade_half_width, self.shade_half_width);
        let dish = ByTheDish(*self);
        let corner = (self.shade_half_width * SQRT_2).min(self.aperture);
        let side = self.shade_half_width.min(self.aperture);
        let flux = |r: f64| 4.0 * circle_fraction(r, &part) * dish.flux_density(r);
        self.sheet().landed_flux()
            - integrate(0.0, side, 4, flux)
            - integrate(side, corner, 4, flux)
    }
}

struct ByTheDish(ParabolicMirror);

impl RadialMap for ByTheDish {
    fn range(&self) -> (f64, f64) {
        (0.0, self.0.aperture)
    }

    fn radius(&self, u: f64) -> Option<f64> {
        let ParabolicMirror {
            focal_length,
            receiver_height,
            ..
        } = self.0;
        let height = u * u / (4.0 * focal_length);
        (height < receiver_height.min(focal_length))
            .then(|| u * (focal_length - receiver_height) / (focal_length - height))
    }

    fn flux_density(&self, u: f64) -> f64 {
        let slope = u / (2.0 * self.0.focal_length);
        let cos = 1.0 / math::hypot(1.0_f64, slope);
        TAU * u * self.0.irradiance * conductor_reflectance(cos, self.0.eta, self.0.k)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const DISH: ParabolicMirror = ParabolicMirror {
        focal_length: 0.5,
        aperture: 0.5,
        receiver_height: 0.45,
        irradiance: 1000.0,
        shade_half_width: 0.0,
        eta: 0.0,
        k: 1.0,
    };

    #[test]
    fn a_perfect_dish_gathers_all_that_its_aperture_takes() {
        let exact = 1000.0 * PI * 0.25;
        let sheet = DISH.sheet();
        assert!((sheet.landed_flux() / exact - 1.0).abs() < 1e-13);
        // The rim's light lands at 0.5 * 0.05 / 0.375.
        let edge = 0.5 * 0.05 / 0.375;
        assert!((sheet.disc_flux(edge * (1.0 + 1e-12)) / exact - 1.0).abs() < 1e-11);
        assert!(sheet.disc_flux(0.99 * edge) < 0.999 * exact);
    }

    #[test]
    fn in_the_middle_the_concentration_is_the_square_of_ten() {
        // x = r (f - p)/f (1 + O(r²)): areas shrink by 10² = 100.
        let texel = TexelRect::new(-1e-5, -1e-5, 1e-5, 1e-5);
        // r is 1e-4 there: (r/2f)² ~ 1e-8, times 4 for the two factors squared.
        assert!((DISH.sheet().texel_irradiance(&texel) / 1e5 - 1.0).abs() < 4e-8);
    }

    #[test]
    fn a_perfect_dish_loses_the_shades_area() {
        let shaded = |half: f64| {
            ParabolicMirror {
                shade_half_width: half,
                ..DISH
            }
            .received_flux()
        };
        let whole = 1000.0 * PI * 0.25;
        assert!(((whole - shaded(0.08)) / (1000.0 * 0.0256) - 1.0).abs() < 1e-10);
        // A square round the whole aperture takes all.
        assert!(shaded(0.6).abs() < 1e-10 * whole);
    }

    #[test]
    fn texels_over_the_receiver_sum_to_what_it_receives() {
        let dish = ParabolicMirror {
            shade_half_width: 0.08,
            ..DISH
        };
        let grid = TexelGrid::square(0.08, 31);
        let sum: f64 = dish.map(&grid).iter().sum::<f64>() * grid.texel(0, 0).area();
        assert!((sum / dish.received_flux() - 1.0).abs() < 1e-8, "{sum}");
        // The middle texel lies in the shade's image, half 0.008 wide.
        let dark = dish.texel_irradiance(&dish.sheet(), &grid.texel(15, 15));
        assert!(dark.abs() < 1e-6 * 1e5, "{dark}");
    }

    #[test]
    fn a_metal_gathers_less_by_its_reflectance() {
        let metal = ParabolicMirror {
            eta: 1.66,
            k: 9.22,
            ..DISH
        };
        let share = metal.sheet().landed_flux() / DISH.sheet().landed_flux();
        let normal = (math::powi(0.66_f64, 2) + math::powi(9.22_f64, 2))
            / (math::powi(2.66_f64, 2) + math::powi(9.22_f64, 2));
        // Up to 27° an unpolarised metal's reflectance stays within 0.2 % of its value at 0°.
        assert!((share / normal - 1.0).abs() < 2e-3, "{share} {normal}");
    }
}
