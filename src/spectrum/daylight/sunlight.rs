//! The sun's light by its elevation.
//!
//! L. Hošek and A. Wilkie, "Adding a Solar-Radiance Function to the Hošek-Wilkie Skylight Model", IEEE
//! Computer Graphics and Applications 33(3), 2013. The table has the integral of their radiance over the
//! sun's disc, darker towards its limb, as Mitsuba 3.9.1 computes it.

use super::Y_INTEGRAL;
use super::tables::sun_spectrum;
use crate::radiometry::Rgb;
use crate::spectrum::observer::{FIRST_NM, curves, xyz_to_srgb};

/// The diameter of the sun that the table is of \[rad\].
pub const SUN_DIAMETER: f64 = 0.5358 * std::f64::consts::PI / 180.0;

/// The factor from means over the table's wavelengths to integrals over all of them \[nm\], by which Mitsuba
/// 3.9.1 makes the sun's colour agree with its sky's.
const WAVELENGTH_RANGE: f64 = 467.069_280_386;

/// Irradiance [W/m²/nm] of a surface across the sun's light. Channels may be negative: a red sun is outside
/// of sRGB.
///
/// `turbidity` in 1..=10; `elevation` \[rad\] below 2° is taken for 2°, and the sun below the horizon is
/// black.
///
/// ```text
/// XYZ = R / ∫ȳ · mean over λ of (x̄, ȳ, z̄)(λ) E(λ),   λ = 320, 360, … 720 nm,   R = 467.07 nm
/// ```
pub fn sun_irradiance(turbidity: f64, elevation: f64) -> Rgb {
    if elevation < 0.0 {
        return Rgb::BLACK;
    }
    let spectrum = sun_spectrum(turbidity, elevation.to_degrees());
    let mut xyz = [0.0; 3];
    for (index, value) in spectrum.into_iter().enumerate() {
        let wavelength = 320.0 + 40.0 * index as f64;
        if wavelength < FIRST_NM {
            continue;
        }
        let [x, y, z, _] = curves(wavelength);
        for (sum, curve) in xyz.iter_mut().zip([x, y, z]) {
            *sum += curve * value;
        }
    }
    let factor = WAVELENGTH_RANGE / (Y_INTEGRAL * spectrum.len() as f64);
    xyz_to_srgb(xyz) * factor
}
