//! Deterministic truth: adaptive beams of light.
mod cell;
mod cut;
mod deposit;
pub mod film;
pub mod refine;
pub mod run;
mod store;
