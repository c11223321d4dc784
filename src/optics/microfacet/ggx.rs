//! Slopes of a stretched sphere: GGX.

use crate::numeric::math;

/// G₁ = 2 / (1 + √(1 + α² tan²θ)) (Walter et al. 2007, equation 34), given α² tan²θ.
#[inline]
pub(super) fn shadowing(slant_squared: f64) -> f64 {
    2.0 / (1.0 + (1.0 + slant_squared).sqrt())
}

/// A slope of a surface with α = 1, seen from the angle θ off its normal towards +x, in proportion to the
/// area shown.
///
/// Heitz, *A Simpler and Exact Sampling Routine for the GGX Distribution of Visible Normals* (2017): the
/// facets are those of a half sphere, whose outline is half a disc and half an ellipse.
pub(super) fn visible_slope(sin: f64, cos: f64, u: [f64; 2]) -> [f64; 2] {
    let [across, along] = concentric_disc(u);
    let share = 0.5 * (1.0 + cos);
    let half = (1.0 - across * across).max(0.0).sqrt();
    let along = half + share * (along - half);
    let towards = (1.0 - across * across - along * along).max(0.0).sqrt();
    // The normal on the half sphere is (x, across, z) with these.
    let z = sin * along + cos * towards;
    let x = cos * along - sin * towards;
    // On the rim of a surface seen at grazing incidence there is no finite slope.
    let z = z.max(f64::MIN_POSITIVE);
    [x / z, across / z]
}

/// A point of the unit disc: Shirley and Chiu's map of the square, which keeps areas and neighbours.
fn concentric_disc(u: [f64; 2]) -> [f64; 2] {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    let [x, y] = u.map(|u| 2.0 * u - 1.0);
    if x == 0.0 && y == 0.0 {
        return [0.0, 0.0];
    }
    let (radius, angle) = if x.abs() > y.abs() {
        (x, FRAC_PI_4 * (y / x))
    } else {
        (y, FRAC_PI_2 - FRAC_PI_4 * (x / y))
    };
    let (sin, cos) = math::sin_cos(angle);
    [radius * cos, radius * sin]
}
