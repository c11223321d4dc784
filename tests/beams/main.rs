//! Truth by beams: what it finds, and bounds that hold.

mod bars;
mod camera;
mod crossings;
mod flat_facets;
mod guard;
mod lamps;
mod method;
mod occluders;
mod spots;
mod survey;

#[path = "../support/mod.rs"]
mod support;
