//! Grids of texels, the sums kept for them, and their files.
//!
//! The only room that knows the crates `exr` and `image`.

pub mod accumulator;
pub mod atomic;
pub mod bitmap;
pub mod coverage;
pub mod exr;
mod exr_blocks;
mod filter;
mod grid;
mod image;
mod lazy;
pub mod picture;
mod pixel_filter;
pub mod splat;

pub use accumulator::{Accumulator, AccumulatorError, ReplicateMean};
pub use filter::ReconstructionFilter;
pub use grid::Grid;
pub use image::{Channel, Image, ImageError, Rounding};
pub use lazy::LazyImage;
pub use pixel_filter::PixelFilter;
