//! Direct irradiance of one texel, with its error.

use crate::radiometry::Rgb;

/// A texel's direct irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectTexel {
    /// Average irradiance [W/m²].
    pub irradiance: Rgb,
    /// For delta emitters a bound, for area lights the standard error [W/m²].
    pub error: Rgb,
}

impl DirectTexel {
    /// Nothing is known of it.
    pub(super) const UNKNOWN: Self = Self {
        irradiance: Rgb::grey(f64::NAN),
        error: Rgb::grey(f64::NAN),
    };
}
