//! The published techniques, stage by stage, and what their authors claim.

mod caustic_map;
mod paper_claims;

#[path = "../support/mod.rs"]
mod support;
