//! Formulas whose results are as good as rounded once.
#![allow(clippy::inline_always)] // or the code is not compiled for its caller's instructions

use std::ops::{Add, Div, Mul, Sub};

/// A number with what rounding took from it, to first order: `value + error` is the result of the same formula without
/// any rounding, but for products of two roundings.
///
/// The errors of single operations are exact: Knuth's sum, and products by fused multiply-add (Ogita, Rump and Oishi,
/// *Accurate sum and dot product*, SIAM J. Sci. Comput. 26 (2005), 2.1). A formula carries them along by its own
/// derivative. So [`Compensated::rounded`] is off by one rounding and some dozen u² times the formula's condition number.
///
/// Where a difference of inexact numbers loses all digits, `error` may be as large as `value`: quotients by it and roots
/// of it want [`Compensated::settled`] first.
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
        let value = self.rounded();
        Self {
            value,
            error: (self.value - value) + self.error,
        }
    }

    /// The square root of a positive, settled number.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        let squared = Self::product(value, value);
        // The root's square is the number but for its last digits: their difference is exact.
        let remains = (self.value - squared.value) - squared.error + self.error;
        Self {
            value,
            error: remains * (0.5 / value),
        }
    }

    /// The square.
    #[inline(always)]
    pub fn squared(self) -> Self {
        let square = Self::product(self.value, self.value);
        Self {
            error: square.error + 2.0 * self.value * self.error,
            ..square
        }
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

impl Sub for Compensated {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let difference = Self::sum(self.value, -other.value);
        Self {
            error: difference.error + (self.error - other.error),
            ..difference
        }
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
        // One division: what that leaves to the quotient by a second rounding, the error has.
        let inverse = 1.0 / other.value;
        let value = self.value * inverse;
        let back = Self::product(value, other.value);
        // The quotient times the divisor is the dividend but for its last digits: their difference is exact.
        let remains = (self.value - back.value) - back.error + self.error - value * other.error;
        Self {
            value,
            error: remains * inverse,
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
        let difference = Compensated::sum(self, -other.value);
        Compensated {
            error: difference.error - other.error,
            ..difference
        }
    }
}
