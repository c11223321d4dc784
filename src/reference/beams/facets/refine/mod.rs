//! Polygons of light, leg by leg.

mod cut;
mod divide;
mod land;
mod refiner;
mod sharing;
mod spread;
mod view;

pub use refiner::FacetRefiner;
pub use sharing::by_events;
