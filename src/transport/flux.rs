//! Flux in as many channels as the scene needs.

use std::ops::{Add, AddAssign, Mul, Sub};

use crate::radiometry::Rgb;

/// Flux \[W\], or a factor on it, in `N` channels. If nothing in the scene is coloured, there is one channel
/// (it stands for all three); else there are red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flux<const N: usize>(pub [f64; N]);

impl<const N: usize> Flux<N> {
    /// No light.
    pub const BLACK: Self = Self([0.0; N]);
    /// The factor that changes nothing.
    pub const WHITE: Self = Self([1.0; N]);

    /// The first `N` channels of `rgb`.
    #[inline]
    pub fn of(rgb: Rgb) -> Self {
        const { assert!(N == 1 || N == 3, "light has one channel or three") };
        Self(std::array::from_fn(|c| rgb.0[c]))
    }

    /// All three channels.
    #[inline]
    pub fn rgb(self) -> Rgb {
        Rgb(std::array::from_fn(|c| self.0[c.min(N - 1)]))
    }

    /// True if every channel is exactly zero.
    #[inline]
    pub fn is_black(self) -> bool {
        self.0 == [0.0; N]
    }

    /// The magnitudes of the channels.
    #[inline]
    #[must_use]
    pub fn magnitude(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    /// The larger of two values, channel by channel.
    #[inline]
    #[must_use]
    pub fn larger(self, other: Self) -> Self {
        Self(std::array::from_fn(|channel| {
            self.0[channel].max(other.0[channel])
        }))
    }

    /// The largest magnitude of a channel.
    #[inline]
    pub fn max_magnitude(self) -> f64 {
        self.0
            .iter()
            .fold(0.0, |largest: f64, channel| largest.max(channel.abs()))
    }
}

impl<const N: usize> Default for Flux<N> {
    /// No flux.
    fn default() -> Self {
        Self::BLACK
    }
}

impl<const N: usize> Add for Flux<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|c| self.0[c] + other.0[c]))
    }
}

impl<const N: usize> AddAssign for Flux<N> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> Sub for Flux<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|c| self.0[c] - other.0[c]))
    }
}

impl<const N: usize> Mul for Flux<N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|c| self.0[c] * other.0[c]))
    }
}

impl<const N: usize> Mul<f64> for Flux<N> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|channel| channel * factor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_channel_stands_for_three() {
        assert_eq!(Flux::<1>::of(Rgb::grey(2.5)).rgb(), Rgb::grey(2.5));
        let colour = Rgb::new(1.0, -2.0, 3.0);
        assert_eq!(Flux::<3>::of(colour).rgb(), colour);
    }

    #[test]
    fn magnitude_is_of_the_largest_channel_of_either_sign() {
        assert_eq!(Flux([1.0, -4.0, 3.0]).max_magnitude(), 4.0);
        assert!(Flux::<3>::BLACK.is_black() && !Flux([0.0, 0.0, 1.0]).is_black());
    }
}
