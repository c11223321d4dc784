//! Smooth metals.

use crate::numeric::math;

/// Fresnel reflectance F of a smooth conductor, unpolarised light.
///
/// F is the fraction (0..=1) of incident flux reflected; the rest is absorbed. With the complex index n =
/// `eta` + i `k` relative to the medium light arrives in,
///
/// ```text
/// a² + b² = √((η² − k² − sin²θ)² + 4 η² k²)
/// a²      = (a² + b² + η² − k² − sin²θ) / 2
/// r_s²    = (a² + b² + cos²θ − 2 a cosθ) / (a² + b² + cos²θ + 2 a cosθ)
/// r_p²    = r_s² · (cos²θ (a² + b²) + sin⁴θ − 2 a cosθ sin²θ)
///                / (cos²θ (a² + b²) + sin⁴θ + 2 a cosθ sin²θ)
/// F       = (r_s² + r_p²) / 2
/// ```
///
/// (Born and Wolf, *Principles of Optics*, 7th edition, 14.2).
///
/// - `cos_incident`: cos θ in 0..=1.
/// - `eta` = 0 with `k` > 0 is a perfect mirror (Mitsuba's material `none`): exactly 1. Grazing light is
///   reflected whole.
pub fn conductor_reflectance(cos_incident: f64, eta: f64, k: f64) -> f64 {
    if cos_incident <= 0.0 || eta == 0.0 {
        return 1.0;
    }
    let cos_squared = cos_incident * cos_incident;
    let sin_squared = (1.0 - cos_incident) * (1.0 + cos_incident);
    let difference = eta * eta - k * k - sin_squared;
    let sum = math::hypot(difference, 2.0 * eta * k);
    // a² = (sum + difference)/2 cancels if k² is large: it is then computed from b² = (sum - difference)/2.
    let a = if difference >= 0.0 {
        (0.5 * (sum + difference)).sqrt()
    } else {
        eta * k / (0.5 * (sum - difference)).sqrt()
    };
    let s_even = sum + cos_squared;
    let s_odd = 2.0 * a * cos_incident;
    let r_s = (s_even - s_odd) / (s_even + s_odd);
    let p_even = cos_squared * sum + sin_squared * sin_squared;
    let p_odd = s_odd * sin_squared;
    let r_p = r_s * (p_even - p_odd) / (p_even + p_odd);
    0.5 * (r_s + r_p)
}
