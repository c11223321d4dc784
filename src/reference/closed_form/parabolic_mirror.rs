//! A parabolic dish in parallel light.

use std::f64::consts::TAU;

use super::circle::circle_fraction;
use super::quadrature::integrate;
use super::{RadialMap, RadialSheet, Texel};
use crate::optics::conductor_reflectance;

/// A metal dish z = r²/(4f) in light that falls straight down: the light (path `LRD`) on a plane below its focus.
///
/// Every ray is reflected through the focus (0, 0, f). From the dish's point at r it meets the plane z = p at
///
/// ```text
/// x = r (f − p) / (f − r²/(4f)),     dΦ = 2π r E F(θ) dr,     tan θ = r / (2f)
/// ```
///
/// with θ the angle of incidence on the dish and F the metal's reflectance. The receiver faces down; what it
/// shades of the dish is left to [`ParabolicMirror::flux_onto_square`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParabolicMirror {
    /// f [m].
    pub focal_length: f64,
    /// The dish's radius [m], at most 2 f (where the rim is as high as the focus).
    pub aperture: f64,
    /// The height p of the receiver's plane [m].
    pub receiver_height: f64,
    /// E on a horizontal plane [W/m²].
    pub irradiance: f64,
    /// The metal's index, real part.
    pub eta: f64,
    /// The metal's index, imaginary part.
    pub k: f64,
}

impl ParabolicMirror {
    /// The reflected light on the receiver's plane, were nothing shaded.
    pub fn sheet(&self) -> RadialSheet {
        RadialSheet::new(ByTheDish(*self))
    }

    /// The flux [W] that falls onto the part |x|, |y| ≤ `half_width` of the dish and is reflected: what a square
    /// receiver of this half width above takes away.
    pub fn flux_onto_square(&self, half_width: f64) -> f64 {
        let part = Texel::new(0.0, 0.0, half_width, half_width);
        let dish = ByTheDish(*self);
        let corner = (half_width * 2.0_f64.sqrt()).min(self.aperture);
        let side = half_width.min(self.aperture);
        let flux = |r: f64| 4.0 * circle_fraction(r, &part) * dish.flux_density(r);
        integrate(0.0, side, 4, flux) + integrate(side, corner, 4, flux)
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
        let cos = 1.0 / 1.0_f64.hypot(slope);
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
        let texel = Texel::new(-1e-5, -1e-5, 1e-5, 1e-5);
        // r is 1e-4 there: (r/2f)² ~ 1e-8, times 4 for the two factors squared.
        assert!((DISH.sheet().texel_irradiance(&texel) / 1e5 - 1.0).abs() < 4e-8);
    }

    #[test]
    fn a_squares_share_of_a_perfect_dish_is_its_area() {
        assert!((DISH.flux_onto_square(0.08) / (1000.0 * 0.0256) - 1.0).abs() < 1e-12);
        // A square round the whole aperture takes all.
        assert!((DISH.flux_onto_square(0.6) / (1000.0 * PI * 0.25) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_metal_gathers_less_by_its_reflectance() {
        let metal = ParabolicMirror {
            eta: 1.66,
            k: 9.22,
            ..DISH
        };
        let share = metal.sheet().landed_flux() / DISH.sheet().landed_flux();
        let normal = (0.66_f64.powi(2) + 9.22_f64.powi(2)) / (2.66_f64.powi(2) + 9.22_f64.powi(2));
        // Up to 27° an unpolarised metal's reflectance stays within 0.2 % of its value at 0°.
        assert!((share / normal - 1.0).abs() < 2e-3, "{share} {normal}");
    }
}
