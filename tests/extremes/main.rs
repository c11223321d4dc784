//! Very small, very large, far away, grazing, degenerate (docs/accuracy.md). Hostile files: `tests/hostile/`.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod angle;
mod concentration;
mod counts;
mod distance;
mod geometry;
mod index;
mod interrupts;
mod limits;
mod offset;
mod scale;
mod view;

#[path = "../support/mod.rs"]
mod support;
