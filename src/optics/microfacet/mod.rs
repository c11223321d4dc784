//! Microfacets: rough interfaces as many small smooth ones, the distribution of their normals, and their
//! visibility.
//!
//! Directions are unit vectors in the frame of the surface, whose normal is +z. The model is that of Walter
//! et al., *Microfacet Models for Refraction through Rough Surfaces* (EGSR 2007); facets shadow each other
//! independently of their normals (Smith).

mod beckmann;
mod facets;
mod ggx;
mod rough_transmittance;

pub use facets::{FacetDistribution, Microfacets};
pub use rough_transmittance::RoughTransmittance;
