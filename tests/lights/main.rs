//! Where light comes from.

mod direct;
mod emitters;
mod environments;
mod mitsuba;

#[path = "../support/mod.rs"]
mod support;
