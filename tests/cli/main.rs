//! The program as a user meets it.

mod caustic_map;
mod compare;
mod full;
mod interrupts;
mod path;
mod probe;
mod program;
mod study;
mod study_file;

#[path = "../support/mod.rs"]
mod support;
