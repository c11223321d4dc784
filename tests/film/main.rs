//! Sums, files and pictures of images.

mod accumulator;
mod exr;
mod picture;
