//! `LD`: light that comes straight from an emitter to the receiver, by quadrature.
//!
//! A delta emitter's light is integrated over a texel with 2 x 2 Gauss points. Shadows have sharp
//! edges, which may run through a texel and yet miss its four points; so a texel is looked at closely
//! where its points *or its neighbours'* differ in what they see of the emitter: it is cut along the edge
//! (`edge.rs`). What its bend leaves uncertain is booked as error. Texels on several faces are
//! cut into a quadtree instead, at least `EDGE_LEVELS` deep and down to `SHADOW_LEVELS` where any of a leaf's
//! guards, which stand a little outside of it, sees otherwise than the rest; what is
//! still mixed there is booked as error. Area lights are integrated over texel and emitter
//! together by randomised quasi-Monte Carlo, with `AREA_SAMPLES` a texel; where more are asked for, texels about shadows' edges,
//! and those whose scatter is large, are sampled anew with so many.
//!
//! Averages are by surface area. Where a mesh covers a texel in part, or faces that stretch or lean
//! differently meet in it, the parts where they do are cut into smaller ones, too (`EDGE_LEVELS`
//! deep), and what remains uncertain is booked as error.
//!
//! A shadow (or a gap in one) narrower than about half a texel can be missed, and in a texel with an
//! edge one narrower than 1/8 of it.

mod area;
mod arriving;
mod delta;
mod edge;
mod glance;
mod leaf;
mod light;
mod look;
mod measure;
mod texel;

pub use area::REPLICATES as AREA_REPLICATES;
pub use measure::{AREA_SAMPLES, Direct, direct};
pub use texel::DirectTexel;
