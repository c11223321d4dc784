//! `LD`, light that comes straight from an emitter to the receiver, by quadrature.
//!
//! A delta emitter's light is integrated over a texel with 2 x 2 Gauss points. On a flat receiver, most
//! texels need no rays for that: a shaft tells that all of a square sees the same (`shafts.rs`). Elsewhere
//! the points look. Shadows have sharp edges, which may run through a texel and yet miss its four points. So
//! a texel that no shaft settles gets a closer look if its points *or its neighbours'* see different shares
//! of the emitter: it is cut along the edge (`edge.rs`). The uncertainty left by the edge's bend is booked as
//! error.
//!
//! Texels on several faces are cut into a quadtree instead, at least `EDGE_LEVELS` deep. A leaf's outer
//! points lie a little outside of it. The tree goes down to `SHADOW_LEVELS` if these and the leaf do not all
//! see the same share. A leaf that is still mixed there is booked as error.
//!
//! Light along the normals of a surface is that of a sun or a point for rays that meet the surface, and ends
//! in an edge where the surface does. On a flat texel the part that this edge leaves is exact (`window.rs`):
//! its places look for shadows. Other texels that it runs through get the closer look.
//!
//! Area lights and environments are integrated over texel and light together by randomised quasi-Monte
//! Carlo. Images that points shine through, and textures along normals, are integrated over the texel. Both
//! take `AREA_SAMPLES` a texel. If more are asked for, texels around the edges of shadows and texels with
//! large scatter are sampled anew, with that number. So are all texels below a sky, unless nothing is above
//! the receiver.
//!
//! Averages are by surface area. A mesh may cover a texel in part, or have faces that stretch or lean
//! differently within it. The parts concerned are cut into smaller ones, too (`EDGE_LEVELS` deep). The rest
//! of the uncertainty is booked as error.
//!
//! In a texel that no shaft settles, a shadow (or a gap in one) narrower than about half a texel can be
//! missed. If the texel has an edge, that holds for a shadow narrower than 1/8 of it.

mod area;
mod arriving;
mod delta;
mod divided;
mod edge;
mod environment;
mod glance;
mod image;
mod leaf;
mod light;
mod look;
mod measure;
mod sampled;
mod shaft;
mod shafts;
mod texel;
mod tube;
mod window;

pub use measure::{AREA_SAMPLES, Direct, direct};
pub use texel::DirectTexel;
