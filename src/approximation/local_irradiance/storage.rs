//! The numbers of tables: stage `storage`.

use half::f16;

use super::variants::Storage;
use crate::radiometry::Rgb;

/// Triples of numbers, as a table keeps them.
#[derive(Clone, Debug, PartialEq)]
pub enum Stored {
    /// Steps of range/255.
    U8 {
        /// The steps.
        steps: Vec<[u8; 3]>,
        /// The size of a step.
        step: f64,
    },
    /// Mantissas of nine bits with a shared exponent, three in a word.
    Rgb9e5(Vec<u32>),
    /// Half floats.
    F16(Vec<[f16; 3]>),
    /// Floats.
    F32(Vec<[f32; 3]>),
    /// Doubles.
    F64(Vec<[f64; 3]>),
}

impl Stored {
    /// True if all are numbers, as they are but in a foreign file.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::U8 { .. } | Self::Rgb9e5(_) => true,
            Self::F16(triples) => triples.as_flattened().iter().all(|it| it.is_finite()),
            Self::F32(triples) => triples.as_flattened().iter().all(|it| it.is_finite()),
            Self::F64(triples) => triples.as_flattened().iter().all(|it| it.is_finite()),
        }
    }

    /// The numbers as they are kept, and how many triples the range cuts off.
    pub fn new(values: Vec<[f64; 3]>, storage: Storage, range: f64) -> (Self, u64) {
        let cut = |largest: f64| {
            let above = |value: &&[f64; 3]| value.iter().any(|x| x.abs() > largest);
            values.iter().filter(above).count() as u64
        };
        match storage {
            Storage::U8 => {
                let byte = |x: f64| (x / range * 255.0).round().clamp(0.0, 255.0) as u8;
                let saturated = cut(range);
                let steps = values.iter().map(|value| value.map(byte)).collect();
                (
                    Self::U8 {
                        steps,
                        step: range / 255.0,
                    },
                    saturated,
                )
            }
            Storage::Rgb9e5 => {
                let saturated = cut(LARGEST_PACKED);
                (
                    Self::Rgb9e5(values.into_iter().map(packed).collect()),
                    saturated,
                )
            }
            Storage::F16 => {
                let largest = f16::MAX.to_f64();
                let saturated = cut(largest);
                let half = |x: f64| f16::from_f64(x.clamp(-largest, largest));
                (
                    Self::F16(values.iter().map(|value| value.map(half)).collect()),
                    saturated,
                )
            }
            Storage::F32 => {
                let single = |value: &[f64; 3]| value.map(|x| x as f32);
                (Self::F32(values.iter().map(single).collect()), 0)
            }
            Storage::Exact => (Self::F64(values), 0),
        }
    }

    /// A triple.
    #[inline]
    pub fn get(&self, index: usize) -> Rgb {
        Rgb(match self {
            Self::U8 { steps, step } => steps[index].map(|x| f64::from(x) * step),
            Self::Rgb9e5(words) => unpacked(words[index]),
            Self::F16(values) => values[index].map(widened),
            Self::F32(values) => values[index].map(f64::from),
            Self::F64(values) => values[index],
        })
    }

    /// The sum of some triples, each times a weight.
    #[inline]
    pub fn sum(&self, weighted: impl Iterator<Item = (usize, f64)>) -> Rgb {
        match self {
            Self::U8 { steps, step } => sum_of(steps, f64::from, weighted) * *step,
            Self::Rgb9e5(words) => {
                sum_of_triples(weighted.map(|(index, weight)| (unpacked(words[index]), weight)))
            }
            Self::F16(values) => sum_of(values, widened, weighted),
            Self::F32(values) => sum_of(values, f64::from, weighted),
            Self::F64(values) => sum_of(values, |x| x, weighted),
        }
    }

    /// The sum of the triples from `first` on, each times its weight: as [`sum`](Self::sum) of these, to the
    /// bit.
    #[inline]
    pub fn sum_from(&self, first: usize, weights: &[f64]) -> Rgb {
        let range = first..first + weights.len();
        match self {
            Self::U8 { steps, step } => run_of(&steps[range], f64::from, weights) * *step,
            Self::Rgb9e5(words) => {
                let triples = words[range].iter().map(|word| unpacked(*word));
                sum_of_triples(triples.zip(weights.iter().copied()))
            }
            Self::F16(values) => run_of(&values[range], widened, weights),
            Self::F32(values) => run_of(&values[range], f64::from, weights),
            Self::F64(values) => run_of(&values[range], |x| x, weights),
        }
    }

    /// Bytes of a triple.
    #[inline]
    pub fn bytes_each(&self) -> u64 {
        bytes_each(match self {
            Self::U8 { .. } => Storage::U8,
            Self::Rgb9e5(_) => Storage::Rgb9e5,
            Self::F16(_) => Storage::F16,
            Self::F32(_) => Storage::F32,
            Self::F64(_) => Storage::Exact,
        })
    }

    /// Triples.
    pub fn count(&self) -> usize {
        match self {
            Self::U8 { steps, .. } => steps.len(),
            Self::Rgb9e5(words) => words.len(),
            Self::F16(values) => values.len(),
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
        }
    }

    /// Bytes of all.
    pub fn bytes(&self) -> u64 {
        self.count() as u64 * self.bytes_each()
    }
}

