//! Little time, little memory, an end at any moment (docs/accuracy.md, 9).

#![cfg(unix)]

mod faults;
mod kills;
#[cfg(target_os = "linux")]
mod memory;
mod program;
mod replacement;
mod stops;
