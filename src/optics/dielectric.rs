//! Smooth interfaces between transparent media.

use crate::numeric::compensated::Compensated;
use crate::numeric::fused::with_fused;

/// Fresnel reflectance F of a smooth dielectric interface, unpolarised light.
///
/// F is the fraction (0..=1) of incident **flux** reflected; `1 - F` is transmitted. With Snell's law sin θᵢ
/// = η sin θₜ,
///
/// ```text
/// r_s = (cos θᵢ − η cos θₜ) / (cos θᵢ + η cos θₜ)
/// r_p = (η cos θᵢ − cos θₜ) / (η cos θᵢ + cos θₜ)
/// F   = (r_s² + r_p²) / 2
/// ```
///
/// (Born and Wolf, *Principles of Optics*, 7th edition, 1.5.2 (21a)). With a = (η − 1)(η + 1) the product w =
/// η cos θₜ is √(a + cos² θᵢ), and
///
/// ```text
/// r_s     = −a / (cos θᵢ + w)²
/// r_p/r_s = cos(θᵢ + θₜ) / cos(θᵢ − θₜ) = (w cos θᵢ − sin² θᵢ) / (w cos θᵢ + sin² θᵢ)
/// F       = r_s² (1 + (r_p/r_s)²) / 2
/// ```
///
/// Here nothing cancels for η near 1, for which F is about a²/16 and keeps its digits. At Brewster's angle
/// `r_p` cancels, but `r_s` does not. Rounding errors are compensated for (`numeric/compensated.rs`). So F is
/// off by one rounding, u = 2⁻⁵³ of itself, at every angle and for η from 1e-3 on. That includes angles near
/// the critical one, at which w by itself loses all digits. This takes some 40 ns; with each operation
/// rounded it would be 9.
///
/// - `cos_incident`: cos θᵢ in 0..=1, on the side light arrives from.
/// - `eta`: `n_transmitted / n_incident`; `1.33` enters water from air.
///
/// Returns exactly 1 at and beyond the critical angle, and at grazing incidence; exactly 0 for `eta` = 1.
/// Photon flux splits by F alone; transmitted *radiance* also scales by η², not here.
///
/// ```
/// # use nephroid::internals::optics::dielectric_reflectance;
/// assert_eq!(dielectric_reflectance(1.0, 1.5), 0.04); // ((1.5 - 1) / (1.5 + 1))²
/// assert_eq!(dielectric_reflectance(0.5, 1.0 / 1.5), 1.0); // beyond 41.8 degrees in glass
/// ```
#[inline]
pub fn dielectric_reflectance(cos_incident: f64, eta: f64) -> f64 {
    if eta_cos_squared(cos_incident, eta) <= 0.0 || cos_incident <= 0.0 {
        return if eta == 1.0 { 0.0 } else { 1.0 };
    }
    with_fused(
        #[inline(always)]
        || partial_reflectance(cos_incident, eta),
    )
}

/// (η cos θₜ)² = (η − 1)(η + 1) + cos² θᵢ, which is above 0 exactly if light is refracted.
///
/// Both [`refract`](super::refract) and F use it: a direction without a share of the flux, or a share without
/// a direction, would lose light.
#[inline]
pub(super) fn eta_cos_squared(cos_incident: f64, eta: f64) -> f64 {
    let cos_squared = cos_incident * cos_incident;
    let rounded = (eta - 1.0) * (eta + 1.0) + cos_squared;
    // If the terms cancel they are equally large: one has three roundings, the other one has one, and so has
    // their sum.
    if rounded.abs() <= 4.0 * f64::EPSILON * cos_squared {
        return critical_eta_cos_squared(cos_incident, eta);
    }
    rounded
}

/// [`eta_cos_squared`] if all digits cancel.
#[cold]
fn critical_eta_cos_squared(cos_incident: f64, eta: f64) -> f64 {
    (compensated_a(eta) + Compensated::product(cos_incident, cos_incident)).rounded()
}

/// (η − 1)(η + 1).
#[inline(always)]
#[allow(clippy::inline_always)] // or it is not compiled for fused multiply-add
fn compensated_a(eta: f64) -> Compensated {
    Compensated::sum(eta, -1.0) * Compensated::sum(eta, 1.0)
}

/// F for light that is refracted.
#[inline(always)]
#[allow(clippy::inline_always)] // or it is not compiled for fused multiply-add
fn partial_reflectance(cos_incident: f64, eta: f64) -> f64 {
    let a = compensated_a(eta);
    let cos_squared = Compensated::product(cos_incident, cos_incident);
    let eta_cos_transmitted = (a + cos_squared).settled().sqrt();
    let r_s = a / (eta_cos_transmitted + cos_incident).squared();
    let (along, across) = (eta_cos_transmitted * cos_incident, 1.0 - cos_squared);
    let p_by_s = (along - across) / (along + across);
    let reflectance = (r_s.squared() * (p_by_s.squared() + 1.0)).rounded() * 0.5;
    // At grazing incidence rounding may be upward. Not `min`, which would make total reflection of NaN.
    if reflectance > 1.0 { 1.0 } else { reflectance }
}

/// Reflectance of a plane-parallel pane, all internal reflections summed without interference.
///
/// With F the reflectance of one interface, T = 1 − F and no absorption, the series F + T F T (1 + F² + F⁴ +
/// ...) sums to 2 F / (1 + F). The rest is transmitted.
///
/// - `cos_incident`: cos θᵢ in 0..=1 outside the pane.
/// - `eta`: `n_pane / n_outside`. If it is below 1, total reflection gives 1.
#[inline]
pub fn thin_slab_reflectance(cos_incident: f64, eta: f64) -> f64 {
    let single = dielectric_reflectance(cos_incident, eta);
    2.0 * single / (1.0 + single)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bits compiled for fused multiply-add, and those compiled for any processor.
    #[test]
    fn reflectance_is_the_same_bits_on_every_processor() {
        for eta in [1.5, 1.0 / 1.5, 100.0, 0.01, 1.0 + 1e-12] {
            for step in 1..=1000 {
                let cos = f64::from(step) / 1000.0;
                if eta_cos_squared(cos, eta) > 0.0 {
                    let anywhere = std::hint::black_box(partial_reflectance)(cos, eta);
                    assert_eq!(
                        dielectric_reflectance(cos, eta).to_bits(),
                        anywhere.to_bits()
                    );
                }
            }
        }
    }
}
