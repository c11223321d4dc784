//! What a `study.toml` says: see `docs/validate.md` for all its keys.
//!
//! Every value knows its place: what is wrong is told with file, line and column, and what is allowed.

mod error;
mod study_file;
mod study_method;
mod sweep;
mod table;

pub use error::FileError;
pub use study_file::{StudyCandidate, StudyFile};
pub use study_method::StudyMethod;
