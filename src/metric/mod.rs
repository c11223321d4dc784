//! Two images, and how far they are apart: differences, significance, equivalence.
//!
//! ```no_run
//! use nephroid::film::exr;
//! use nephroid::metric::{Settings, Source, compare};
//!
//! let a = Source::new("truth.exr", exr::read("truth.exr".as_ref())?);
//! let b = Source::new("mine.exr", exr::read("mine.exr".as_ref())?);
//! let report = compare(&a, &b, &Settings::default())?;
//! println!("{:?}", report.layers[0].difference.relative_rmse);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | file | question |
//! |---|---|
//! | [`source`], [`pair`] | which channels belong together, and which are error bars? |
//! | [`difference`], [`similarity`], [`flip`] | how far apart are the values? |
//! | [`score`], [`significance`] | is that more than the error bars explain? |
//! | [`equivalence`] | is it less than a margin? |
//! | [`maps`] | where? |
//!
//! `docs/compare.md` has every formula and its source. All sums are taken in a fixed order: figures are the
//! same bits on any number of threads.

pub mod bars;
mod comparison;
pub mod difference;
pub mod equivalence;
mod error;
pub mod flip;
pub mod maps;
mod measured;
pub mod pair;
pub mod score;
mod settings;
pub mod significance;
pub mod similarity;
pub mod source;
mod sums;

pub use comparison::{Comparison, Flip, Report, compare};
pub use equivalence::Verdict;
pub use error::CompareError;
pub use maps::Maps;
pub use pair::{Pair, Pairing};
pub use settings::{Settings, Side};
pub use source::{Source, Window};
