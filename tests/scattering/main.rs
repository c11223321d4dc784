//! Surfaces: their reflection and refraction of rays.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod differentials;
mod laws;
mod microfacets;
mod mitsuba_oracle;
mod optics;
mod sampling;
mod textures;

#[path = "../support/mod.rs"]
mod support;
