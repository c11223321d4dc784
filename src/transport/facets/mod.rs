//! Flat facets: light between them goes by planes, whatever the search tree says.
//!
//! A facet is a convex polygon of one plane: a face of a mesh without interpolated normals, all
//! faces of a cube's side, a rectangle. A chain of facets is one smooth topology of light, and what
//! becomes of light in it takes no search: every leg ends on a plane that is known. [`table`]
//! gathers the facets of a scene, [`path`] follows light along chains of them.

mod outline;
pub mod path;
pub mod table;
