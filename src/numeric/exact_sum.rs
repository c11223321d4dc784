//! Sums of floating-point numbers with a single rounding at the end.

use std::ops::AddAssign;

use super::fixed_point::power_of_two;

/// Bits a digit.
const DIGIT_BITS: u32 = 32;

/// Digits that hold any sum. A double's lowest bit weighs 2⁻¹⁰⁷⁴ and its highest 2¹⁰²³, which is 2098 bits.
/// 2⁶⁴ addends need 64 more and the sign one: 2163 bits, 68 digits.
const DIGITS: usize = 68;

/// Additions between carries. Each adds less than 2³² to a digit that is below 2³² after a carry: 2³⁰ of them
/// stay below 2⁶³.
const ADDITIONS_PER_CARRY: u32 = 1 << 30;

/// The exact sum of any `f64`s, rounded once when it is read.
///
/// It does not depend on order, grouping or threads, to the bit. It is a fixed-point number that spans the
/// whole range of `f64`; its digits may exceed their range for a while, so that carries are rare. This is
/// Neal's *small superaccumulator* (*Fast Exact Summation Using Small and Large Superaccumulators*, 2015,
/// section 3). NaN and the infinities are counted apart and decide [`ExactSum::value`] as they would decide
/// an IEEE 754 sum.
///
/// ```
/// # use nephroid::internals::numeric::ExactSum;
/// let sum: ExactSum = [1e300, 1.0, -1e300].into_iter().collect();
/// assert_eq!(sum.value(), 1.0); // in floating point: 0
/// ```
#[derive(Clone)]
pub struct ExactSum {
    /// Digit i weighs 2^(32 i − 1074); signed, and possibly beyond 32 bits between carries.
    digits: [i64; DIGITS],
    additions_since_carry: u32,
    nans: u64,
    positive_infinities: u64,
    negative_infinities: u64,
}

impl ExactSum {
    /// The empty sum, zero.
    pub const fn new() -> Self {
        Self {
            digits: [0; DIGITS],
            additions_since_carry: 0,
            nans: 0,
            positive_infinities: 0,
            negative_infinities: 0,
        }
    }

    /// Adds one number.
    pub fn add(&mut self, value: f64) {
        let bits = value.to_bits();
        let biased_exponent = (bits >> 52) as usize & 0x7ff;
        let fraction = bits & ((1 << 52) - 1);
        // The mantissa's lowest bit weighs 2^(position − 1074); subnormals share the lowest exponent.
        let (mantissa, position) = match biased_exponent {
            0x7ff => return self.count_not_finite(value),
            0 => (fraction, 0),
            exponent => (fraction | 1 << 52, exponent - 1),
        };
        if self.additions_since_carry == ADDITIONS_PER_CARRY {
            self.carry();
        }
        self.additions_since_carry += 1;
        let digit = position / DIGIT_BITS as usize;
        let shifted = u128::from(mantissa) << (position % DIGIT_BITS as usize);
        for i in 0..3 {
            let part = (shifted >> (DIGIT_BITS * i) as usize) as u32;
            let signed = if value < 0.0 {
                -i64::from(part)
            } else {
                i64::from(part)
            };
            self.digits[digit + i as usize] += signed;
        }
    }

    /// Adds all the numbers that were added to `other`.
    pub fn merge(&mut self, other: &Self) {
        // After a carry digits are below 2^32 (the highest stays below the 2^19 that 2^64 addends can reach),
        // so this counts as one addition to each.
        self.carry();
        let mut other = other.clone();
        other.carry();
        for (digit, addend) in self.digits.iter_mut().zip(other.digits) {
            *digit += addend;
        }
        self.additions_since_carry = 1;
        self.nans += other.nans;
        self.positive_infinities += other.positive_infinities;
        self.negative_infinities += other.negative_infinities;
    }

    /// Number of addends that were NaN or infinite.
    pub const fn not_finite_count(&self) -> u64 {
        self.nans + self.positive_infinities + self.negative_infinities
    }

    /// The sum, rounded to nearest, ties to even; ±∞ if it exceeds the largest double.
    ///
    /// NaN if a NaN or infinities of both signs were added; infinite if only those of one sign were. A zero
    /// sum is +0.
    pub fn value(&self) -> f64 {
        if self.nans > 0 || (self.positive_infinities > 0 && self.negative_infinities > 0) {
            return f64::NAN;
        }
        if self.positive_infinities > 0 {
            return f64::INFINITY;
        }
        if self.negative_infinities > 0 {
            return f64::NEG_INFINITY;
        }
        let mut magnitude = self.clone();
        magnitude.carry();
        let negative = magnitude.digits[DIGITS - 1] < 0;
        if negative {
            magnitude.digits = magnitude.digits.map(|digit| -digit);
            magnitude.carry();
        }
        let rounded = round(&magnitude.digits);
        if negative { -rounded } else { rounded }
    }

    fn count_not_finite(&mut self, value: f64) {
        if value.is_nan() {
            self.nans += 1;
        } else if value > 0.0 {
            self.positive_infinities += 1;
        } else {
            self.negative_infinities += 1;
        }
    }

