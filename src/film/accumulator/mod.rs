//! Exact, order-free sums of deposits, replicate by replicate.

mod file;
mod sums;

pub use sums::{Accumulator, AccumulatorError, ReplicateMean};
