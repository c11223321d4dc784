//! Adaptive beams of light: deterministic irradiance with lower and upper bounds.
//!
//! For delta emitters the light on a sensor is a two-dimensional integral of a piecewise smooth map. It goes
//! from light space to the receiver, or by way of visible surfaces to a camera's film
//! ([`Target`](super::Target)). It is not sampled but divided. [`refine`] cuts light space on the [first
//! surfaces](crate::transport::first_surface) into triangles until the map of each is nearly affine, or its
//! borders are nearly straight ([`cut`]). [`deposit`] deals each triangle out to the texels that its image
//! covers, at two finenesses, and extrapolates. [`bars`] derives bounds from the difference of the
//! finenesses.
//!
//! Light by way of flat facets only has its own way of division ([`facets`]): there the borders are known.
//!
//! One [`pass`] does so for one path signature and one tolerance. [`mod@run`] finds the signatures
//! ([`discovery`]), and `spend` repeats passes with smaller tolerances until the error asked for is reached.
//! Nothing but sums on the film ([`sums`]) is kept of a pass: memory does not grow with the number of cells.
//! Light that is divided without end goes to photons (`by_photons`).

pub mod bars;
mod batch;
mod by_photons;
pub mod cell;
mod coarse;
pub mod cut;
pub mod deposit;
pub mod discovery;
pub mod facets;
pub mod film;
mod finish;
mod forecast;
pub mod inputs;
mod layers;
pub mod light;
pub mod limit;
pub mod pass;
pub mod piece;
pub mod refine;
pub mod report;
pub mod run;
pub mod schedule;
pub mod selection;
pub mod settings;
mod sharing;
pub(super) mod source;
pub(super) mod spend;
pub mod store;
pub mod sums;
pub mod support;
pub(super) mod tasks;
pub mod traced;

pub use by_photons::MOST_RAYS;
pub use forecast::Forecast;
pub use pass::SignatureReport;
pub use refine::scratch_bytes;
pub use report::BeamReport;
pub use run::{forecast, run};
pub use settings::{BeamSettings, Chaotic, DEFAULT_ERROR};
pub use support::supports;
