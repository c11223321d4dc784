//! Sums, files and pictures of images.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod accumulator;
mod exr;
mod picture;
