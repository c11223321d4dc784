//! Differences of images, and tests if noise explains them.

mod fidelity;
mod figures;
mod flip;
mod statistics;

#[path = "../support/mod.rs"]
mod support;
