//! Arithmetic with twice the digits of `f64`: the exact answer beside which rounding is measured.

use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::DVec3;

/// An unevaluated sum of two `f64`, the second at most half a unit in the last place of the first.
///
/// Every operation is off by a few times 2⁻¹⁰⁴ of its result: Dekker, *A floating-point technique for
/// extending the available precision*, Numerische Mathematik 18 (1971), with products by fused multiply-add.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    high: f64,
    low: f64,
}

impl Exact {
    pub const ZERO: Self = Self {
        high: 0.0,
        low: 0.0,
    };
    pub const ONE: Self = Self {
        high: 1.0,
        low: 0.0,
    };

    /// The nearest `f64`.
    pub fn value(self) -> f64 {
        self.high
    }

    /// a + b without any error (Knuth's two-sum).
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        Self {
            high,
            low: (a - (high - of_b)) + (b - of_b),
        }
    }

    /// The square root of a number that is not negative: Newton's step from the rounded root.
    pub fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::ZERO;
        }
        let root = Self::from(self.high.sqrt());
        root + (self - root * root) / (root + root)
    }

    pub fn is_negative(self) -> bool {
        self.high < 0.0
    }

    /// Error of an `f64`, as a fraction of this.
    pub fn relative_error_of(self, rounded: f64) -> f64 {
        ((Self::from(rounded) - self) / self).value().abs()
    }

    /// Error of an `f64`.
    pub fn error_of(self, rounded: f64) -> f64 {
        (Self::from(rounded) - self).value().abs()
    }
}

impl From<f64> for Exact {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Exact {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let high = Self::sum(self.high, other.high);
        let low = Self::sum(self.low, other.low);
        let first = Self::sum(high.high, high.low + low.high);
        Self::sum(first.high, first.low + low.low)
    }
}

impl Neg for Exact {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for Exact {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Exact {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        let rest = self.high.mul_add(other.high, -high);
        Self::sum(high, rest + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Exact {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        Self::sum(first, second) + Self::from(rest.high / other.high)
    }
}

/// A vector with twice the digits.
#[derive(Clone, Copy, Debug)]
pub struct Exact3(pub [Exact; 3]);

impl Exact3 {
    pub fn dot(self, other: Self) -> Exact {
        let [a, b, c] = self.0;
        let [x, y, z] = other.0;
        a * x + b * y + c * z
    }

    pub fn cross(self, other: Self) -> Self {
        let [a, b, c] = self.0;
        let [x, y, z] = other.0;
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    pub fn scaled(self, factor: Exact) -> Self {
        Self(self.0.map(|it| it * factor))
    }

    pub fn length(self) -> Exact {
        self.dot(self).sqrt()
    }

    pub fn value(self) -> DVec3 {
        DVec3::from(self.0.map(Exact::value))
    }
}

impl From<DVec3> for Exact3 {
    fn from(vector: DVec3) -> Self {
        Self(vector.to_array().map(Exact::from))
    }
}

impl Add for Exact3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Exact3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}
