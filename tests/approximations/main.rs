//! The published techniques, stage by stage, and what their authors claim.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod approximate_ball;
mod caustic_map;
mod caustics_advice;
mod caustics_ellipses;
mod caustics_landing;
mod caustics_slabs;
mod caustics_volume;
mod energy;
mod image_space;
mod light_volume;
mod light_volume_culling;
mod local_irradiance;
mod local_irradiance_files;
mod local_irradiance_scenes;
mod lookups;
mod paper_claims;
mod slab_claims;
mod stubs;
mod volume_claims;

#[path = "../support/mod.rs"]
mod support;
