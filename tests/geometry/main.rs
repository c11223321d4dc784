//! Rays, meshes and the search among them.

mod diagnostics;
mod mitsuba_oracle;
mod search;
mod shared_meshes;
mod spawn;
mod watertight;

#[path = "../support/mod.rs"]
mod support;
