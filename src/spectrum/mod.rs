//! Wavelengths: what colour light of one has, and what index glass has there.
//!
//! | file | content |
//! |---|---|
//! | [`observer`] | the CIE's curves, and linear sRGB of XYZ |
//! | [`wavelengths`] | wavelengths as samples of RGB light: their density and their weights |
//! | [`index`] | an index of refraction as a function of the wavelength: Sellmeier, Cauchy |
//! | [`glass`] | the index that a user names |
//! | [`glasses`] | published glasses by name |
//! | [`daylight`] | the light of a clear sky, and of the sun in it |

pub mod daylight;
pub mod glass;
pub mod glasses;
pub mod index;
pub mod observer;
pub mod wavelengths;

pub use glass::{AIR_IOR, Glass, GlassError};
pub use index::IndexFormula;
pub use wavelengths::{VISIBLE_NM, Wavelength, Wavelengths};
