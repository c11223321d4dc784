//! Surfaces: their reflection and refraction of rays.

mod differentials;
mod laws;
mod microfacets;
mod mitsuba_oracle;
mod optics;
mod sampling;
mod textures;

#[path = "../support/mod.rs"]
mod support;
