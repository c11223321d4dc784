//! Fixed-point numbers: sums of integers commute, so that threads may add in any order.

/// A fixed-point scale: the quantum 2^e of some quantity, which is then a 64-bit number of quanta.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FixedPoint {
    exponent: i32,
}

/// Reasons why there is no quantum for a total.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FixedPointError {
    /// NaN, infinite, negative, or far outside any physical magnitude.
    #[error("a total of {0} has no fixed-point scale: allowed are 0 and 1e-250..=1e250")]
    TotalOutOfRange(f64),
    /// Outside [`FixedPoint::EXPONENTS`].
    #[error("a quantum of 2^{0} is out of range: allowed are exponents -892..=892")]
    ExponentOutOfRange(i32),
}

impl FixedPoint {
    /// The exponents of 2 allowed for a quantum. Within them neither a quantum, its inverse, nor any 128-bit
    /// number of quanta (2^±127) leaves the normal range of `f64` (2^-1022..2^1024).
    pub const EXPONENTS: std::ops::RangeInclusive<i32> = -892..=892;

    /// Number of bits of a total in quanta.
    const TOTAL_BITS: i32 = 60;

    /// The scale for a total of one.
    pub const OF_ONE: Self = Self {
        exponent: -Self::TOTAL_BITS,
    };

    /// The scale with the quantum 2^exponent.
    ///
    /// # Errors
    ///
    /// For an exponent outside [`FixedPoint::EXPONENTS`].
    pub fn new(exponent: i32) -> Result<Self, FixedPointError> {
        if Self::EXPONENTS.contains(&exponent) {
            Ok(Self { exponent })
        } else {
            Err(FixedPointError::ExponentOutOfRange(exponent))
        }
    }

    /// The scale for quantities whose sum of magnitudes is about `max_abs_total`.
    ///
    /// The quantum is 2⁻⁶⁰ of the smallest power of two that is not below `max_abs_total`. So any sum of at
    /// most `4 max_abs_total` has at most 2⁶² quanta and fits `i64` with a bit to spare. Each quantised value
    /// is wrong by at most half a quantum: below `max_abs_total` 2⁻⁶⁰. A total of zero (no light) gets the
    /// scale of a total of one.
    ///
    /// # Errors
    ///
    /// For a total that is NaN, infinite, negative, or neither zero nor in 1e-250..=1e250.
    pub fn for_total(max_abs_total: f64) -> Result<Self, FixedPointError> {
        if max_abs_total == 0.0 {
            return Ok(Self {
                exponent: -Self::TOTAL_BITS,
            });
        }
        if !(1e-250..=1e250).contains(&max_abs_total) {
            return Err(FixedPointError::TotalOutOfRange(max_abs_total));
        }
        // For a normal number the biased exponent is the floor of its logarithm.
        let bits = max_abs_total.to_bits();
        let floor = (bits >> 52) as i32 - 1023;
        let is_power_of_two = bits & ((1 << 52) - 1) == 0;
        let ceiling = floor + i32::from(!is_power_of_two);
        Ok(Self {
            exponent: ceiling - Self::TOTAL_BITS,
        })
    }

    /// The quantum's exponent of 2.
    pub const fn exponent(self) -> i32 {
        self.exponent
    }

    /// The quantum 2^e itself; exact.
    #[inline]
    pub const fn quantum(self) -> f64 {
        power_of_two(self.exponent)
    }

    /// The nearest number of quanta, ties to even; `None` if `value` is not finite or the number leaves
    /// `i64`.
    #[inline]
    pub fn quantise(self, value: f64) -> Option<i64> {
        // Scaling by a power of two is exact, except for results so small that they round to 0 anyway, or
        // infinite and so out of range.
        let quanta = round_ties_even(value * power_of_two(-self.exponent));
        // The largest double below 2^63 fits an `i64`. The test is false for NaN.
        (-TWO_TO_63..TWO_TO_63)
            .contains(&quanta)
            .then_some(quanta as i64)
    }

    /// The value of `quanta`, correctly rounded.
    #[inline]
    pub const fn value_i64(self, quanta: i64) -> f64 {
        quanta as f64 * self.quantum()
    }

