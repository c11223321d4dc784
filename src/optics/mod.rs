//! Optics of interfaces: reflectances, directions, and derivatives of rays.

mod conductor;
mod dielectric;
mod differential;
mod direction;
mod microfacet;

pub use conductor::conductor_reflectance;
pub use dielectric::{dielectric_reflectance, thin_slab_reflectance};
pub use differential::RayDerivative;
pub use direction::{reflect, refract};
pub use microfacet::{FacetDistribution, Microfacets, RoughTransmittance};
