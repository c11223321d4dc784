//! The search, compiled for wider registers where the processor has them.
//!
//! The code is the same, and it does the same IEEE operations in the same order (no fused ones),
//! so it visits the same nodes; only the number of lanes an instruction handles differs.
//! This is the one file of the crate with `unsafe` in it.

use super::{
    ray::LocalRay,
    tree::{BoxTree, LeafVisitor},
};

/// [`BoxTree::search_local`] with the best instructions that this processor has.
#[inline]
pub(super) fn search(
    tree: &BoxTree,
    ray: &LocalRay,
    limit: f64,
    visitor: &mut impl LeafVisitor,
) -> u64 {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the function's only requirement is the feature that was just detected.
        #[allow(unsafe_code)]
        return unsafe { search_avx2(tree, ray, limit, visitor) };
    }
    tree.search_local(ray, limit, visitor)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn search_avx2(tree: &BoxTree, ray: &LocalRay, limit: f64, visitor: &mut impl LeafVisitor) -> u64 {
    tree.search_local(ray, limit, visitor)
}
