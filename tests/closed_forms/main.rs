//! Closed forms as a method: the scenes they recognise and solve, held against beams, and the scenes they
//! refuse.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod accuracy;
mod edited;
mod refusals;
mod shipped;

#[path = "../support/mod.rs"]
mod support;
