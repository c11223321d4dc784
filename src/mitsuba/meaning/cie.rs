//! Conversion of spectra to linear sRGB.
//!
//! The curves are those of the CIE ([`observer`](crate::spectrum::observer)). The integral is the sum that
//! Mitsuba 3.9.1 forms in its `rgb` variants, so that a file means the same light here and there.

use crate::radiometry::Rgb;
use crate::spectrum::observer::{FIRST_NM, LAST_NM, curves, xyz_to_srgb};

/// The integral of ȳ \[nm\]: an equal-energy spectrum of 1 gets Y = 1 (Mitsuba's `CIE_Y_normalization`).
const Y_INTEGRAL: f64 = 106.75026;
/// The divisor of D65's relative power, with which a reflectance of 1 gets Y = 1.
const D65_MEAN: f64 = 98.9974;

/// The weight of a spectrum in the integral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// The spectrum is light itself.
    Emission,
    /// The spectrum is a factor on light, which is taken to be D65.
    UnderD65,
}

/// The colour of a spectrum that is 1 at all wavelengths, seen as light.
///
/// It is not white: linear sRGB's white is D65, and this is illuminant E. Mitsuba's `rgb` variants give
/// `<spectrum value="1"/>` of an emitter this colour, but `<float value="1"/>` and `<rgb value="1"/>` white.
pub const EQUAL_ENERGY: Rgb = xyz_to_srgb([1.0; 3]);

/// Linear sRGB of a spectrum that is linear between the samples (nm, value) and zero outside.
///
/// ```text
/// XYZ = Σᵢ (x̄, ȳ, z̄)(λᵢ) s(λᵢ) w(λᵢ) Δ / ∫ȳ,   1000 wavelengths λᵢ from 360 to 830 nm, Δ = 0.47 nm
/// ```
///
/// with w = 1 for [`Weight::Emission`] and D65 for [`Weight::UnderD65`]. Negative channels (colours that sRGB
/// cannot show) then become 0, as in Mitsuba's `spectrum_list_to_srgb`.
///
/// `samples`: two or more, wavelengths rising.
pub fn to_srgb(samples: &[(f64, f64)], weight: Weight) -> Rgb {
    const COUNT: u32 = 1000;
    let mut xyz = [0.0; 3];
    for index in 0..COUNT {
        let position = f64::from(index) / f64::from(COUNT - 1);
        let wavelength = FIRST_NM + position * (LAST_NM - FIRST_NM);
        let Some(value) = linear(samples, wavelength) else {
            continue;
        };
        let [x, y, z, d65] = curves(wavelength);
        let value = match weight {
            Weight::Emission => value,
            Weight::UnderD65 => value * d65 / D65_MEAN,
        };
        for (sum, curve) in xyz.iter_mut().zip([x, y, z]) {
            *sum += curve * value;
        }
    }
    let scale = (LAST_NM - FIRST_NM) / (f64::from(COUNT) * Y_INTEGRAL);
    xyz_to_srgb(xyz.map(|sum| sum * scale)).map(|channel| channel.max(0.0))
}

/// The value between the two nearest samples; none outside the first and the last.
fn linear(samples: &[(f64, f64)], wavelength: f64) -> Option<f64> {
    let above = samples.partition_point(|sample| sample.0 <= wavelength);
    let (w0, v0) = *samples.get(above.checked_sub(1)?)?;
    match samples.get(above) {
        Some((w1, v1)) => Some(v0 + (v1 - v0) * (wavelength - w0) / (w1 - w0)),
        None => (wavelength == w0).then_some(v0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance: Mitsuba 3.9.1 prints six digits of its single-precision numbers, so half a digit in the
    /// sixth place of the largest is 5e-6 of it. Sums in f32 of 1000 terms add less than 1000 * 2^-24 = 6e-5
    /// of the result in the worst case (1e-5 seen).
    fn assert_is(found: Rgb, mitsuba: [f64; 3]) {
        for (a, b) in found.0.into_iter().zip(mitsuba) {
            assert!(
                (a - b).abs() <= 6e-5 * found.max_channel(),
                "{found:?} is not {mitsuba:?}"
            );
        }
    }

    #[test]
    fn an_equal_energy_spectrum_is_reddish() {
        assert_is(EQUAL_ENERGY, [1.204795, 0.948290, 0.908915]);
        assert_is(
            to_srgb(&[(360.0, 1.0), (830.0, 1.0)], Weight::Emission),
            [1.20488, 0.948229, 0.909267],
        );
    }

    #[test]
    fn a_white_surface_under_d65_is_white() {
        assert_is(
            to_srgb(&[(360.0, 1.0), (830.0, 1.0)], Weight::UnderD65),
            [0.998983, 0.998872, 0.998802],
        );
    }

    #[test]
    fn the_cornell_boxs_light_is_mitsubas() {
        let light = [(400.0, 0.0), (500.0, 8.0), (600.0, 15.6), (700.0, 18.4)];
        assert_is(
            to_srgb(&light, Weight::Emission),
            [20.7108, 10.8546, 2.77115],
        );
    }

    #[test]
    fn slopes_are_mitsubas_and_channels_outside_srgb_become_zero() {
        assert_is(
            to_srgb(&[(400.0, 1.0), (700.0, 2.0)], Weight::UnderD65),
            [1.79949, 1.47621, 1.13095],
        );
        assert_is(
            to_srgb(
                &[(500.0, 0.0), (550.0, 1.0), (600.0, 0.0)],
                Weight::Emission,
            ),
            [0.0440363, 0.582571, 0.0],
        );
    }

    #[test]
    fn outside_its_samples_a_spectrum_is_zero() {
        assert_eq!(
            to_srgb(&[(100.0, 1.0), (200.0, 1.0)], Weight::Emission),
            Rgb::BLACK
        );
        assert_eq!(linear(&[(1.0, 5.0), (2.0, 7.0)], 2.0), Some(7.0));
        assert_eq!(linear(&[(1.0, 5.0), (2.0, 7.0)], 2.1), None);
    }
}
