//! The published techniques, stage by stage, and what their authors claim.

mod caustic_map;
mod paper_claims;
mod stubs;

#[path = "../support/mod.rs"]
mod support;
