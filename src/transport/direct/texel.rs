//! Direct irradiance of one texel, with its error.

use crate::radiometry::Rgb;

/// A texel's direct irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectTexel {
    /// Average irradiance [W/m²].
    pub irradiance: Rgb,
    /// Error [W/m²]: a bound for delta emitters, the standard error for area lights.
    pub error: Rgb,
}

impl DirectTexel {
    /// A texel of which nothing is known.
    pub(super) const UNKNOWN: Self = Self {
        irradiance: Rgb::grey(f64::NAN),
        error: Rgb::grey(f64::NAN),
    };
}
