//! Light space: where light can leave the emitters and meet specular geometry.
//!
//! Every emitter's emission is covered by [charts](chart): two-dimensional, each with a known
//! flux density. A chart is divided into a quadtree of cells, and a cell is dropped when no
//! light of it can reach a specular surface: a conservative test of the cell's
//! [beam](probe) against the boxes of the search tree, so the flux dropped makes no caustic,
//! by construction. Photons and beams start in the cells that are left.

mod cells;
pub mod chart;
mod derivative;
pub mod probe;
pub mod surface;

pub use cells::{LightCell, LightSpace, LightSpaceError};
pub use derivative::DeltaEmission;
