//! Light as a camera sees it: paths, and all methods together.

mod camera;
mod closed_forms;
mod estimators;
mod full;
mod pairwise;

#[path = "../support/mod.rs"]
mod support;
