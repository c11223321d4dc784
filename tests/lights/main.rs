//! Origins of light: emitters, environments, direct light.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod daylight;
mod direct;
mod emitters;
mod environments;
mod mitsuba_oracle;

#[path = "../support/mod.rs"]
mod support;
