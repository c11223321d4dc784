//! The content of a `study.toml`: see `docs/validate.md` for all its keys.
//!
//! Every value knows its place. An error names file, line and column, and the values that are allowed.

mod error;
mod study_file;
mod study_method;
mod sweep;
mod table;
mod wishes;

pub use error::FileError;
pub use study_file::{StudyCandidate, StudyFile};
pub use study_method::StudyMethod;
pub use sweep::frames;
pub use wishes::{StudyWishes, report_folder};
