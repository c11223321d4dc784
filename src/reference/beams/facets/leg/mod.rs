//! The space that a polygon's next leg sweeps, and the obstacles in it.
//!
//! Rays through a polygon show what they meet; obstacles beside them may be smaller than the polygon. So
//! everything that may be in the hulls of its leg is searched for. Most flat faces there are neighbours of
//! those that the leg starts and ends on: their edges decide whether they are in the way (`across.rs`).

mod across;
mod end;
mod legs;

pub(super) use end::{LegEnd, rectangular_receiver};
pub(super) use legs::{LegWay, Legs, Watch};
