//! Light space as seen on the first specular surface that light of a delta emitter meets.
//!
//! A ray of a [`Source`] is named by the place where it meets the surface, in two coordinates of
//! a [`Chart`] over that surface. At a silhouette the direction of the ray is a bad coordinate: what
//! becomes of the light changes like a square root there. The place on the surface is a good one;
//! and on a mesh the borders of its faces, where normals have a kink, are lines of the coordinates.

mod chart;
mod cone;
mod fan;
mod patches;
mod shared;
mod source;

pub use chart::{Chart, Place};
pub use cone::{Cone, ConeOverlap};
pub use fan::Fan;
pub use patches::{SurfacePatch, middles, patches, quarters};
pub use shared::SharedPlaces;
pub use source::{Arrival, Source};
