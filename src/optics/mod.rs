//! What an interface does to light.

mod conductor;
mod dielectric;
mod direction;

pub use conductor::conductor_reflectance;
pub use dielectric::{dielectric_reflectance, thin_slab_reflectance};
pub use direction::{reflect, refract};
