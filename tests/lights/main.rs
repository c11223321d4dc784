//! Where light comes from.

mod direct;
mod emitters;
mod environments;
mod mitsuba_oracle;

#[path = "../support/mod.rs"]
mod support;
