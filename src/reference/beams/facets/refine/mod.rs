//! Polygons of light, leg by leg.

mod cut;
mod divide;
mod followed;
mod refiner;
mod sharing;
mod stop;
mod stopper;
mod view;

pub use followed::{Followed, by_events};
pub use refiner::FacetRefiner;
