//! Slopes of a Gaussian random surface: Beckmann.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI};

use crate::numeric::distributions::{normal_quantile, normal_quantile_estimate};
use crate::numeric::math;

/// G₁ by the rational fit of Walter et al. 2007, equation 27, given α² tan²θ = 1/a²: within 0.35 %.
#[inline]
pub(super) fn fitted_shadowing(slant_squared: f64) -> f64 {
    let a_squared = 1.0 / slant_squared;
    let a = a_squared.sqrt();
    if a >= 1.6 {
        1.0
    } else {
        (3.535 * a + 2.181 * a_squared) / (1.0 + 2.276 * a + 2.577 * a_squared)
    }
}

/// G₁ = 2 / (1 + erf a + exp(−a²)/(a √π)) (Walter et al. 2007, equation 26), given α² tan²θ = 1/a².
#[inline]
pub(super) fn shadowing(slant_squared: f64) -> f64 {
    if slant_squared == 0.0 {
        return 1.0;
    }
    let a = 1.0 / slant_squared.sqrt();
    2.0 / (1.0 + math::erf(a) + 0.5 * FRAC_2_SQRT_PI * math::exp(-a * a) / a)
}

/// A slope across the view of a surface with α = 1: Gaussian with the density exp(−y²)/√π.
pub(super) fn slope_across(u: f64) -> f64 {
    normal_quantile(u.max(f64::MIN_POSITIVE)) * FRAC_1_SQRT_2
}

/// A slope along the view of a surface with α = 1, seen from the angle θ off its normal towards +x.
///
/// Facets of slope x show an area in proportion to (cos θ − x sin θ) exp(−x²), up to x = cot θ, at which they
/// are seen edge on. Integrated from −∞ that is, up to a factor,
///
/// ```text
/// F(x) = cos θ (1 + erf x) + sin θ exp(−x²)/√π
/// ```
///
/// which is inverted by Halley's method within a bracket that shrinks.
pub(super) fn slope_along(sin: f64, cos: f64, u: f64) -> f64 {
    // Beyond this, exp(−x²) is below 1e-293: no slope out there is ever drawn.
    const STEEPEST: f64 = 26.0;
    // ∛ε: Halley's steps triple the digits, so what a smaller one leaves is below the spacing ε of floats.
    const SMALL: f64 = 6e-6;
    let shown = |x: f64| {
        let bell = FRAC_2_SQRT_PI * math::exp(-x * x);
        (cos * math::erfc(-x) + sin * 0.5 * bell, bell)
    };
    let mut low = -STEEPEST;
    let mut high = if cos < STEEPEST * sin {
        cos / sin
    } else {
        STEEPEST
    };
    // Uniform numbers are multiples of ε/2: the slope of zero is beyond all.
    let target = u.max(0.5 * f64::EPSILON) * shown(high).0;
    let mut x = slope_estimate(sin, u).min(high - 1e-3);
    // If a step leaves the bracket, the bracket is halved instead. Two or three steps are the rule, and 15
    // are for the largest number below 1.
    for _ in 0..100 {
        let (seen, bell) = shown(x);
        let excess = seen - target;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        // F' is the bell times this, and F'' the bell times −(2x width + sin).
        let width = cos - x * sin;
        let newton = excess / (bell * width);
        let halley = x - newton / (1.0 + newton * (x + 0.5 * sin / width));
        let is_within = halley >= low && halley <= high;
        let next = if is_within {
            halley
        } else {
            0.5 * (low + high)
        };
        // The bell changes over a length of 1/(1 + |x|), and the width over that to its end.
        let (step, size) = ((next - x).abs(), 1.0 + x.abs());
        let is_found = if is_within {
            step * (size + (sin / width).abs()) <= SMALL
        } else {
            step <= f64::EPSILON * size
        };
        x = next;
        if is_found {
            break;
        }
    }
    x
}

/// [`slope_along`] within 0.1, but for grazing views and rare slopes: the slope is a polynomial of the
/// normal variable with the same probability (as in Cornish and Fisher's expansions), whose coefficients are
/// polynomials of sin θ. Coefficients are a least-squares fit over 60 views between 0° and 90°, and normal
/// variables between −3.2 and 3.2, each weighted by its density.
fn slope_estimate(sin: f64, u: f64) -> f64 {
    const FIT: [[f64; 5]; 3] = [
        [-0.015_354, -0.073_572, -2.279_688, 3.720_358, -2.185_726],
        [0.702_199, 0.131_824, -0.825_297, 0.912_533, -0.450_319],
        [-0.001_376, 0.035_969, -0.156_929, 0.054_260, 0.016_066],
    ];
    let z = normal_quantile_estimate(u.clamp(1e-9, 1.0 - 1e-9));
    let [mean, spread, skew] = FIT.map(|row| {
        row.iter()
            .rev()
            .fold(0.0, |sum, coefficient| sum * sin + coefficient)
    });
    mean + z * spread + (z * z - 1.0) * skew
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_along_the_view_invert_their_integral() {
        let shown = |sin: f64, cos: f64, x: f64| {
            cos * math::erfc(-x) + sin * 0.5 * FRAC_2_SQRT_PI * math::exp(-x * x)
        };
        for degrees in [0.0, 1e-6, 1.0, 20.0, 45.0, 70.0, 85.0, 89.0, 89.99, 90.0] {
            let angle = f64::to_radians(degrees);
            let (sin, cos) = (math::sin(angle), math::cos(angle).max(0.0));
            let all = shown(sin, cos, (cos / sin).min(26.0));
            let even = (1..500).map(|k| f64::from(k) / 500.0);
            let least = 0.5 * f64::EPSILON;
            let rare = [least, 1e-12, 1e-6, 1.0 - 1e-6, 1.0 - 1e-12, 1.0 - least];
            assert_eq!(
                slope_along(sin, cos, 0.0),
                slope_along(sin, cos, 0.5 * f64::EPSILON)
            );
            for u in even.chain(rare) {
                let x = slope_along(sin, cos, u);
                let found = shown(sin, cos, x);
                // Each term is rounded, and so is x: a spacing of it moves an exponential by 2x² of them.
                let allowed = 8.0 * f64::EPSILON * (all * u * (1.0 + 2.0 * x * x) + found);
                assert!(
                    (found - all * u).abs() <= allowed,
                    "{degrees}° {u}: {x}, {found} of {}",
                    all * u
                );
            }
        }
    }

    #[test]
    fn the_first_estimate_of_a_slope_is_near_it() {
        for k in 0..=80 {
            let angle = f64::to_radians(f64::from(k));
            let (sin, cos) = (math::sin(angle), math::cos(angle));
            for u in (1..100).map(|k| f64::from(k) / 100.0) {
                let error = slope_estimate(sin, u).min(cos / sin) - slope_along(sin, cos, u);
                assert!(error.abs() < 0.1, "{k}° {u}: {error}");
            }
        }
    }
}
