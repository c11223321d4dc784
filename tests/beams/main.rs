//! Truth without noise: beams, their bounds, and probes of single points.

mod bars;
mod camera;
mod clearance;
mod contradictions;
mod crossings;
mod discovery;
mod flat_facets;
mod method;
mod occluders;
mod pool;
mod probe;
mod probe_meshes;
mod spots;

#[path = "../support/mod.rs"]
mod support;
