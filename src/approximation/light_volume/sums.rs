//! Stage `accumulate`: sums over beams in the format of a buffer.

use glam::DVec3;
use half::f16;

use super::variants::{Accumulate, Cosine};

/// The format of a buffer that sums light, in irradiances of flat water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Format {
    /// 8 bits, with 255 for this irradiance.
    U8(f64),
    /// Half floats.
    F16,
    /// Floats.
    F32,
    /// As computed.
    Exact,
}

impl Format {
    /// The format of a setting; `white` is what 8 bits hold.
    pub fn of(accumulate: Accumulate, cosine: Cosine, white: f64) -> Self {
        match (accumulate, cosine) {
            (Accumulate::Auto, Cosine::Vector) | (Accumulate::F16, _) => Self::F16,
            (Accumulate::Auto, Cosine::Flat | Cosine::Exact) | (Accumulate::U8, _) => {
                Self::U8(white)
            }
            (Accumulate::F32, _) => Self::F32,
            (Accumulate::Exact, _) => Self::Exact,
        }
    }

    /// The largest sum.
    pub fn largest(self) -> f64 {
        match self {
            Self::U8(white) => white,
            Self::F16 => f16::MAX.to_f64(),
            Self::F32 | Self::Exact => f64::from(f32::MAX),
        }
    }

    /// Bytes of a channel.
    pub fn bytes(self) -> u64 {
        match self {
            Self::U8(_) => 1,
            Self::F16 => 2,
            Self::F32 => 4,
            Self::Exact => 8,
        }
    }

    /// What the buffer holds after `value` was blended over `sum`, both within the format's range.
    #[inline]
    pub fn blended(self, sum: f64, value: f64) -> f64 {
        let largest = self.largest();
        let all = (sum + value).clamp(-largest, largest);
        match self {
            Self::U8(white) => (all / white * 255.0).round() / 255.0 * white,
            Self::F16 => f16::from_f64(all).to_f64(),
            Self::F32 => f64::from(all as f32),
            Self::Exact => all,
        }
    }
}

/// The light at a point: of all its beams, in irradiances of flat water.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum {
    /// The sum of intensities; of stage `cosine`, exact, of irradiances.
    pub scalar: f64,
    /// The sum of scaled light vectors.
    pub vector: DVec3,
}

impl Sum {
    /// Blends an intensity. True if the sum reaches the format's largest.
    #[inline]
    pub fn add(&mut self, format: Format, value: f64) -> bool {
        self.scalar = format.blended(self.scalar, value);
        self.scalar >= format.largest()
    }

    /// Blends a scaled light vector. True if a channel reaches the format's largest.
    #[inline]
    pub fn add_vector(&mut self, format: Format, value: DVec3) -> bool {
        let largest = format.largest();
        self.vector = DVec3::new(
            format.blended(self.vector.x, value.x),
            format.blended(self.vector.y, value.y),
            format.blended(self.vector.z, value.z),
        );
        self.vector.abs().max_element() >= largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_bits_lose_what_is_below_half_a_step_and_stop_at_white() {
        let format = Format::U8(4.0);
        let mut sum = Sum::default();
        for _ in 0..1000 {
            assert!(!sum.add(format, 4.0 / 511.0));
        }
        assert_eq!(sum.scalar, 0.0);
        assert!(!sum.add(format, 4.0 / 509.0));
        assert_eq!(sum.scalar, 4.0 / 255.0);
        assert!(sum.add(format, 1e9));
        assert_eq!(sum.scalar, 4.0);
    }

    #[test]
    fn half_floats_keep_eleven_bits_and_floats_twenty_four() {
        let mut sum = Sum::default();
        sum.add(Format::F16, 2048.0);
        sum.add(Format::F16, 1.0);
        assert_eq!(sum.scalar, 2048.0);
        let mut sum = Sum::default();
        sum.add(Format::F32, 16_777_216.0);
        sum.add(Format::F32, 1.0);
        assert_eq!(sum.scalar, 16_777_216.0);
        assert!(Sum::default().add_vector(Format::F16, DVec3::new(0.0, -1e6, 0.0)));
    }
}
