//! Readers of mesh files, which become vertices and triangles.
//!
//! All numbers of a file are kept as `f64`: decimal text loses nothing, whereas Mitsuba rounds to single
//! precision. The counts in a header are never trusted beyond what the file can hold.

mod cube;
mod error;
mod format;
mod obj;
mod ply;
mod ply_attributes;
mod ply_header;
mod serialized;

pub use cube::cube;
pub use format::{Format, parse};
