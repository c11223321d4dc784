//! Cells all of whose light goes the way that their six nodes went.
//!
//! A cell of light space is followed at its corners and at the middles of its edges. Between them there may
//! be something that none of the six paths met. It may be a thin thing in the way, or the edge of the surface
//! that they fell on. So each leg of the path sweeps a [`Hull`](crate::geometry::Hull). A leg is **clear** if
//!
//! - no other surface may overlap the hull,
//! - the surface that the leg starts on does not meet it again before its end, and
//! - the surface at its end catches all of it, up to the border that the nodes did not see.
//!
//! If all legs are clear, all light of the cell meets the same surfaces in the same order. The tests are
//! conservative. A leg that is called clear is clear, as far as the six nodes show how the cell's paths bend
//! (see [`bulge`](crate::geometry::bulge)).
//!
//! A clear leg is clear for every part of the cell: the part's hull lies in the cell's, up to the bend that
//! both estimate. A [`CellClearance`] is therefore inherited, and a line of cells pays for each leg once.
//!
//! Two things are not seen here. The first is a change of the light within a surface (the onset of total
//! reflection, where topologies differ). The second is a pair of meshes that cut through each other inside
//! the hull.

mod caught;
mod cell;
mod legs;
mod obstacles;
mod polygons;
mod same_surface;
mod trail;
mod tube;

pub use cell::{CellClearance, Clearance};
pub use trail::{Straight, Trail};
