//! Conversion of spectra to linear sRGB.
//!
//! The tables hold the CIE 1931 colour matching functions (2° observer) and the relative power of illuminant
//! D65, every 5 nm from 360 to 830 nm. They are tables T.4 and T.1 of CIE 15:2004. The integral is the sum
//! that Mitsuba 3.9.1 forms in its `rgb` variants, so that a file means the same light here and there.

use crate::radiometry::Rgb;

const FIRST_WAVELENGTH: f64 = 360.0;
const LAST_WAVELENGTH: f64 = 830.0;
const STEP: f64 = 5.0;

/// x̄, ȳ, z̄ and the relative power of D65.
#[rustfmt::skip]
const CIE: [[f64; 4]; 95] = [
    [0.0001299, 0.000003917, 0.0006061, 46.6383],
    [0.0002321, 0.000006965, 0.001086, 49.3637],
    [0.0004149, 0.00001239, 0.001946, 52.0891],
    [0.0007416, 0.00002202, 0.003486, 51.0323],
    [0.001368, 0.000039, 0.006450001, 49.9755],
    [0.002236, 0.000064, 0.01054999, 52.3118],
    [0.004243, 0.00012, 0.02005001, 54.6482],
    [0.00765, 0.000217, 0.03621, 68.7015],
    [0.01431, 0.000396, 0.06785001, 82.7549],
    [0.02319, 0.00064, 0.1102, 87.1204],
    [0.04351, 0.00121, 0.2074, 91.486],
    [0.07763, 0.00218, 0.3713, 92.4589],
    [0.13438, 0.004, 0.6456, 93.4318],
    [0.21477, 0.0073, 1.0390501, 90.057],
    [0.2839, 0.0116, 1.3856, 86.6823],
    [0.3285, 0.01684, 1.62296, 95.7736],
    [0.34828, 0.023, 1.74706, 104.865],
    [0.34806, 0.0298, 1.7826, 110.936],
    [0.3362, 0.038, 1.77211, 117.008],
    [0.3187, 0.048, 1.7441, 117.41],
    [0.2908, 0.06, 1.6692, 117.812],
    [0.2511, 0.0739, 1.5281, 116.336],
    [0.19536, 0.09098, 1.28764, 114.861],
    [0.1421, 0.1126, 1.0419, 115.392],
    [0.09564, 0.13902, 0.8129501, 115.923],
    [0.05795001, 0.1693, 0.6162, 112.367],
    [0.03201, 0.20802, 0.46518, 108.811],
    [0.0147, 0.2586, 0.3533, 109.082],
    [0.0049, 0.323, 0.272, 109.354],
    [0.0024, 0.4073, 0.2123, 108.578],
    [0.0093, 0.503, 0.1582, 107.802],
    [0.0291, 0.6082, 0.1117, 106.296],
    [0.06327, 0.71, 0.07824999, 104.79],
    [0.1096, 0.7932, 0.05725001, 106.239],
    [0.1655, 0.862, 0.04216, 107.689],
    [0.2257499, 0.9148501, 0.02984, 106.047],
    [0.2904, 0.954, 0.0203, 104.405],
    [0.3597, 0.9803, 0.0134, 104.225],
    [0.4334499, 0.9949501, 0.008749999, 104.046],
    [0.5120501, 1.0, 0.005749999, 102.023],
    [0.5945, 0.995, 0.0039, 100.0],
    [0.6784, 0.9786, 0.002749999, 98.1671],
    [0.7621, 0.952, 0.0021, 96.3342],
    [0.8425, 0.9154, 0.0018, 96.0611],
    [0.9163, 0.87, 0.001650001, 95.788],
    [0.9786, 0.8163, 0.0014, 92.2368],
    [1.0263, 0.757, 0.0011, 88.6856],
    [1.0567, 0.6949, 0.001, 89.3459],
    [1.0622, 0.631, 0.0008, 90.0062],
    [1.0456, 0.5668, 0.0006, 89.8026],
    [1.0026, 0.503, 0.00034, 89.5991],
    [0.9384, 0.4412, 0.00024, 88.6489],
    [0.8544499, 0.381, 0.00019, 87.6987],
    [0.7514, 0.321, 0.0001, 85.4936],
    [0.6424, 0.265, 0.00005, 83.2886],
    [0.5419, 0.217, 0.00003, 83.4939],
    [0.4479, 0.175, 0.00002, 83.6992],
    [0.3608, 0.1382, 0.00001, 81.863],
    [0.2835, 0.107, 0.0, 80.0268],
    [0.2187, 0.0816, 0.0, 80.1207],
    [0.1649, 0.061, 0.0, 80.2146],
    [0.1212, 0.04458, 0.0, 81.2462],
    [0.0874, 0.032, 0.0, 82.2778],
    [0.0636, 0.0232, 0.0, 80.281],
    [0.04677, 0.017, 0.0, 78.2842],
    [0.0329, 0.01192, 0.0, 74.0027],
    [0.0227, 0.00821, 0.0, 69.7213],
    [0.01584, 0.005723, 0.0, 70.6652],
    [0.01135916, 0.004102, 0.0, 71.6091],
    [0.008110916, 0.002929, 0.0, 72.979],
    [0.005790346, 0.002091, 0.0, 74.349],
    [0.004109457, 0.001484, 0.0, 67.9765],
    [0.002899327, 0.001047, 0.0, 61.604],
    [0.00204919, 0.00074, 0.0, 65.7448],
    [0.001439971, 0.00052, 0.0, 69.8856],
    [0.0009999493, 0.0003611, 0.0, 72.4863],
    [0.0006900786, 0.0002492, 0.0, 75.087],
    [0.0004760213, 0.0001719, 0.0, 69.3398],
    [0.0003323011, 0.00012, 0.0, 63.5927],
    [0.0002348261, 0.0000848, 0.0, 55.0054],
    [0.0001661505, 0.00006, 0.0, 46.4182],
    [0.000117413, 0.0000424, 0.0, 56.6118],
    [0.0000830753, 0.00003, 0.0, 66.8054],
    [0.0000587065, 0.0000212, 0.0, 65.0941],
    [0.0000415099, 0.00001499, 0.0, 63.3828],
    [0.0000293533, 0.0000106, 0.0, 63.8434],
    [0.0000206738, 0.0000074657, 0.0, 64.304],
    [0.0000145598, 0.0000052578, 0.0, 61.8779],
    [0.000010254, 0.0000037029, 0.0, 59.4519],
    [0.0000072215, 0.0000026078, 0.0, 55.7054],
    [0.0000050859, 0.0000018366, 0.0, 51.959],
    [0.0000035817, 0.0000012934, 0.0, 54.6998],
    [0.0000025225, 0.0000009109, 0.0, 57.4406],
    [0.0000017765, 0.0000006415, 0.0, 58.8765],
    [0.0000012511, 0.0000004518, 0.0, 60.3125],
];

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

