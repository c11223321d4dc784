//! The cost of less error: methods swept over their settings, judged by a truth, and reported.
//!
//! A study names a scene, sensors, a truth, and methods with the settings to sweep ([`StudyFile`]). For a
//! scene alone there is a sensible default. Each run fills one sensor and is kept in a [`Store`], so that a
//! stopped study goes on from there. Films are then read back and judged by [`metric`](crate::metric). A row
//! counts only if the truth is good enough to resolve its error.
//!
//! | file | question |
//! |---|---|
//! | [`mod@file`], [`plan`] | which runs? |
//! | [`facts`], [`layers`] | what is known of a film, and what is in it? |
//! | [`session`], [`stages`], [`store`] | is it there already? |
//! | [`machine`] | on which machine was it made? |
//! | [`truth`] | can the truth tell? |
//! | [`limit`] | how large may an error be? |
//! | [`curve`] | what does less error cost? |
//! | [`attribution`] | which stage of an approximation makes its error? |
//! | [`checks`] | could it be a mistake rather than an error? |
//! | [`report`] | how is all that shown? |
//! | [`validation`] | all of that, one after the other |

pub mod attribution;
pub mod checks;
pub mod curve;
mod error;
pub mod facts;
pub mod file;
pub mod layers;
pub mod limit;
pub mod machine;
pub mod plan;
pub mod report;
pub mod session;
pub mod stages;
pub mod store;
pub mod truth;
pub mod validation;

pub use error::StudyError;
pub use file::StudyFile;
pub use plan::{SensorPlan, StudyPlan, StudyRun};
pub use report::{StudyReport, Timings};
pub use session::{Obtained, Session};
pub use stages::Attributed;
pub use store::Store;
