//! Arithmetic that compensates for rounding.
#![allow(clippy::inline_always)] // or the code is not compiled for its caller's instructions

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number with the error that rounding made in it, to first order.
///
/// `value + error` is the result of the same formula without any rounding, except for products of two
/// rounding errors. The errors of single operations are exact: Knuth's sum, and products by fused
/// multiply-add (Ogita, Rump and Oishi, *Accurate sum and dot product*, SIAM J. Sci. Comput. 26 (2005), 2.1).
/// A formula carries them along by its own derivative. So [`Compensated::rounded`] is off by one rounding and
/// some dozen u² times the formula's condition number.
///
/// No product may overflow; what underflows is lost. If a difference of inexact numbers loses its digits,
/// `error` may be as large as `value`. Call [`Compensated::settled`] before taking roots of such a number or
/// dividing by it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compensated {
    value: f64,
    error: f64,
}

impl Compensated {
    /// a + b.
    #[inline(always)]
    pub fn sum(a: f64, b: f64) -> Self {
        let value = a + b;
        let of_b = value - a;
        Self {
            value,
            error: (a - (value - of_b)) + (b - of_b),
        }
    }

    /// a b.
    #[inline(always)]
    pub fn product(a: f64, b: f64) -> Self {
        let value = a * b;
        Self {
            value,
            error: a.mul_add(b, -value),
        }
    }

    /// The nearest `f64`.
    #[inline(always)]
    pub fn rounded(self) -> f64 {
        self.value + self.error
    }

    /// The same number, its error at most half a unit in its last place.
    #[inline(always)]
    pub fn settled(self) -> Self {
        Self::sum(self.value, self.error)
    }

    /// The square root of a positive, settled number.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        let squared = Self::product(value, value);
        // The root's square equals the number except in its last digits: their difference is exact.
        let remains = (self.value - squared.value) - squared.error + self.error;
        Self {
            value,
            error: remains * (0.5 / value),
        }
    }

    /// The square.
    #[inline(always)]
    pub fn squared(self) -> Self {
        self * self
    }
}

impl Add for Compensated {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let sum = Self::sum(self.value, other.value);
        Self {
            error: sum.error + (self.error + other.error),
            ..sum
        }
    }
}

impl Neg for Compensated {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            error: -self.error,
        }
    }
}

impl Sub for Compensated {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.add(-other)
    }
}

impl Mul for Compensated {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let product = Self::product(self.value, other.value);
        Self {
            error: product.error + (self.value * other.error + other.value * self.error),
            ..product
        }
    }
}

impl Div for Compensated {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let back = Self::product(value, other.value);
        // The quotient times the divisor equals the dividend except in its last digits: their difference is
        // exact.
        let remains = (self.value - back.value) - back.error + self.error - value * other.error;
        Self {
            value,
            error: remains / other.value,
        }
    }
}

impl Add<f64> for Compensated {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        let sum = Self::sum(self.value, other);
        Self {
            error: sum.error + self.error,
            ..sum
        }
    }
}

impl Mul<f64> for Compensated {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        let product = Self::product(self.value, other);
        Self {
            error: product.error + self.error * other,
            ..product
        }
    }
}

impl Sub<Compensated> for f64 {
    type Output = Compensated;

    #[inline(always)]
    fn sub(self, other: Compensated) -> Compensated {
        (-other).add(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;
    use proptest::prelude::*;

    const UNIT: f64 = f64::EPSILON / 2.0;

    fn exact(x: f64) -> i128 {
        assert_eq!(x, x.trunc());
        x as i128
    }

    proptest! {
        #[test]
        fn sums_and_products_lose_nothing(a in -1_i64 << 53..1 << 53, b in -1_i64 << 53..1 << 53, shift in 0..60) {
            let (x, y) = (a as f64 * math::powi(2_f64, shift), b as f64);
            let sum = Compensated::sum(x, y);
            prop_assert_eq!(exact(sum.value) + exact(sum.error), exact(x) + exact(y));
            let product = Compensated::product(a as f64, b as f64);
            prop_assert_eq!(
                exact(product.value) + exact(product.error),
                i128::from(a) * i128::from(b)
            );
        }

        /// a/b = q + r/b with q = m 2^-s the rounded quotient: a 2^s − m b is a whole number of some 105
        /// bits.
        #[test]
        fn quotients_know_what_they_lack(a in 1_i64 << 40..1 << 50, b in 1_i64 << 40..1 << 50) {
            let quotient = Compensated::sum(a as f64, 0.0) / Compensated::sum(b as f64, 0.0);
            let scale = math::powi(2_f64, 64);
            let whole = exact(quotient.value * scale);
            let remains = (i128::from(a) << 64) - whole * i128::from(b);
            let lacks = remains as f64 / scale / b as f64;
            prop_assert!((quotient.error - lacks).abs() <= 4.0 * UNIT * lacks.abs());
        }

        /// With x² = n and x = q + e: e = (n − q²)/(2 q), except for e²/(2 q), which is u²/8 of q.
        #[test]
        fn roots_know_what_they_lack(n in 1_i64 << 40..1 << 50) {
            let root = Compensated::sum(n as f64, 0.0).sqrt();
            // q < 2^25 has 53 bits, no more than 33 of them behind the point.
            let whole = exact(root.value * math::powi(2_f64, 33));
            let remains = (i128::from(n) << 66) - whole * whole;
            let lacks = remains as f64 / math::powi(2_f64, 66) / (2.0 * root.value);
            prop_assert!((root.error - lacks).abs() <= 4.0 * UNIT * lacks.abs() + UNIT * UNIT * root.value);
        }
    }

    /// (1/3 + 1e8) − 1e8 − 1/3 = 0, though each step rounds.
    #[test]
    fn what_steps_of_a_formula_round_away_comes_back() {
        let third = Compensated::sum(1.0, 0.0) / Compensated::sum(3.0, 0.0);
        let difference = (third + 1e8 + -1e8) - third;
        assert!(difference.value.abs() > 1e-10);
        assert!(difference.rounded().abs() < 1e-23);
        assert!(difference.settled().value.abs() < 1e-23);
    }

    #[test]
    fn a_settled_number_is_the_rounded_one_and_half_a_unit() {
        let wide = Compensated {
            value: 1.0,
            error: -3.0,
        };
        let settled = wide.settled();
        assert_eq!((settled.value, settled.error), (-2.0, 0.0));
    }
}