/// Linear sRGB of XYZ (ITU-R BT.709 primaries, D65 white), as Mitsuba rounds the matrix.
const fn xyz_to_srgb([x, y, z]: [f64; 3]) -> Rgb {
    Rgb([
        3.240479 * x - 1.537150 * y - 0.498535 * z,
        -0.969256 * x + 1.875991 * y + 0.041556 * z,
        0.055648 * x - 0.204043 * y + 1.057311 * z,
    ])
}

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
        let wavelength = FIRST_WAVELENGTH + position * (LAST_WAVELENGTH - FIRST_WAVELENGTH);
        let Some(value) = linear(samples, wavelength) else {
            continue;
        };
        let [x, y, z, d65] = cie(wavelength);
        let value = match weight {
            Weight::Emission => value,
            Weight::UnderD65 => value * d65 / D65_MEAN,
        };
        for (sum, curve) in xyz.iter_mut().zip([x, y, z]) {
            *sum += curve * value;
        }
    }
    let scale = (LAST_WAVELENGTH - FIRST_WAVELENGTH) / (f64::from(COUNT) * Y_INTEGRAL);
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

fn cie(wavelength: f64) -> [f64; 4] {
    let place = (wavelength - FIRST_WAVELENGTH) / STEP;
    let below = (place as usize).min(CIE.len() - 2);
    let part = place - below as f64;
    std::array::from_fn(|k| CIE[below][k] + (CIE[below + 1][k] - CIE[below][k]) * part)
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
