//! Directions of light after an interface.

use glam::DVec3;

use super::dielectric::eta_cos_squared;

/// The direction of travel after a mirror reflection, d − 2 (d·n) n.
///
/// It is as long as `direction` to a few units in the last place. So a chain of n events leaves a unit vector
/// unit to about 4n of them, and no event pays for a normalisation.
///
/// - `direction`: unit vector of travel.
/// - `normal`: unit normal; its sign does not matter.
#[inline]
pub fn reflect(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

/// The direction of travel after refraction by Snell's law; `None` beyond the critical angle.
///
/// With c = −d·n, the transmitted direction is (d + (c − √((η−1)(η+1) + c²)) n) / η (Heckbert's vector form,
/// with the root written so that nothing cancels for η near 1).
///
/// - `direction`: unit vector of travel, d.
/// - `normal`: unit normal on the side light arrives from: d·n ≤ 0.
/// - `eta`: η = `n_transmitted / n_incident`.
///
/// For `eta` = 1 the direction is returned unchanged, bit for bit. As for [`reflect`], the length is kept to
/// a few units in the last place.
#[inline]
pub fn refract(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    if eta == 1.0 {
        return Some(direction);
    }
    let cos_incident = -direction.dot(normal);
    let eta_cos_squared = eta_cos_squared(cos_incident, eta);
    if eta_cos_squared <= 0.0 {
        return None;
    }
    Some((direction + normal * (cos_incident - eta_cos_squared.sqrt())) / eta)
}
