//! How far images differ, and whether noise explains it.

mod figures;
mod flip;
mod statistics;

#[path = "../support/mod.rs"]
mod support;
