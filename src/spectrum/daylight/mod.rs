//! The light of a clear sky and of the sun in it, in linear sRGB.
//!
//! | file | content |
//! |---|---|
//! | [`clear_sky`] | radiance of the sky by direction (Hošek and Wilkie 2012) |
//! | [`sunlight`] | irradiance of the sun by its elevation (Hošek and Wilkie 2013) |
//! | [`solar_position`] | where the sun is at a place and a time (Blanco-Muriel et al. 2001) |
//! | [`tables`] | the coefficients of both models, and interpolation among them |
//!
//! Directions are in the frame of an observer on the ground whose z axis points up. Elevations are angles
//! above the horizon \[rad\]. *Turbidity* is how hazy the air is: 1 for pure air, 3 for a clear day, 10 for
//! haze.
//!
//! Radiance is in W/m²/sr/nm: a mean over the visible wavelengths, by the CIE's ȳ, as in Mitsuba 3.9.1
//! (`sunsky`). An equal-energy spectrum of 1 W/m²/sr/nm has the luminance 1. Scenes take these numbers as
//! they are, where others have W/m²/sr.

pub mod clear_sky;
pub mod solar_position;
pub mod sunlight;
pub mod tables;

pub use clear_sky::ClearSky;
pub use solar_position::{Clock, Place, elevation, sun_direction};
pub use sunlight::sun_irradiance;

/// The integral of the CIE's ȳ \[nm\] (Mitsuba's `CIE_Y_normalization`).
const Y_INTEGRAL: f64 = 106.750_259_399_414_06;
