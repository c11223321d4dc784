//! Deterministic truth: adaptive beams of light.
mod cell;
mod deposit;
pub mod facets;
pub mod film;
pub mod refine;
pub mod run;
