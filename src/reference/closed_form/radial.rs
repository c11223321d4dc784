//! Light of scenes that are round about an axis, on a plane across that axis.

use std::f64::consts::FRAC_PI_2;
use std::fmt;

use super::branches::{Branches, MonotoneBranch};
use super::circle::{circle_fraction, corner_radii};
use super::quadrature::integrate;
use super::{TexelGrid, TexelRect};

/// The map of a round scene's light to the receiver: a family of rays in a half plane through the axis, by
/// one variable u.
///
/// Turned about the axis, the rays of [u, u + du] form a hollow cone, which lands on a circle.
pub trait RadialMap: Send + Sync {
    /// The range of u.
    fn range(&self) -> (f64, f64);

    /// The distance from the axis (m) at which ray u lands, negative where it has crossed the axis; `None` if
    /// it never does. Smooth in u.
    fn radius(&self, u: f64) -> Option<f64>;

    /// dΦ/du, the flux (W) of the cone per unit of u. Smooth in u.
    fn flux_density(&self, u: f64) -> f64;
}

/// One path's light on a plane across the axis of a round scene, the axis through the origin.
///
/// The flux into a texel is the integral over u of the cone's flux times the fraction of its circle that
/// lies in the texel:
///
/// ```text
/// Φ(texel) = ∫ dΦ/du · fraction(|r(u)|, texel) du
/// ```
///
/// Nothing in it is singular: at folds of r(u), at the axis and on caustics the *irradiance* dΦ / (2π r dr)
/// is infinite, but u goes through them smoothly. The fraction has kinks where the circle passes a corner of
/// the texel (or touches a side on an axis of coordinates: a corner of a quadrant's part); the integral is
/// cut there, by inverting r(u) on each monotone branch, and each piece is taken by Gauss's rule in a
/// variable that also removes square roots at the ends. What is left is rounding: about 1e-12 of the circle's
/// flux, from the difference of two angles in the fraction.
pub struct RadialSheet {
    map: Box<dyn RadialMap>,
    branches: Branches,
}

impl RadialSheet {
    /// Prepares a map: finds its folds.
    pub fn new(map: impl RadialMap + 'static) -> Self {
        let (from, to) = map.range();
        let branches = Branches::new(from, to, &|u| map.radius(u));
        Self {
            map: Box::new(map),
            branches,
        }
    }

    /// The flux (W) into a texel.
    pub fn texel_flux(&self, texel: &TexelRect) -> f64 {
        texel
            .quadrant_parts()
            .map(|part| self.part_flux(&part))
            .sum()
    }

    /// The irradiance [W/m²], averaged over a texel.
    pub fn texel_irradiance(&self, texel: &TexelRect) -> f64 {
        self.texel_flux(texel) / texel.area()
    }

    /// The irradiance [W/m²] of every texel of a grid, in the order of [`TexelGrid::map`].
    pub fn map(&self, grid: &TexelGrid) -> Vec<f64> {
        grid.map(|texel| self.texel_irradiance(texel))
    }

    /// The flux (W) into the disc of this radius about the axis.
    pub fn disc_flux(&self, radius: f64) -> f64 {
        self.branches
            .iter()
            .map(|branch| {
                let (a, b) = self.preimage(branch, -radius, radius);
                integrate(a, b, self.panels(a, b), |u| self.map.flux_density(u))
            })
            .sum()
    }

    /// The flux (W) onto the whole plane.
    pub fn landed_flux(&self) -> f64 {
        self.disc_flux(f64::INFINITY)
    }

    /// The flux (W) of all rays, whether they land or not.
    pub fn sent_flux(&self) -> f64 {
        let (from, to) = self.map.range();
        integrate(from, to, MOST_PANELS, |u| self.map.flux_density(u))
    }

    /// The distances from the axis (m) at which the sheet folds: the caustic circles.
    pub fn fold_radii(&self) -> Vec<f64> {
        let mut starts = self.branches.iter().map(MonotoneBranch::range);
        let Some(mut last) = starts.next() else {
            return Vec::new();
        };
        let mut folds = Vec::new();
        for range in starts {
            if range.0 == last.1 {
                folds.extend(self.map.radius(range.0).map(f64::abs));
            }
            last = range;
        }
        folds
    }

    /// The flux into a rectangle of the first quadrant.
    fn part_flux(&self, part: &TexelRect) -> f64 {
        let radii = corner_radii(part);
        let mut flux = 0.0;
        for branch in self.branches.iter() {
            let (least, greatest) = branch.value_range();
            for sign in [1.0, -1.0] {
                let (near, far) = if sign > 0.0 {
                    (least, greatest)
                } else {
                    (-greatest, -least)
                };
                if far <= radii[0] || near >= radii[3] || far <= 0.0 {
                    continue;
                }
                let mut last = self.inverse(branch, sign * radii[0].max(0.0));
                for pair in radii.windows(2) {
                    if pair[0] == pair[1] {
                        continue;
                    }
                    let next = self.inverse(branch, sign * pair[1]);
                    let (a, b) = (last.min(next), last.max(next));
                    if a < b {
                        flux += integrate(a, b, self.panels(a, b), |u| {
                            let radius = self.map.radius(u).unwrap_or(f64::INFINITY).abs();
                            self.map.flux_density(u) * circle_fraction(radius, part)
                        });
                    }
                    last = next;
                }
            }
        }
        flux
    }

