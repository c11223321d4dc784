//! Sums of floating-point numbers without any rounding until the end.

use std::ops::AddAssign;

use super::fixed_point::power_of_two;

/// Bits a digit.
const DIGIT_BITS: u32 = 32;

/// Digits that hold any sum: a double's lowest bit weighs 2⁻¹⁰⁷⁴ and its highest 2¹⁰²³, which is
/// 2098 bits, and 2⁶⁴ addends need 64 more and the sign one: 2163 bits, 68 digits.
const DIGITS: usize = 68;

/// Additions between carries. Each adds less than 2³² to a digit that is below 2³² after a
/// carry: 2³⁰ of them stay below 2⁶³.
const ADDITIONS_PER_CARRY: u32 = 1 << 30;

/// The exact sum of any `f64`s, rounded once when it is asked for.
///
/// Order, grouping and threads cannot change a bit of it. A fixed-point number that spans the
/// whole range of `f64`, its digits loose so that carries are rare: Neal's *small
/// superaccumulator* (*Fast Exact Summation Using Small and Large Superaccumulators*, 2015,
/// section 3). NaN and the infinities are counted apart and decide [`ExactSum::value`] as they
/// would decide an IEEE 754 sum.
///
/// ```
/// # use nephroid::numeric::ExactSum;
/// let sum: ExactSum = [1e300, 1.0, -1e300].into_iter().collect();
/// assert_eq!(sum.value(), 1.0); // in floating point: 0
/// ```
#[derive(Clone)]
pub struct ExactSum {
    /// Digit i weighs 2^(32 i − 1074); signed and loose between carries.
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

    /// Adds all that was added to `other`.
    pub fn merge(&mut self, other: &Self) {
        // After a carry digits are below 2^32 (the highest: below the sum's 2^19 of its 2^64
        // addends at most), so this counts as one addition to each.
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

    /// How many of the numbers were NaN or infinite.
    pub const fn not_finite_count(&self) -> u64 {
        self.nans + self.positive_infinities + self.negative_infinities
    }

    /// The sum, rounded to nearest, ties to even; ±∞ where it exceeds the largest double.
    ///
    /// NaN where a NaN, or infinities of both signs, were added; infinite where those of one
    /// sign were. A zero sum is +0.
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

    /// Brings all digits but the highest into 0..2³²; the highest has the sum's sign.
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
    // 96 bits from the highest digits, of which at least 65 are significant, and whether
    // anything is left below, which can only break a tie.
    let lowest = highest.saturating_sub(2);
    let leading = digits[lowest..=highest]
        .iter()
        .rev()
        .fold(0u128, |bits, &digit| bits << DIGIT_BITS | digit as u128);
    let sticky = digits[..lowest].iter().any(|&digit| digit != 0);
    let leading = leading | u128::from(sticky);
    // `lowest` = 0 is exact for subnormals: their digits are integers below 2^53 and weigh
    // 2^-1074 each. Elsewhere `leading` rounds to a normal double, and the scaling is exact.
    scale(leading as f64, lowest)
}

/// `value` times the weight of a digit, 2^(32 i − 1074); exact unless it overflows.
///
/// By the weight's square root, twice: the lowest weight is a subnormal, its root is not.
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