/// Bits of a mantissa, and the exponent of its last bit if the shared one is 0.
const MANTISSA: i32 = 9;
const LEAST_EXPONENT: i32 = -15 - MANTISSA;

/// The largest number with a shared exponent: 511 · 2⁷.
const LARGEST_PACKED: f64 = 65_408.0;

/// Three numbers in four bytes: mantissas of nine bits, red in the lowest, below a shared exponent of five.
/// The format is that of graphics cards (Khronos, `EXT_texture_shared_exponent`, whose rounding this is).
/// Negative numbers become 0.
fn packed(triple: [f64; 3]) -> u32 {
    // NaN becomes 0, too.
    let held = triple.map(|x| if x > 0.0 { x.min(LARGEST_PACKED) } else { 0.0 });
    let most = held.into_iter().fold(0.0, f64::max);
    // The power of two below it, from the bits of its exponent.
    let floor = ((most.to_bits() >> 52) as i32 - 1023).max(LEAST_EXPONENT + MANTISSA - 1);
    let whole = |x: f64, exponent: i32| (x * power_of_two(-exponent) + 0.5).floor() as u32;
    let mut exponent = floor + 1 - MANTISSA;
    if whole(most, exponent) >= 1 << MANTISSA {
        exponent += 1;
    }
    let shared = (exponent - LEAST_EXPONENT) as u32;
    let [red, green, blue] = held.map(|x| whole(x, exponent));
    red | green << 9 | blue << 18 | shared << 27
}

/// The numbers of [`packed`].
#[inline]
fn unpacked(word: u32) -> [f64; 3] {
    let scale = power_of_two((word >> 27).cast_signed() + LEAST_EXPONENT);
    [0, 9, 18].map(|bit| f64::from(word >> bit & 0x1ff) * scale)
}

/// A power of two of a normal number.
#[inline]
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

#[inline]
fn sum_of_triples(weighted: impl Iterator<Item = ([f64; 3], f64)>) -> Rgb {
    let mut sum = [0.0; 3];
    for (triple, weight) in weighted {
        for c in 0..3 {
            sum[c] += triple[c] * weight;
        }
    }
    Rgb(sum)
}

/// A finite half float as a double, in three instructions: [`f16::to_f64`] asks the processor for its own
/// each time.
#[inline]
fn widened(half: f16) -> f64 {
    /// 2¹¹²: the difference of the two formats' exponents.
    const SCALE: f32 = f32::from_bits(0x7780_0000);
    let bits = u32::from(half.to_bits());
    let magnitude = f32::from_bits((bits & 0x7fff) << 13) * SCALE;
    f64::from(f32::from_bits(magnitude.to_bits() | (bits & 0x8000) << 16))
}

#[inline]
fn sum_of<T: Copy>(
    triples: &[[T; 3]],
    number: impl Fn(T) -> f64,
    weighted: impl Iterator<Item = (usize, f64)>,
) -> Rgb {
    let mut sum = [0.0; 3];
    for (index, weight) in weighted {
        let triple = triples[index];
        for c in 0..3 {
            sum[c] += number(triple[c]) * weight;
        }
    }
    Rgb(sum)
}

