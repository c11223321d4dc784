//! Mitsuba's scene files, and images held against Mitsuba's.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod emitters_and_sensors;
mod integrators;
mod mutations;
mod parity;
mod parity_third_party;
mod shapes_and_materials;
mod shipped;
mod syntax;
mod third_party;

#[path = "../support/mod.rs"]
mod support;
