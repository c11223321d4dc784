//! Origins of light: emitters, environments, direct light.

mod direct;
mod emitters;
mod environments;
mod mitsuba_oracle;

#[path = "../support/mod.rs"]
mod support;
