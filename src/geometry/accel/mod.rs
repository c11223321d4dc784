//! The search for candidates: primitives that a ray may hit. The only room that knows obvhs.
//!
//! - [`build`]: binary trees over boxes, improved by obvhs, and collapsed into nodes of eight children.
//! - [`clustering`]: a binary tree from the leaves up.
//! - [`balanced`]: a plain tree for boxes that clustering would take too long over.
//! - [`curve`]: the order in which both take boxes.
//! - [`tree`]: the nodes, in `f32`.
//! - [`walk`]: the search of one ray through them, step by step.
//! - [`stream`]: searches of many rays by turns.
//! - [`packet`]: searches of rays that go about the same way, together.
//! - [`tree_frame`]: a tree's own coordinates.
//! - [`ray`]: a ray in a tree's own frame, and the derivation of its error bound.
//! - [`pack`]: eight triangles in a leaf, and the filter that spares most of the exact tests.
//! - [`lanes`]: the operations on eight numbers at a time that the search needs of a processor.
//! - [`plane_pairs`]: pairs of planes in a tree's own frame, and the search for boxes between them.
//! - [`simd`]: these operations, in wide registers if the processor has them.
//!
//! Nothing here decides a hit. Boxes and filter may let too much through, never too little; the exact `f64`
//! tests behind them see the same primitives on every processor.

mod balanced;
mod build;
mod clustering;
mod curve;
mod lanes;
mod pack;
mod packet;
mod plane_pairs;
mod ray;
mod simd;
mod stream;
mod tree;
mod tree_frame;
mod walk;

pub(super) use lanes::Lanes;
pub(super) use pack::TrianglePack;
pub(super) use ray::LocalRay;
pub(super) use stream::Searches;
pub(super) use tree::{BoxTree, LeafVisitor, Root};
