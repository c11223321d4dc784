//! Images inside the page: `f32` numbers of fewer digits, deflated, as text.
//!
//! A number keeps some bits of its mantissa, rounded to nearest. The bytes of all numbers are laid out in
//! four planes, the most significant first, so that repetitions are side by side. The planes are deflated
//! (zlib) and written in base 64.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;

/// Number of bits of the mantissa that an image keeps, of 23.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// 16 bits, 8e-6 of the value: the truth.
    Five,
    /// 12 bits, 1.2e-4 of the value: the films that are judged.
    Four,
    /// 6 bits, 0.8 % of the value: error bars and z.
    Two,
}

/// An image, encoded.
#[derive(Clone, Debug, Serialize)]
pub struct EncodedPlane {
    /// The file it is from, as the report names it.
    pub file: String,
    /// `value`, `bar`, `z`, `flip`, `red`, `green` or `blue`.
    pub kind: &'static str,
    /// The planes of bytes.
    pub data: String,
}

impl Digits {
    const fn dropped(self) -> u32 {
        match self {
            Self::Five => 7,
            Self::Four => 11,
            Self::Two => 17,
        }
    }

    /// The nearest number of so many bits; NaN and infinities stay.
    pub fn round(self, value: f32) -> f32 {
        if !value.is_finite() {
            return value;
        }
        let dropped = self.dropped();
        let bits = value.to_bits();
        // To nearest, ties away from zero: a carry goes into the exponent, as it must.
        let rounded = bits.wrapping_add(1 << (dropped - 1)) >> dropped << dropped;
        let rounded = f32::from_bits(rounded);
        if rounded.is_finite() { rounded } else { value }
    }
}

impl EncodedPlane {
    /// An image with so many digits.
    pub fn new(file: &str, kind: &'static str, values: &[f32], digits: Digits) -> Self {
        let rounded: Vec<[u8; 4]> = values
            .iter()
            .map(|value| digits.round(*value).to_be_bytes())
            .collect();
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        for byte in 0..4 {
            let plane: Vec<u8> = rounded.iter().map(|bytes| bytes[byte]).collect();
            // Writing to memory does not fail.
            let _ = encoder.write_all(&plane);
        }
        Self {
            file: file.to_owned(),
            kind,
            data: STANDARD.encode(encoder.finish().unwrap_or_default()),
        }
    }
}

/// Means over squares of `step` x `step` texels, those at the border smaller; NaN texels are left out.
pub fn reduced(values: &[f32], [width, height]: [usize; 2], step: usize) -> Vec<f32> {
    if step == 1 {
        return values.to_vec();
    }
    let mut means = Vec::with_capacity(width.div_ceil(step) * height.div_ceil(step));
    for top in (0..height).step_by(step) {
        for left in (0..width).step_by(step) {
            let (mut sum, mut count) = (0.0, 0.0);
            for y in top..(top + step).min(height) {
                for x in left..(left + step).min(width) {
                    let value = f64::from(values[y * width + x]);
                    if !value.is_nan() {
                        sum += value;
                        count += 1.0;
                    }
                }
            }
            means.push((sum / count) as f32);
        }
    }
    means
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use super::*;

    #[test]
    fn rounding_keeps_the_digits_it_says_and_all_special_values() {
        for (digits, bound) in [
            (Digits::Five, 8e-6),
            (Digits::Four, 1.3e-4),
            (Digits::Two, 8e-3),
        ] {
            for value in [1.0_f32, -std::f32::consts::PI, 1100.85, 1e-30, f32::MAX] {
                let off = (digits.round(value) / value - 1.0).abs();
                assert!(off <= bound, "{digits:?} {value}: {off}");
            }
            assert!(digits.round(f32::NAN).is_nan());
            assert_eq!(digits.round(f32::INFINITY), f32::INFINITY);
            assert_eq!(digits.round(0.0), 0.0);
        }
    }

    #[test]
    fn what_is_encoded_can_be_decoded_as_the_page_does() {
        let values = [0.0_f32, 1.5, -2.25, 1e-3, f32::NAN];
        let plane = EncodedPlane::new("a.exr", "value", &values, Digits::Five);
        let bytes = STANDARD.decode(plane.data).unwrap();
        let mut planes = Vec::new();
        flate2::read::ZlibDecoder::new(bytes.as_slice())
            .read_to_end(&mut planes)
            .unwrap();
        let n = values.len();
        for (i, value) in values.iter().enumerate() {
            let found = f32::from_be_bytes(std::array::from_fn(|byte| planes[byte * n + i]));
            let expected = Digits::Five.round(*value);
            assert_eq!(found.to_bits(), expected.to_bits());
        }
    }

    #[test]
    fn squares_at_the_border_are_means_of_fewer_texels() {
        let values: Vec<f32> = (0..6).map(|i| i as f32).collect();
        // 0 1 2
        // 3 4 5
        assert_eq!(reduced(&values, [3, 2], 2), [2.0, 3.5]);
        assert_eq!(reduced(&values, [3, 2], 1), values);
        assert!(reduced(&[f32::NAN; 4], [2, 2], 2)[0].is_nan());
        assert_eq!(reduced(&[f32::NAN, 1.0, 1.0, 4.0], [2, 2], 2), [2.0]);
    }
}
