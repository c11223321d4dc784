//! Ground truth for caustics: how much light do reflection and refraction put on a surface, and how far off
//! may the answer be?
//!
//! Use this crate to judge a caustic technique of your own, to measure a scene, or to test a renderer. A
//! [`Scene`] is read from a Mitsuba 3 scene file. A [`Method`] fills one of its sensors and returns a
//! [`Rendering`]: irradiance [W/m²], or radiance towards a camera [W/m²/sr], texel by texel and layer by
//! layer, with error bars.
//!
//! # Example: the light below a glass ball
//!
//! ```
//! use nephroid::{Budget, Context, Method};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "32")])?;
//! let sensor = &scene.sensors()[0];
//! let method = Method::choose(&scene, sensor)?.method;
//! let rendering = method.run(&scene, sensor, &Budget::error(0.05), &Context::default())?;
//! for layer in &rendering.estimate.layers {
//!     println!("{}: {:.3} W/m² on average", layer.name, layer.range().mean);
//! }
//! # assert!(rendering.estimate.layers.len() > 2);
//! # Ok(())
//! # }
//! ```
//!
//! # Tasks
//!
//! | I want to | use |
//! |---|---|
//! | read a scene file | [`load`], then [`Scene::sensors`] |
//! | make a rainbow | [`Scene::with_dispersion`] |
//! | let the scene choose a method | [`Method::choose`] |
//! | name a method and its settings | [`Method::new`], [`Method::with`]; [`Method::names`] lists all |
//! | know the cost beforehand | [`Method::supports`], [`Method::cost`] |
//! | measure | [`Method::run`] |
//! | make frames of an animation | [`Method::frames`] |
//! | ask a pilot for better settings | [`Method::advice`] |
//! | stop at an error, a time or an amount of work | [`Budget`] |
//! | show progress, stop early, limit threads or memory | [`Context`], [`Progress`] |
//! | read values | [`Estimate::total`] and [`Estimate::layers`], each a [`Layer`] |
//! | read error bars | [`Layer::standard_error`], [`Layer::interval`], [`Layer::relative_error`] |
//! | know the end of all flux | [`Estimate::ledger`], a [`Ledger`] |
//! | write and read files | [`Rendering::write_exr`], [`read_exr`] |
//! | compare two images | [`compare`] with [`CompareImage`] and [`CompareSettings`], for a [`Comparison`] |
//!
//! Beams, photons, paths and photon maps compute the truth. Techniques compute what a real-time renderer
//! would show; each of their stages can be made exact ([`Method::with_exact`]).
//!
//! # Conventions
//!
//! - Lengths are scene units; fluxes W; irradiance W/m² (one scene unit is one metre); radiant intensity
//!   W/sr; radiance W/m²/sr. All of them are linear RGB triples.
//! - Angles are radians; degrees only where a Mitsuba file has them.
//! - World space is right-handed, as in Mitsuba. Directions are unit vectors. A ray's direction is the
//!   direction of travel; `wi` and `wo` point away from the surface.
//! - `ior` is an absolute refractive index; `eta` is `n_transmitted / n_incident`.
//! - All results are computed in `f64`. Images are stored as `f32`.
//!
//! # Features
//!
//! `cli` (default) is what the program `nephroid` needs beside the library. A library alone builds with
//! `--no-default-features`.
#![warn(clippy::pedantic)]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::cast_lossless,
    clippy::many_single_char_names,
    clippy::similar_names,
    clippy::module_name_repetitions,
    clippy::must_use_candidate,
    clippy::float_cmp,
    clippy::suboptimal_flops,
    clippy::unreadable_literal
)]

// The map of the house, floor by floor, is in ARCHITECTURE.md; `tests/floors.rs` enforces it.
mod approximation;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
mod film;
mod generate;
mod geometry;
mod method;
mod metric;
mod mitsuba;
mod numeric;
mod optics;
mod radiometry;
mod reference;
mod run;
mod scene;
mod setting;
mod spectrum;
mod study;
mod transport;

#[doc(hidden)]
pub mod internals;

/// The README, whose Rust is compiled and run with the other examples.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

use std::path::Path;

pub use film::exr::{ExrReadError, ExrWriteError, read as read_exr};
pub use film::{Channel, Image};
pub use geometry::TraversalCounters;
pub use method::{Choice, Method, Sequence, StageSetting};
pub use metric::difference::{Difference, Percentile, WorstTexel};
pub use metric::equivalence::{Equivalence, MeanEquivalence, TexelEquivalence};
pub use metric::fidelity::{Bounded, Displacement, Fidelity, Resolution, ScaleError};
pub use metric::significance::{JointTest, Significance};
pub use metric::similarity::Similarity;
pub use metric::{
    CompareError, CompareImage, CompareSettings, Comparison, Flip, ImageSide, LayerComparison,
    Verdict, compare,
};
pub use mitsuba::LoadError;
pub use radiometry::Rgb;
pub use run::{
    Budget, Context, Cost, Counter, Counters, Error, Estimate, FluxEntry, Interval, Layer,
    LayerName, Light, Progress, Quantity, Range, Refusal, Rendering, StageWork,
};
pub use scene::{DispersionError, Scene, Sensor, SourcePosition, Warning};
pub use setting::SettingError;
pub use transport::ledger::{FluxByFate, Ledger};
pub use transport::path_class::PathClass;
pub use transport::signature::{Event, Signature, SignatureError};

/// Reads a Mitsuba 3 scene file and all files that it names.
///
/// `parameters` are the values of `$name` in the file, by name; they win over `<default>`.
///
/// # Errors
///
/// If a file is missing or malformed, asks for a feature that is not modelled, or contradicts itself: with
/// file, line, column, plugin and what is allowed.
///
/// # Example: a smaller film than the file's
///
/// ```
/// let scene = nephroid::load("scenes/water.xml".as_ref(), &[("size", "64")])?;
/// assert_eq!(scene.sensors()[0].size(), [64, 64]);
/// # Ok::<(), nephroid::LoadError>(())
/// ```
pub fn load(path: &Path, parameters: &[(&str, &str)]) -> Result<Scene, LoadError> {
    let owned = parameters
        .iter()
        .map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
    mitsuba::load(path, &owned.collect::<Vec<_>>())
}
