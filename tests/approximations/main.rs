//! The published techniques, stage by stage, and what finds the true paths beside them.

mod caustic_map;
mod paper_claims;
mod probe;
mod probe_meshes;

#[path = "../support/mod.rs"]
mod support;
