//! Files made to break the program: each is refused or read, in little time and memory, and without a panic.
//!
//! An honest file's need is measured, not guessed: the heap that a well-formed file of the same format takes
//! at most, for each of its bytes. A hostile file may take four times that. Some honest images pack much room
//! into few bytes: a black one takes as much for a byte as its packing allows.
//!
//! These tests are a program of their own because they count the heap, which all tests of a program share.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod changed;
mod claims;
mod growth;
mod honest;
mod names;
mod replay;
mod seeds;
mod slow_meshes;
mod watch;

#[path = "../support/entries.rs"]
mod entries;
#[path = "../support/mod.rs"]
mod support;
