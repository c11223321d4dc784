//! The program and its study files, as a user meets them.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod cameras;
mod caustic_map;
mod compare;
mod frames;
mod full;
mod manual;
mod path;
mod probe;
mod program;
mod same_bits;
mod shards;
mod study;
mod study_file;
mod tables;

#[path = "../support/mod.rs"]
mod support;
