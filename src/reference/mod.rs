//! Ways to compute the truth.

pub mod closed_form;
pub mod photons;
