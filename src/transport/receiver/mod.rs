//! Receiver grids: the texel of a surface in which light arrives.
//!
//! Round and flat shapes map [0, 1]² of (u, v) onto all of themselves, and know the area of every texel. The
//! (u, v) of a mesh come from its file: a texel may be covered in part or not at all, and by faces that
//! stretch differently. The areas of its texels are those of the surface in them (`coverage`, by `clip`).
//! `lookup` leads from (u, v) back to the surface.

mod clip;
mod coverage;
mod grid;
mod lookup;
mod problem;

pub use grid::{Receiver, ReceiverPatch};
pub use problem::{ReceiverError, UvProblem};
