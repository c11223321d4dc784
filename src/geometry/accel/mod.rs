//! Finding candidates: which boxes may a ray hit. The only room that knows obvhs.

mod tree;

pub(super) use tree::BoxTree;