    /// The value of `quanta`, correctly rounded.
    #[inline]
    pub const fn value_i128(self, quanta: i128) -> f64 {
        quanta as f64 * self.quantum()
    }
}

/// The nearest whole number, ties to even, in two additions. `f64::round_ties_even` would be a call into the
/// C library if the target's baseline has no such instruction (x86-64).
#[inline]
fn round_ties_even(value: f64) -> f64 {
    // Between 2⁵² and 2⁵³ the doubles are the whole numbers: adding 2⁵² to a magnitude below that rounds to
    // one. From 2⁵² on all doubles are whole.
    const SHIFT: f64 = power_of_two(52);
    if value.abs() < SHIFT {
        ((value.abs() + SHIFT) - SHIFT).copysign(value)
    } else {
        value
    }
}

const TWO_TO_63: f64 = power_of_two(63);

/// 2^exponent, exactly, for exponents in -1022..=1023.
pub(super) const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;
    use proptest::prelude::*;

    #[test]
    fn four_totals_fit_and_the_quantum_is_as_promised() {
        for total in [1.0, 1.5, 2.0, 3.7e-12, 8.1e200, 1e-250, 1e250] {
            let scale = FixedPoint::for_total(total).unwrap();
            assert!(scale.quantise(4.0 * total).unwrap() <= 1 << 62);
            // Smallest power of two at or above: total > half of it.
            assert!(scale.quantise(total).unwrap() > 1 << 59);
            assert!(FixedPoint::new(scale.exponent()).is_ok());
        }
        assert_eq!(FixedPoint::for_total(1.0).unwrap().exponent(), -60);
        assert_eq!(FixedPoint::for_total(1.25).unwrap().exponent(), -59);
        assert_eq!(FixedPoint::for_total(0.0).unwrap().exponent(), -60);
    }

    #[test]
    fn totals_and_exponents_out_of_range_are_refused() {
        for total in [-1.0, f64::NAN, f64::INFINITY, 1e-251, 1e251, 5e-324] {
            assert!(FixedPoint::for_total(total).is_err(), "{total}");
        }
        assert!(FixedPoint::new(893).is_err());
        assert!(FixedPoint::new(-893).is_err());
    }

    #[test]
    fn ties_go_to_even_and_what_does_not_fit_is_none() {
        let scale = FixedPoint::new(1).unwrap();
        assert_eq!(scale.quantise(1.0), Some(0));
        assert_eq!(scale.quantise(3.0), Some(2));
        assert_eq!(scale.quantise(-3.0), Some(-2));
        assert_eq!(scale.quantise(5e-324), Some(0));
        assert_eq!(scale.quantise(f64::NAN), None);
        assert_eq!(scale.quantise(f64::INFINITY), None);
        assert_eq!(scale.quantise(-(math::powi(2f64, 64))), Some(i64::MIN));
        assert_eq!(scale.quantise(math::powi(2f64, 64)), None);
        assert_eq!(FixedPoint::new(-892).unwrap().quantise(f64::MAX), None);
    }

    #[test]
    fn rounding_is_that_of_the_standard_library_at_every_magnitude() {
        let halves = [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.5, 3.5];
        for exponent in 0..64 {
            for half in halves {
                let near = power_of_two(exponent) + half;
                for value in [near, near.next_up(), near.next_down()] {
                    for value in [value, -value] {
                        assert_eq!(round_ties_even(value), value.round_ties_even(), "{value}");
                    }
                }
            }
        }
        assert!(round_ties_even(f64::NAN).is_nan());
    }

    proptest! {
        #[test]
        fn a_quantised_value_is_within_half_a_quantum(mantissa in -1.0..1.0f64, exponent in -80..80) {
            let value = mantissa * math::powi(2f64, exponent);
            let scale = FixedPoint::for_total(value.abs()).unwrap();
            let back = scale.value_i64(scale.quantise(value).unwrap());
            // Both have at most 60 bits above the quantum and a double has 53: the difference is exact.
            prop_assert!((back - value).abs() <= 0.5 * scale.quantum());
        }
    }
}
