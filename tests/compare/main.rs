//! Differences of images, and tests if noise explains them.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod fidelity;
mod figures;
mod flip;
mod statistics;

#[path = "../support/mod.rs"]
mod support;
