//! Receiver grids: which texel of a surface light arrives in.
//!
//! Round and flat shapes map [0, 1]² of (u, v) onto all of themselves, and know the area of
//! every texel. A mesh's (u, v) are whatever its file says: a texel may be covered in part or not at
//! all, and by faces that stretch differently. Its texels' areas are those of the surface in them
//! (`coverage`, by `clip`), and `lookup` leads from (u, v) back to the surface.

mod clip;
mod coverage;
mod grid;
mod lookup;
mod problem;

pub use grid::{Receiver, ReceiverPatch};
pub use problem::{ReceiverError, UvProblem};
