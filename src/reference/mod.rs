//! Ways to compute the truth.
//!
//! A reference fills a sensor with an [`Estimate`]: values with error bars, layer by layer, and
//! a ledger of where all the flux went. [`photons`] works on any scene, and [`photon_map`] where
//! photons cannot be connected to the camera; [`mod@path`] makes a camera's image of all light, and
//! [`full`] of all light by all of these; [`closed_form`] holds
//! the few scenes that need no computer, and judges the others; [`mod@probe`] finds every path to one
//! point.

pub mod beams;
mod channels;
pub mod closed_form;
mod combine;
mod estimate;
pub mod full;
pub mod path;
pub mod photon_map;
pub mod photons;
pub mod probe;
mod progress;
mod target;

pub use combine::CombineError;
pub use estimate::{Estimate, Interval, Layer, LayerName, Quantity};
pub use progress::Progress;
pub use target::{Target, TargetError};
