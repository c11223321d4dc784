//! Rays, meshes and the search among them.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod diagnostics;
mod meshes_together;
mod mitsuba_oracle;
mod search;
mod shared_meshes;
mod spawn;
mod watertight;

#[path = "../support/mod.rs"]
mod support;
