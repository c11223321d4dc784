//! The 256-bit and rational arithmetic that exact variances need.

use super::fixed_point::power_of_two;

/// An unsigned integer below 2²⁵⁶: `high` 2¹²⁸ + `low`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Wide {
    high: u128,
    low: u128,
}

impl Wide {
    /// The full product of two 128-bit integers.
    pub(crate) fn product(a: u128, b: u128) -> Self {
        const HALF: u128 = (1 << 64) - 1;
        let (a_high, a_low) = (a >> 64, a & HALF);
        let (b_high, b_low) = (b >> 64, b & HALF);
        let low = a_low * b_low;
        // Neither sum overflows: (2^64 − 1)² + 2 (2^64 − 1) = 2^128 − 1.
        let middle = a_high * b_low + (low >> 64);
        let other_middle = a_low * b_high + (middle & HALF);
        Self {
            high: a_high * b_high + (middle >> 64) + (other_middle >> 64),
            low: (other_middle << 64) | (low & HALF),
        }
    }

    /// The difference; `None` if `other` is larger.
    pub(crate) fn checked_sub(self, other: Self) -> Option<Self> {
        let (low, borrow) = self.low.overflowing_sub(other.low);
        let high = self
            .high
            .checked_sub(other.high)?
            .checked_sub(u128::from(borrow))?;
        Some(Self { high, low })
    }

    /// The nearest `f64`, ties to even.
    pub(crate) fn to_f64(self) -> f64 {
        if self.high == 0 {
            return self.low as f64;
        }
        // The leading 128 bits hold the 53 that stay and the one that decides. Any bit below only breaks
        // ties, and may as well stand in the last place.
        let shift = self.high.leading_zeros();
        let (leading, rest) = if shift == 0 {
            (self.high, self.low)
        } else {
            (
                self.high << shift | self.low >> (128 - shift),
                self.low << shift,
            )
        };
        (leading | u128::from(rest != 0)) as f64 * power_of_two(128 - shift.cast_signed())
    }
}

/// `numerator / denominator`, the nearest `f64`, ties to even; NaN for 0/0, infinite for n/0.
pub(crate) fn quotient(numerator: i128, denominator: u64) -> f64 {
    let magnitude = numerator.unsigned_abs();
    if denominator == 0 || magnitude == 0 {
        return numerator as f64 / denominator as f64;
    }
    // At least 64 leading bits of the quotient; a remainder only breaks ties.
    let shift = magnitude.leading_zeros();
    let divisor = u128::from(denominator);
    let leading = (magnitude << shift) / divisor;
    let remains = !(magnitude << shift).is_multiple_of(divisor);
    let rounded = (leading | u128::from(remains)) as f64 * power_of_two(-shift.cast_signed());
    if numerator < 0 { -rounded } else { rounded }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;
    use proptest::prelude::*;

    #[test]
    fn the_largest_product_is_right() {
        let square = Wide::product(u128::MAX, u128::MAX);
        assert_eq!(
            square,
            Wide {
                high: u128::MAX - 1,
                low: 1
            }
        );
        assert_eq!(square.to_f64(), math::powi(2f64, 256));
    }

    #[test]
    fn rounding_sees_the_last_bit() {
        // 2^200 + 2^147 is half way between neighbours: ties to even, one more bit goes up.
        let tie = Wide {
            high: 1 << 72 | 1 << 19,
            low: 0,
        };
        assert_eq!(tie.to_f64(), math::powi(2f64, 200));
        let above = Wide { low: 1, ..tie };
        assert_eq!(above.to_f64(), math::powi(2f64, 200).next_up());
    }

    proptest! {
        #[test]
        fn products_obey_the_binomial_formula(a: u64, b: u64, c in 0..1u128 << 60) {
            // (x + c)² − x² = 2xc + c² with x of 126 bits, so that the right side also fits 256 bits.
            let x = u128::from(a) << 62 | u128::from(b >> 2);
            let difference = Wide::product(x + c, x + c).checked_sub(Wide::product(x, x)).unwrap();
            prop_assert_eq!(difference, Wide::product(2 * x + c, c));
        }

        #[test]
        fn quotients_of_small_integers_are_those_of_the_processor(n in -1i64 << 53..1 << 53, d in 1u64..1 << 53) {
            // Both are doubles, so one IEEE division is correctly rounded.
            prop_assert_eq!(quotient(i128::from(n), d), n as f64 / d as f64);
        }

        #[test]
        fn whole_quotients_are_correctly_rounded(q: i64, d in 1u64..1 << 62) {
            // Rust rounds integers to nearest even.
            prop_assert_eq!(quotient(i128::from(q) * i128::from(d), d), q as f64);
        }
    }
}
