//! Light as a camera sees it: paths, and all methods together.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod camera;
mod closed_forms;
mod estimators;
mod full;
mod next_surface;
mod pairwise;
mod parts;

#[path = "../support/mod.rs"]
mod support;