    /// Brings all digits but the highest into 0..2³²; the highest takes the sum's sign.
    fn carry(&mut self) {
        let mut carry = 0;
        for digit in &mut self.digits[..DIGITS - 1] {
            let value = *digit + carry;
            carry = value >> DIGIT_BITS; // rounds down, negative ones too
            *digit = value - (carry << DIGIT_BITS);
        }
        self.digits[DIGITS - 1] += carry;
        self.additions_since_carry = 0;
    }
}

/// The nearest double to digits that are all in 0..2³², ties to even.
fn round(digits: &[i64; DIGITS]) -> f64 {
    let Some(highest) = digits.iter().rposition(|&digit| digit != 0) else {
        return 0.0;
    };
    // 96 bits from the highest digits, of which at least 65 are significant. Anything left below can only
    // break a tie.
    let lowest = highest.saturating_sub(2);
    let leading = digits[lowest..=highest]
        .iter()
        .rev()
        .fold(0u128, |bits, &digit| bits << DIGIT_BITS | digit as u128);
    let sticky = digits[..lowest].iter().any(|&digit| digit != 0);
    let leading = leading | u128::from(sticky);
    // `lowest` = 0 is exact for subnormals: their digits are integers below 2^53 and weigh 2^-1074 each. For
    // all others `leading` rounds to a normal double, and the scaling is exact.
    scale(leading as f64, lowest)
}

/// The product of `value` and the weight of a digit, 2^(32 i − 1074); exact unless it overflows.
///
/// The weight's square root is applied twice: the lowest weight is a subnormal, its root is not.
#[expect(clippy::cast_possible_wrap, reason = "a digit's number is below 68")]
fn scale(value: f64, digit: usize) -> f64 {
    let root = power_of_two(16 * digit as i32 - 537);
    value * root * root
}

impl Default for ExactSum {
    fn default() -> Self {
        Self::new()
    }
}

impl std::fmt::Debug for ExactSum {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ExactSum")
            .field("value", &self.value())
            .field("not_finite_count", &self.not_finite_count())
            .finish()
    }
}

impl AddAssign<f64> for ExactSum {
    fn add_assign(&mut self, value: f64) {
        self.add(value);
    }
}

impl Extend<f64> for ExactSum {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, values: I) {
        values.into_iter().for_each(|value| self.add(value));
    }
}

impl FromIterator<f64> for ExactSum {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut sum = Self::new();
        sum.extend(values);
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;
    use proptest::prelude::*;

    /// A signed integer of 2304 bits in units of 2⁻¹⁰⁷⁵ (half the smallest double), in two's complement: room
    /// for any double, its half, and sums of thousands. The expected value of these tests.
    #[derive(Clone, PartialEq)]
    struct Big([u64; 36]);

    impl Big {
        fn from_f64(value: f64) -> Self {
            let bits = value.abs().to_bits();
            let exponent = (bits >> 52).max(1) as usize;
            let implicit = u64::from(bits >> 52 > 0) << 52;
            let mantissa = (bits & ((1 << 52) - 1)) | implicit;
            let mut big = [0; 36];
            // 2^-1074 is the unit of exponent 1, and one place above the unit of this type.
            let shifted = u128::from(mantissa) << (exponent % 64);
            big[exponent / 64] = shifted as u64;
            big[exponent / 64 + 1] = (shifted >> 64) as u64;
            if value < 0.0 {
                Self(big).negated()
            } else {
                Self(big)
            }
        }

        fn negated(&self) -> Self {
            Self(self.0.map(|word| !word)).plus(&Self(std::array::from_fn(|i| u64::from(i == 0))))
        }

        fn plus(&self, other: &Self) -> Self {
            let mut carry = 0;
            Self(std::array::from_fn(|i| {
                let sum = u128::from(self.0[i]) + u128::from(other.0[i]) + carry;
                carry = sum >> 64;
                sum as u64
            }))
        }

        fn minus(&self, other: &Self) -> Self {
            self.plus(&other.negated())
        }

        fn magnitude(&self) -> Vec<u64> {
            let positive = if self.0[35] >> 63 == 1 {
                self.negated()
            } else {
                self.clone()
            };
            positive.0.iter().rev().copied().collect() // comparable: most significant first
        }
    }

    /// Asserts that no other double is nearer to the exact sum, and that a tie is even.
    fn assert_correctly_rounded(values: &[f64]) -> f64 {
        let sum: ExactSum = values.iter().copied().collect();
        let rounded = sum.value();
        let exact = values
            .iter()
            .fold(Big([0; 36]), |sum, &value| sum.plus(&Big::from_f64(value)));
        assert!(rounded.is_finite());
        let distance = |to: f64| exact.minus(&Big::from_f64(to)).magnitude();
        for neighbour in [rounded.next_up(), rounded.next_down()] {
            if neighbour.is_finite() {
                let order = distance(rounded).cmp(&distance(neighbour));
                assert!(
                    order.is_le(),
                    "{values:?}: {rounded:e}, but {neighbour:e} is nearer"
                );
                assert!(
                    order.is_lt() || rounded.to_bits().is_multiple_of(2),
                    "{values:?}: odd tie"
                );
            }
        }
        rounded
    }

