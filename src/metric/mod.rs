//! Comparison of two images: differences, significance, equivalence.
//!
//! ```no_run
//! use nephroid::{CompareImage, CompareSettings, compare, read_exr};
//!
//! let a = CompareImage::new("truth.exr", read_exr("truth.exr".as_ref())?);
//! let b = CompareImage::new("mine.exr", read_exr("mine.exr".as_ref())?);
//! let comparison = compare(&a, &b, &CompareSettings::default())?;
//! println!("{:?}", comparison.layers[0].difference.relative_rmse);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | file | question |
//! |---|---|
//! | [`compare_image`], [`pair`] | which channels belong together, and which are error bars? |
//! | [`difference`], [`similarity`], [`flip`] | how far apart are the values? |
//! | [`fidelity`], [`texel_grid`] | how much light, how far from its place, right at which scale? |
//! | [`figure`] | figures by name |
//! | [`score`], [`significance`] | is that more than the error bars explain? |
//! | [`equivalence`] | is it less than a margin? |
//! | [`maps`] | where? |
//!
//! `docs/compare.md` has every formula and its source. All sums are taken in a fixed order, so that figures
//! are the same bits on any number of threads.

pub mod bars;
pub mod compare_image;
mod comparison;
pub mod difference;
pub mod equivalence;
mod error;
pub mod fidelity;
pub mod figure;
pub mod flip;
mod layer_bars;
pub mod maps;
pub mod pair;
pub mod score;
mod settings;
pub mod significance;
pub mod similarity;
mod sums;
pub mod texel_grid;

pub use compare_image::{CompareImage, Window};
pub use comparison::{Comparison, Flip, LayerComparison, compare};
pub use equivalence::Verdict;
pub use error::CompareError;
pub use fidelity::{Bounded, Displacement, Fidelity, Resolution, ScaleError};
pub use figure::Figure;
pub use maps::Maps;
pub use pair::{LayerPair, Pairing};
pub use settings::{CompareSettings, ImageSide};
