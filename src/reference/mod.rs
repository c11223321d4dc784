//! Methods that compute the truth: a map of values with error bars, layer by layer.
//!
//! [`beams`] is deterministic, for light without size. [`photons`] works on any scene, and [`photon_map`]
//! where photons cannot be connected to the camera. [`mod@path`] makes a camera's image of all light, and
//! [`full`] does so by all of these. [`closed_form`] needs no tracing, on the few scenes that have a formula,
//! and judges the others. [`mod@probe`] finds every path to one point. Runs of photons, photon maps and paths
//! can be made in [`parts`].

pub mod beams;
pub mod closed_form;
pub mod full;
pub mod parts;
pub mod path;
pub mod photon_map;
pub mod photons;
pub mod probe;
pub mod rounds;
pub mod shard;
mod target;

pub use target::Target;
