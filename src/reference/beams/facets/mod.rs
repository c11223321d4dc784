//! Light by way of flat facets: polygons of it are cut where they meet the facets' edges.
//!
//! On flat faces every (entry facet, next facet, ...) chain is a topology of its own. Cells that are divided
//! without knowledge of the facets would need too many divisions at the topologies' borders. But these
//! borders are known: light changes its topology where it passes an edge of a facet. So a polygon of light
//! that meets a facet first is followed leg by leg (`refine/`). A ray through its middle finds a facet, and
//! the facet's edges cut out the part of the polygon that goes there. The rest is followed likewise. Each cut
//! parts a polygon in two, so that nothing is lost or counted twice. A polygon that has made all its events
//! lands (`refine/land.rs`) as a fan of triangles.
//!
//! One ray does not show what is beside it. So a polygon goes on only if nothing else may be in the space
//! that its leg sweeps (`leg/`). A facet that may be there is cut out, too. Beside a surface that is not
//! flat, polygons are halved down to the tolerance. Then cells find the border, or all light of the rest is
//! uncertain.
//!
//! Parallel light goes along a chain of flat facets by an affine map: then all of this is exact. Light from a
//! point does not: the lines along which polygons are cut are bent a little, and so are the images. If the
//! tolerance does not allow that, polygons are halved.

mod charts;
mod leg;
mod polygon;
mod refine;

pub use charts::{facet_of, part_patches};
pub use refine::{FacetRefiner, by_events};
