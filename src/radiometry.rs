//! RGB quantities.
//!
//! A spectral quantity is three numbers in linear sRGB primaries, as in Mitsuba's `rgb` variants. The unit
//! (W, W/m², W/sr, W/m²/sr or none) belongs to the field that holds it.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub};

/// A linear RGB triple; its unit is that of the field that holds it.
///
/// # Example: the mean of the channels
///
/// ```
/// let light = nephroid::Rgb::new(1.0, 2.0, 6.0);
/// assert_eq!(light.mean(), 3.0);
/// assert_eq!((light * 2.0).0, [2.0, 4.0, 12.0]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
// Three numbers in memory, nothing else: maps are handed to Python as they are.
#[repr(transparent)]
pub struct Rgb(pub [f64; 3]);

impl Rgb {
    /// No light.
    pub const BLACK: Self = Self([0.0; 3]);
    /// One in every channel.
    #[doc(hidden)]
    pub const WHITE: Self = Self([1.0; 3]);

    /// The same value in every channel.
    #[inline]
    pub const fn grey(value: f64) -> Self {
        Self([value; 3])
    }

    /// Red, green and blue.
    #[inline]
    pub const fn new(red: f64, green: f64, blue: f64) -> Self {
        Self([red, green, blue])
    }

    /// True if the three channels hold the same value, so that one channel can stand for all.
    #[inline]
    pub(crate) fn is_grey(self) -> bool {
        self.0[0] == self.0[1] && self.0[1] == self.0[2]
    }

    /// True if every channel is exactly zero.
    #[inline]
    #[doc(hidden)]
    pub fn is_black(self) -> bool {
        self.0 == [0.0; 3]
    }

    /// True if every channel is neither infinite nor NaN.
    #[inline]
    #[doc(hidden)]
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|channel| channel.is_finite())
    }

    /// The largest channel.
    #[inline]
    pub fn max_channel(self) -> f64 {
        self.0[0].max(self.0[1]).max(self.0[2])
    }

    /// The smallest channel.
    #[inline]
    #[doc(hidden)]
    pub fn min_channel(self) -> f64 {
        self.0[0].min(self.0[1]).min(self.0[2])
    }

    /// The mean of the three channels: a plain average, no luminance weights.
    #[inline]
    pub fn mean(self) -> f64 {
        (self.0[0] + self.0[1] + self.0[2]) / 3.0
    }

    /// The triple of `f` applied to every channel.
    #[inline]
    #[must_use]
    #[doc(hidden)]
    pub fn map(self, f: impl FnMut(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }
}

impl Add for Rgb {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|c| self.0[c] + other.0[c]))
    }
}

impl Sub for Rgb {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|c| self.0[c] - other.0[c]))
    }
}

impl Mul for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|c| self.0[c] * other.0[c]))
    }
}

impl Mul<f64> for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|channel| channel * factor))
    }
}

impl Div<f64> for Rgb {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f64) -> Self {
        Self(self.0.map(|channel| channel / divisor))
    }
}

impl Neg for Rgb {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(self.0.map(|channel| -channel))
    }
}

impl AddAssign for Rgb {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl MulAssign<f64> for Rgb {
    #[inline]
    fn mul_assign(&mut self, factor: f64) {
        *self = *self * factor;
    }
}

impl Sum for Rgb {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::BLACK, Add::add)
    }
}