    fn preimage(&self, branch: &MonotoneBranch, least: f64, greatest: f64) -> (f64, f64) {
        let (a, b) = (self.inverse(branch, least), self.inverse(branch, greatest));
        (a.min(b), a.max(b))
    }

    fn inverse(&self, branch: &MonotoneBranch, radius: f64) -> f64 {
        branch.inverse(radius, &|u| self.map.radius(u))
    }

    /// Wide stretches of u are cut, so that 16 nodes see only a little of the map.
    fn panels(&self, a: f64, b: f64) -> usize {
        let (from, to) = self.map.range();
        ((b - a) / (to - from) * MOST_PANELS as f64).ceil().max(1.0) as usize
    }
}

impl fmt::Debug for RadialSheet {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("RadialSheet")
            .field("range", &self.map.range())
            .finish_non_exhaustive()
    }
}

/// Panels over the whole range of u: on each, the smooth parts of the maps used here (sines, Fresnel's
/// formulas) are polynomials of degree 31 to rounding.
const MOST_PANELS: usize = 32;

/// The largest angle at which a ray still counts as falling onto a plane: a hair before parallel.
pub(super) const STEEPEST: f64 = FRAC_PI_2 - 1e-12;

#[cfg(test)]
mod tests {
    use crate::numeric::math;
    use std::f64::consts::{PI, TAU};

    use super::*;

    /// A point of intensity 1 at height 1 over the plane: r = tan u.
    struct Bare;
    impl RadialMap for Bare {
        fn range(&self) -> (f64, f64) {
            (0.0, STEEPEST)
        }
        fn radius(&self, u: f64) -> Option<f64> {
            Some(math::tan(u))
        }
        fn flux_density(&self, u: f64) -> f64 {
            TAU * math::sin(u)
        }
    }

    /// r = sin u over two turns of folding, crossing the axis thrice; uniform in u.
    struct Folding;
    impl RadialMap for Folding {
        fn range(&self) -> (f64, f64) {
            (0.0, 3.0 * PI)
        }
        fn radius(&self, u: f64) -> Option<f64> {
            Some(math::sin(u))
        }
        fn flux_density(&self, _: f64) -> f64 {
            1.0
        }
    }

    /// The solid angle of the rectangle (0, 0)-(x, y) seen from height 1.
    fn solid_angle(x: f64, y: f64) -> f64 {
        math::atan(x * y / (1.0 + x * x + y * y).sqrt())
    }

    #[test]
    fn a_point_light_gives_each_texel_its_solid_angle() {
        let sheet = RadialSheet::new(Bare);
        for (x0, y0, x1, y1) in [
            (0.0, 0.0, 0.01, 0.01),
            (0.3, 0.2, 0.31, 0.21),
            (-0.4, -1.0, 2.0, 0.1),
            (0.0, 3.0, 0.5, 3.5),
            (-5.0, -5.0, 5.0, 5.0),
        ] {
            let exact = solid_angle(x1, y1) - solid_angle(x0, y1) - solid_angle(x1, y0)
                + solid_angle(x0, y0);
            let flux = sheet.texel_flux(&TexelRect::new(x0, y0, x1, y1));
            // Both sides difference angles of size 1: 1e-15 absolute beside the rule's 1e-12.
            assert!(
                (flux - exact).abs() < 1e-11 * exact + 4e-15,
                "{flux} {exact}"
            );
        }
    }

    #[test]
    fn texels_round_a_disc_of_folded_light_sum_to_all_of_it() {
        let sheet = RadialSheet::new(Folding);
        for side in [1, 2, 5, 16] {
            let grid = TexelGrid::square(1.0, side);
            let sum: f64 = grid.map(|texel| sheet.texel_flux(texel)).iter().sum();
            assert!((sum - 3.0 * PI).abs() < 1e-11 * 3.0 * PI, "{side}: {sum}");
        }
        assert!((sheet.landed_flux() - 3.0 * PI).abs() < 1e-13);
        assert!(
            (sheet.disc_flux(0.5) - 3.0 * PI / 3.0).abs() < 1e-12,
            "r < 1/2 for a third of every half turn"
        );
        let folds = sheet.fold_radii();
        assert_eq!(folds.len(), 3);
        assert!(folds.iter().all(|fold| (fold - 1.0).abs() < 1e-15));
    }

    #[test]
    fn a_texel_astride_a_fold_agrees_with_brute_force() {
        let sheet = RadialSheet::new(Folding);
        let texel = TexelRect::new(0.55, 0.6, 0.85, 0.9);
        let part = texel;
        let count = 3_000_000;
        let step = 3.0 * PI / f64::from(count);
        let brute: f64 = (0..count)
            .map(|i| circle_fraction(math::sin(step * (f64::from(i) + 0.5)).abs(), &part) * step)
            .sum();
        // The midpoint rule errs by step²/24 times the jumps of slope, here below 10 each, at most 30 of
        // them.
        assert!((sheet.texel_flux(&texel) - brute).abs() < 1e-10, "{brute}");
    }
}
