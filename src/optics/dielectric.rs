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
/// (Born and Wolf, *Principles of Optics*, 7th edition, 1.5.2 (21a)). With a = (η − 1)(η + 1) the product
/// w = η cos θₜ is √(a + cos² θᵢ), and multiplying each r by its own denominator leaves
///
/// ```text
/// r_s = −a / (cos θᵢ + w)²
/// r_p =  a ((η² + 1) cos² θᵢ − 1) / (η² cos θᵢ + w)²
/// ```
///
/// in which nothing cancels for η near 1: there F is about a²/16, and keeps its digits. At Brewster's angle `r_p`
/// cancels, but `r_s` does not. Near the critical angle w is ill-conditioned: a relative error of cos θᵢ counts
/// (cos θᵢ / w)² times in it.
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
    let a = (eta - 1.0) * (eta + 1.0);
    let cos_squared = cos_incident * cos_incident;
    let eta_cos_squared = a + cos_squared;
    if eta_cos_squared <= 0.0 || cos_incident <= 0.0 {
        return if eta == 1.0 { 0.0 } else { 1.0 };
    }
    let eta_cos_transmitted = eta_cos_squared.sqrt();
    let eta_squared = eta * eta;
    let s_even = cos_incident + eta_cos_transmitted;
    let p_even = eta_squared * cos_incident + eta_cos_transmitted;
    let r_s = a / (s_even * s_even);
    // In two quotients: the square of the denominator would overflow from η = 1e77 on.
    let r_p = (a / p_even) * (((eta_squared + 1.0) * cos_squared - 1.0) / p_even);
    // At grazing incidence both are 1 but for rounding, which may be upward.
    let reflectance = 0.5 * (r_s * r_s + r_p * r_p);
    // Not `min`, which would make total reflection of NaN.
    if reflectance > 1.0 { 1.0 } else { reflectance }
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
