//! The program and its study files, as a user meets them.

mod cameras;
mod caustic_map;
mod compare;
mod frames;
mod full;
mod path;
mod probe;
mod program;
mod study;
mod study_file;
mod tables;

#[path = "../support/mod.rs"]
mod support;