/// As [`sum_of`], of triples one after the other: these are widened together, several in one instruction.
#[inline]
fn run_of<T: Copy>(triples: &[[T; 3]], number: impl Fn(T) -> f64, weights: &[f64]) -> Rgb {
    const TOGETHER: usize = 32;
    let mut wide = [0.0; 3 * TOGETHER];
    let mut sum = [0.0; 3];
    for (triples, weights) in triples.chunks(TOGETHER).zip(weights.chunks(TOGETHER)) {
        for (wide, x) in wide.iter_mut().zip(triples.as_flattened()) {
            *wide = number(*x);
        }
        for (triple, weight) in wide.chunks_exact(3).zip(weights) {
            for c in 0..3 {
                sum[c] += triple[c] * weight;
            }
        }
    }
    Rgb(sum)
}

/// Bytes of a triple of numbers.
pub fn bytes_each(storage: Storage) -> u64 {
    match storage {
        Storage::U8 => 3,
        Storage::Rgb9e5 => 4,
        Storage::F16 => 6,
        Storage::F32 => 12,
        Storage::Exact => 24,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;

    #[test]
    fn all_finite_half_floats_are_widened_exactly() {
        for bits in 0..=u16::MAX {
            let half = f16::from_bits(bits);
            if half.is_finite() {
                assert_eq!(widened(half).to_bits(), half.to_f64().to_bits(), "{bits:x}");
            }
        }
    }

    #[test]
    fn numbers_with_a_shared_exponent_are_off_by_half_a_step_of_the_largest() {
        for k in 0..4000_i32 {
            // From 1e-6, below the least step, to more than the largest.
            let most = math::exp(f64::from(k) * 0.0065 - 13.8);
            let triple = [most, 0.37 * most, 0.0];
            let back = unpacked(packed(triple));
            let held = most.min(LARGEST_PACKED);
            // A mantissa of nine bits has at least its highest bit set, unless the exponent is the least:
            // half a step is 2⁻⁹ of the largest, or 2⁻²⁵.
            let half_step = f64::max(held / 512.0, power_of_two(LEAST_EXPONENT - 1));
            for (x, y) in triple.into_iter().zip(back) {
                let x = x.min(LARGEST_PACKED);
                assert!((x - y).abs() <= half_step * (1.0 + 1e-12), "{x} {y}");
            }
        }
    }

    #[test]
    fn shared_exponents_have_the_words_of_the_format() {
        // 1 is 256 · 2⁻⁸: the exponent is 24 − 8. 0.5 is 128 of these, and 65408 is 511 · 2⁷.
        assert_eq!(packed([1.0, 0.5, 0.0]), 256 | 128 << 9 | 16 << 27);
        assert_eq!(packed([65_408.0; 3]), u32::MAX);
        assert_eq!(
            packed([1e30, f64::INFINITY, 0.0]),
            511 | 511 << 9 | 31 << 27
        );
        assert_eq!(packed([0.0, -1.0, f64::NAN]), 0);
        // 511.7 rounds up to 512, which has no nine bits.
        assert_eq!(unpacked(packed([511.7, 1.0, 0.0])), [512.0, 2.0, 0.0]);
    }

    #[test]
    fn triples_that_follow_each_other_have_the_sum_of_single_ones_to_the_bit() {
        let values: Vec<[f64; 3]> = (0..400)
            .map(|k| std::array::from_fn(|c| math::sin(f64::from(k) * 0.37 + c as f64) + 1.0))
            .collect();
        for storage in [
            Storage::U8,
            Storage::Rgb9e5,
            Storage::F16,
            Storage::F32,
            Storage::Exact,
        ] {
            let (stored, _) = Stored::new(values.clone(), storage, 3.0);
            // Around the number that is widened together, and none.
            for count in [0, 1, 25, 31, 32, 33, 64, 225] {
                let weights: Vec<f64> = (0..count).map(|k| f64::from(k) - 11.3).collect();
                let single = stored.sum((7..).zip(weights.iter().copied()));
                let run = stored.sum_from(7, &weights);
                assert_eq!(
                    run.0.map(f64::to_bits),
                    single.0.map(f64::to_bits),
                    "{storage:?} {count}"
                );
            }
        }
    }
}
