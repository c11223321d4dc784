//! Truth without noise: beams, their bounds, and probes of single points.

mod bars;
mod camera;
mod crossings;
mod flat_facets;
mod guard;
mod lamps;
mod method;
mod occluders;
mod probe;
mod probe_meshes;
mod spots;
mod survey;

#[path = "../support/mod.rs"]
mod support;
