//! Numbers: exact sums, compensated arithmetic, sample streams, quadrature, statistics. Knows nothing of
//! light.

pub mod choice;
pub(crate) mod compensated;
pub mod distributions;
pub mod exact_sum;
pub mod fixed_point;
pub(crate) mod fused;
pub mod math;
mod morton;
pub mod quadrature;
pub mod rotation;
mod sobol;
mod spherical_harmonics;
pub mod statistics;
pub mod streams;
pub(crate) mod wide;

pub use choice::{Selection, WeightedChoice};
pub use exact_sum::ExactSum;
pub use fixed_point::{FixedPoint, FixedPointError};
pub use morton::{fine_morton_code, morton_code, spread_bits};
pub use spherical_harmonics::{SphericalHarmonics, harmonic_fit, spherical_harmonics};
pub use statistics::SampleMoments;
pub use streams::{Extras, PaddedStream, Stream, StreamKind};