    /// Any finite double below 2^1000, all exponents alike, so that sums stay finite.
    fn any_double() -> impl Strategy<Value = f64> {
        let bits = 0u64..((1000 + 1023) << 52);
        (bits, any::<bool>()).prop_map(|(bits, negative)| {
            let value = f64::from_bits(bits);
            if negative { -value } else { value }
        })
    }

    /// Doubles that cancel and tie: few bits, near exponents.
    fn near_double() -> impl Strategy<Value = f64> {
        (-8i32..=8, -60i32..60).prop_map(|(m, e)| f64::from(m) * math::powi(2f64, e))
    }

    proptest! {
        #[test]
        fn sums_over_the_whole_range_are_correctly_rounded(
            values in prop::collection::vec(any_double(), 0..40)
        ) {
            assert_correctly_rounded(&values);
        }

        #[test]
        fn sums_that_cancel_and_tie_are_correctly_rounded(
            values in prop::collection::vec(near_double(), 0..12)
        ) {
            assert_correctly_rounded(&values);
        }

        #[test]
        fn subnormal_sums_are_exact(values in prop::collection::vec(0u64..1 << 53, 0..9)) {
            let values: Vec<f64> = values.into_iter().map(f64::from_bits).collect();
            // Multiples of 2^-1074 below 2^-1018 keep every bit in floating point as long as no sum needs 54.
            assert_correctly_rounded(&values);
        }

        #[test]
        fn order_and_grouping_change_no_bit(
            (values, shuffled) in prop::collection::vec(any_double(), 0..60)
                .prop_flat_map(|values| (Just(values.clone()), Just(values).prop_shuffle())),
            split in 0usize..60,
        ) {
            let sum: ExactSum = values.iter().copied().collect();
            let (first, second) = shuffled.split_at(split.min(shuffled.len()));
            let mut merged: ExactSum = first.iter().copied().collect();
            merged.merge(&second.iter().copied().collect());
            prop_assert_eq!(sum.value().to_bits(), merged.value().to_bits());
        }
    }

    #[test]
    fn ties_go_to_even() {
        let half_ulp = 0.5 * f64::EPSILON;
        assert_eq!(assert_correctly_rounded(&[1.0, half_ulp]), 1.0);
        assert_eq!(
            assert_correctly_rounded(&[1.0, f64::EPSILON, half_ulp]),
            1.0 + 2.0 * f64::EPSILON
        );
        assert_eq!(
            assert_correctly_rounded(&[1.0, half_ulp, 5e-324]),
            1.0f64.next_up()
        );
        assert_eq!(
            assert_correctly_rounded(&[-1.0, -half_ulp, -5e-324]),
            -(1.0f64.next_up())
        );
    }

    #[test]
    fn overflow_is_infinite_and_only_at_the_end() {
        let sum: ExactSum = [f64::MAX, f64::MAX, -f64::MAX].into_iter().collect();
        assert_eq!(sum.value(), f64::MAX);
        let sum: ExactSum = [f64::MAX, f64::MAX].into_iter().collect();
        assert_eq!(sum.value(), f64::INFINITY);
        let half_ulp = math::powi(2f64, 970);
        let sum: ExactSum = [-f64::MAX, -half_ulp].into_iter().collect();
        assert_eq!(sum.value(), f64::NEG_INFINITY);
    }

    #[test]
    fn what_is_not_finite_is_counted_and_decides() {
        let value = |values: &[f64]| values.iter().copied().collect::<ExactSum>().value();
        assert_eq!(value(&[1.0, f64::INFINITY]), f64::INFINITY);
        assert_eq!(value(&[f64::NEG_INFINITY, f64::MAX]), f64::NEG_INFINITY);
        assert!(value(&[f64::NEG_INFINITY, f64::INFINITY]).is_nan());
        assert!(value(&[f64::NAN]).is_nan());
        let sum: ExactSum = [f64::NAN, f64::INFINITY, 1.0].into_iter().collect();
        assert_eq!(sum.not_finite_count(), 2);
    }

    #[test]
    fn an_empty_sum_and_one_that_cancels_are_positive_zero() {
        assert_eq!(ExactSum::new().value().to_bits(), 0);
        let sum: ExactSum = [1e-300, -1e-300, -0.0].into_iter().collect();
        assert_eq!(sum.value().to_bits(), 0);
    }

    #[test]
    fn carries_keep_the_sum_when_they_are_forced() {
        // As after 2^30 additions, without doing them.
        let mut sum = ExactSum::new();
        for value in [1e300, -3.5, 1e-300, f64::MAX, -f64::MAX, -1e300] {
            sum.additions_since_carry = ADDITIONS_PER_CARRY;
            sum.add(value);
        }
        assert_eq!(sum.value(), -3.5);
    }
}
