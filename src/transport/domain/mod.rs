//! Light space: the light that can leave the emitters and meet specular geometry.
//!
//! [Charts](chart) cover every emitter's emission. They are two-dimensional, each with a known flux density.
//! A chart is divided into a quadtree of cells. A cell is dropped if no light of it can reach a specular
//! surface. The test is conservative, of the cell's [beam](probe) against the boxes of the search tree. So
//! the flux dropped makes no caustic, by construction. Photons and beams start in the cells that are left.

mod cells;
pub mod chart;
mod derivative;
mod face;
pub mod normal_light;
pub mod patch;
mod pattern;
pub mod polygon;
pub mod probe;
pub mod sky;
pub mod surface;
pub mod textured;

pub use cells::{LightCell, LightSpace, LightSpaceError};
pub use derivative::DeltaEmission;
