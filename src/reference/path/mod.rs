//! Unidirectional path tracing: all light that a camera sees, but for what meets it by chance only.
//!
//! Paths start at the camera and are scattered from surface to surface (Kajiya 1986). At each surface with a
//! scattering density an emitter is sampled, too (next-event estimation), and the two ways to find the same
//! light are combined by multiple importance sampling (Veach 1997, chapter 9). It measures the integral that
//! Mitsuba's `path` does, with the same defaults: the power heuristic, Russian roulette from the fifth leg on
//! with radiance's η² divided out, emitters chosen with the same probability each.
//!
//! What differs: shadow rays see through null surfaces and masks, which are no legs of a path; samples are
//! Owen-scrambled Sobol' points in groups of four dimensions; and there is an error bar, from independent
//! randomisations of the whole image (`sums.rs`).
//!
//! A camera's paths find light that went from a *point* through glass onto a matt floor never, and from a
//! small lamp rarely: see [`path_class`](crate::transport::path_class). Layers are those classes, and
//! [`PathSettings::classes`] leaves out what another method is to measure.

pub(super) mod bands;
pub mod run;
mod settings;
pub(super) mod sums;
mod tiles;
mod tracer;

pub use run::{PathReport, run};
pub use settings::{DEFAULT_SAMPLES, LightSampling, PathSettings};
pub use tiles::KEPT_PIXELS;
