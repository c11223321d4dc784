//! Polygons of light, leg by leg.

mod cut;
mod divide;
mod refiner;
mod stop;
mod stopper;
mod view;

pub use refiner::FacetRefiner;
