//! Little time, little memory, an end at any moment (docs/accuracy.md, 9).

#![cfg(unix)]

#[cfg(target_os = "linux")]
mod memory;
mod program;
mod replacement;
mod stops;
