//! A run: its limits, its surroundings, its result, and the errors that end it. All methods share these.
//!
//! | file | content |
//! |---|---|
//! | [`account`] | the ledger of flux, for people and for programs |
//! | [`budget`] | the limits: error, time, work |
//! | [`context`] | progress, stop, threads, cache folder, memory limit |
//! | [`progress`] | how far a run is |
//! | [`error`] | [`Error`], and the [`Refusal`] of a scene or a sensor |
//! | [`estimate`] | maps with error bars by layer; [`combine`] adds them, [`channels`] makes files of them |
//! | [`light`] | the set of light paths that a method measures |
//! | [`rendering`] | an estimate with counters, warnings and the method's own report |
//! | [`counters`] | work by name, and by stage |
//! | [`flux`] | a technique's flux, stage by stage |
//! | [`cost`] | bytes and counted work, before anything is traced |

pub mod account;
pub mod budget;
mod channels;
pub mod combine;
pub mod context;
pub mod cost;
pub mod counters;
pub mod error;
pub mod estimate;
mod file;
pub mod flux;
pub mod format;
pub mod light;
pub mod progress;
pub mod rendering;
pub mod texels;

/// A hash of the source from which this program is built: another source may compute other numbers. The same
/// source has the same hash in every program that contains it.
pub const SOURCE_HASH: &str = env!("NEPHROID_SOURCE_HASH");

pub use budget::Budget;
pub use combine::CombineError;
pub use context::Context;
pub use cost::Cost;
pub use counters::{Counter, Counters, StageWork};
pub use error::{Error, Refusal};
pub use estimate::{Estimate, Interval, Layer, LayerName, Quantity, Range};
pub use flux::FluxEntry;
pub use light::Light;
pub use progress::Progress;
pub use rendering::Rendering;
