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
/// which is inverted by Newton's method within a bracket that shrinks.
pub(super) fn slope_along(sin: f64, cos: f64, u: f64) -> f64 {
    // Beyond this, exp(−x²) is below 1e-293: no slope out there is ever drawn.
    const STEEPEST: f64 = 26.0;
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
    let target = u * shown(high).0;
    // Straight on, this is the slope but for some 1e-3.
    let straight = normal_quantile_estimate(u.clamp(1e-9, 1.0 - 1e-9));
    let mut x = (FRAC_1_SQRT_2 * straight).min(high - 0.25);
    // Newton's steps double the digits; if one leaves the bracket, the bracket is halved instead. A bracket
    // of 52 is down to the spacing of floats after some 60 halvings, so 100 steps are never all needed.
    for _ in 0..100 {
        let (seen, bell) = shown(x);
        let excess = seen - target;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let newton = x - excess / (bell * (cos - x * sin));
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        let is_found = (next - x).abs() <= 4.0 * f64::EPSILON * (1.0 + x.abs());
        x = next;
        if is_found {
            break;
        }
    }
    x
}
