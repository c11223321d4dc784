//! Light space as seen on the first specular surface that light of a delta emitter meets.
//!
//! A ray of a [`Source`] is named by the place where it meets the surface, in two coordinates of a
//! [`SurfaceChart`] over that surface. At a silhouette the direction of the ray is a bad coordinate, because
//! the light's further path changes like a square root there. The place on the surface is a good one. On a
//! mesh the borders of its faces, where normals have a kink, are lines of the coordinates.

mod chart;
mod cone;
mod fan;
mod patches;
mod place;
mod shared;
mod source;
mod triangle;

pub use chart::SurfaceChart;
pub use cone::{Cone, ConeOverlap};
pub use fan::Fan;
pub use patches::{SurfacePatch, patches};
pub use place::ChartPlace;
pub use shared::SharedPlaces;
pub use source::{Source, SourceRay};
pub use triangle::{middles, quarters};
