//! Bounds on rounding errors.

/// The unit roundoff u = 2⁻⁵³ of `f64`: a sum, product, quotient or square root that is rounded to nearest is
/// off by at most this fraction of itself.
pub(super) const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// γₙ = n u / (1 − n u): a bound on the relative error of a product of n roundings.
///
/// Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd edition, lemma 3.1.
#[inline]
pub(super) const fn gamma(n: u32) -> f64 {
    let nu = n as f64 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}
