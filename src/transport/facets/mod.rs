//! Flat facets and the light between them, which goes from plane to plane without a search.
//!
//! A facet is a convex polygon of one plane: a face of a mesh without interpolated normals, all faces of a
//! cube's side, a rectangle. Light of one chain of facets has one smooth topology. To follow it takes no
//! search, as every leg ends on a known plane. [`table`] gathers the facets of a scene, [`path`] follows
//! light along chains of them.

mod outline;
pub mod path;
pub mod table;
