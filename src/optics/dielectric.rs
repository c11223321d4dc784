//! Smooth interfaces between transparent media.

/// Fresnel reflectance F of a smooth dielectric interface, unpolarised light.
///
/// F is the fraction (0..=1) of incident **flux** reflected; `1 - F` is transmitted.
/// With Snell's law sin θᵢ = η sin θₜ,
///
/// ```text
/// r_s = (cos θᵢ − η cos θₜ) / (cos θᵢ + η cos θₜ)
/// r_p = (η cos θᵢ − cos θₜ) / (η cos θᵢ + cos θₜ)
/// F   = (r_s² + r_p²) / 2
/// ```
///
/// (Born and Wolf, *Principles of Optics*, 7th edition, 1.5.2 (21a)). The product
/// η cos θₜ is the square root of (η − 1)(η + 1) + cos² θᵢ: written so, nothing cancels
/// near the critical angle or for η near 1.
///
/// - `cos_incident`: cos θᵢ in 0..=1, on the side light arrives from.
/// - `eta`: `n_transmitted / n_incident`; `1.33` enters water from air.
///
/// Returns exactly 1 at and beyond the critical angle, and at grazing incidence; exactly 0
/// for `eta` = 1. Photon flux splits by F alone; transmitted *radiance* also scales by η², not here.
///
/// ```
/// # use nephroid::optics::dielectric_reflectance;
/// // ((1.5 - 1) / (1.5 + 1))², to the rounding of the squares
/// assert!((dielectric_reflectance(1.0, 1.5) - 0.04).abs() < 2e-17);
/// assert_eq!(dielectric_reflectance(0.5, 1.0 / 1.5), 1.0); // beyond 41.8 degrees in glass
/// ```
#[inline]
pub fn dielectric_reflectance(cos_incident: f64, eta: f64) -> f64 {
    let eta_cos_squared = (eta - 1.0) * (eta + 1.0) + cos_incident * cos_incident;
    if eta_cos_squared <= 0.0 || cos_incident <= 0.0 {
        return if eta == 1.0 { 0.0 } else { 1.0 };
    }
    let eta_cos_transmitted = eta_cos_squared.sqrt();
    let r_s = (cos_incident - eta_cos_transmitted) / (cos_incident + eta_cos_transmitted);
    let eta_squared_cos = eta * eta * cos_incident;
    let r_p = (eta_squared_cos - eta_cos_transmitted) / (eta_squared_cos + eta_cos_transmitted);
    0.5 * (r_s * r_s + r_p * r_p)
}

/// Reflectance of a plane-parallel pane, all internal reflections summed without interference.
///
/// With F the reflectance of one interface, T = 1 − F and no absorption, the series
/// F + T F T (1 + F² + F⁴ + ...) sums to 2 F / (1 + F). The rest is transmitted.
///
/// - `cos_incident`: cos θᵢ in 0..=1 outside the pane.
/// - `eta`: `n_pane / n_outside`. Where it is below 1, total reflection gives 1.
#[inline]
pub fn thin_slab_reflectance(cos_incident: f64, eta: f64) -> f64 {
    let single = dielectric_reflectance(cos_incident, eta);
    2.0 * single / (1.0 + single)
}
