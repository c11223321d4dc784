//! Truth without noise: beams, their bounds, and probes of single points.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod bars;
mod by_photons;
mod camera;
mod clearance;
mod close_cameras;
mod contradictions;
mod crossings;
mod discovery;
mod flat_facets;
mod focus;
mod method;
mod occluders;
mod parts;
mod pool;
mod probe;
mod probe_meshes;
mod spots;

#[path = "../support/mod.rs"]
mod support;
