//! Closed forms as a method: the scenes they recognise and solve, held against beams, and the scenes they
//! refuse.

mod accuracy;
mod edited;
mod refusals;
mod shipped;

#[path = "../support/mod.rs"]
mod support;
