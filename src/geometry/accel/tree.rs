//! Trees of boxes with eight children a node, in one frame.

use std::ops::Range;

use glam::DVec3;

use super::{
    lanes::{Lanes, WIDTH},
    ray::LocalRay,
    tree_frame::TreeFrame,
};
use crate::geometry::{Bounds, Ray};

/// Eight boxes and their contents. A missing child has an empty box.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct TreeNode {
    /// Least x, greatest x, least y, greatest y, least z, greatest z of each child.
    pub planes: [[f32; WIDTH]; 6],
    pub children: [Child; WIDTH],
}

/// The ranges, along an axis, of the numbers of rays whose directions have the same signs.
#[derive(Clone, Copy)]
pub(super) struct AxisRange {
    /// 1 if the directions are negative, else 0.
    pub sign: u32,
    /// Of the ray that comes to near planes first.
    pub near_origin: f32,
    /// Of the ray that comes to far planes last.
    pub far_origin: f32,
    /// Of least magnitude: by it the rays enter first.
    pub entering_reciprocal: f32,
    /// Of greatest magnitude: by it the rays leave last.
    pub leaving_reciprocal: f32,
}

impl AxisRange {
    /// Of no ray.
    pub(super) const NONE: Self = Self {
        sign: 0,
        near_origin: 0.0,
        far_origin: 0.0,
        entering_reciprocal: 0.0,
        leaving_reciprocal: 0.0,
    };

    /// Those of one ray, along each axis: its own numbers.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn of(ray: &LocalRay) -> [Self; 3] {
        std::array::from_fn(|axis| Self {
            sign: ray.signs[axis],
            near_origin: ray.near_origin[axis],
            far_origin: ray.far_origin[axis],
            entering_reciprocal: ray.reciprocal[axis],
            leaving_reciprocal: ray.reciprocal[axis],
        })
    }
}

/// A node's or a leaf's index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(pub(super) u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    /// A missing child; its box is empty, so no search gets here.
    pub(super) const NONE: Self = Self(0);

    pub(super) fn node(index: usize) -> Self {
        Self(index as u32)
    }

    pub(super) fn leaf(index: usize) -> Self {
        Self(index as u32 | Self::LEAF)
    }

    #[inline]
    pub(super) fn as_leaf(self) -> Option<usize> {
        (self.0 & Self::LEAF != 0).then_some((self.0 & !Self::LEAF) as usize)
    }
}

/// A tree over boxes that never loses a candidate.
///
/// The boxes may come in parts. Each has a tree of its own, and there is one over all, with the same leaves.
/// They share a frame, so that a ray enters it but once.
pub(in crate::geometry) struct BoxTree {
    pub(super) frame: TreeFrame,
    /// The tree over all boxes.
    pub(super) whole: Root,
    pub(super) parts: Vec<Root>,
    pub(super) nodes: Vec<TreeNode>,
    /// Index in `order` at which each leaf's primitives begin; one entry more than there are leaves.
    pub(super) leaf_starts: Vec<u32>,
    /// The primitives, leaf by leaf.
    pub(super) order: Vec<u32>,
}

/// Where a search begins.
#[derive(Clone, Copy, Debug)]
pub(in crate::geometry) struct Root {
    /// The box around everything below.
    pub(super) bounds: Bounds,
    pub(super) node: Child,
}

/// The work at the leaves of a search, in two steps: a wait for memory may come between.
pub(in crate::geometry) trait LeafVisitor {
    /// Called when a leaf is likely to be visited soon.
    fn announce(&self, _lanes: impl Lanes, _leaf: usize) {}

    /// A bit for each primitive of a leaf that is to be tested, which is likely to be soon.
    fn candidates(&self, lanes: impl Lanes, leaf: usize, ray: &LocalRay) -> u32;

    /// Tests these primitives of a leaf; returns the distance along the ray up to which to go on searching.
    fn test(&mut self, leaf: usize, candidates: u32) -> f64;
}

impl BoxTree {
    pub(in crate::geometry) fn frame(&self) -> TreeFrame {
        self.frame
    }

    /// The root of all boxes.
    #[inline]
    pub(in crate::geometry) fn whole(&self) -> Root {
        self.whole
    }

    /// The root of one part.
    #[inline]
    pub(in crate::geometry) fn part(&self, part: usize) -> Root {
        self.parts[part]
    }

    pub(in crate::geometry) fn leaf_count(&self) -> usize {
        self.leaf_starts.len() - 1
    }

    /// The boxes, leaf by leaf.
    pub(in crate::geometry) fn order(&self) -> &[u32] {
        &self.order
    }

    /// The positions of a leaf's boxes in [`Self::order`].
    #[inline]
    pub(in crate::geometry) fn leaf_range(&self, leaf: usize) -> Range<usize> {
        self.leaf_starts[leaf] as usize..self.leaf_starts[leaf + 1] as usize
    }

    /// The indices of a leaf's boxes.
    #[inline]
    pub(in crate::geometry) fn leaf(&self, leaf: usize) -> &[u32] {
        &self.order[self.leaf_range(leaf)]
    }

    /// The ray in the tree's own frame, unless it misses all boxes below `root` before `limit`.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(in crate::geometry) fn enter(&self, root: Root, ray: &Ray, limit: f64) -> Option<LocalRay> {
        // The root of nothing has no children to go on with.
        if root.bounds.is_empty() {
            return None;
        }
        LocalRay::enter(&self.frame, &root.bounds, ray, limit)
    }

    /// True if `leaf(position in the order)` holds for any primitive below `root`, in boxes for all of which
    /// `overlaps` holds.
    pub(in crate::geometry) fn any_box<O: FnMut(&Bounds) -> bool>(
        &self,
        root: Root,
        overlaps: &mut O,
        mut leaf: impl FnMut(usize, &mut O) -> bool,
    ) -> bool {
        let mut stack = vec![root.node];
        while let Some(next) = stack.pop() {
            if let Some(index) = next.as_leaf() {
                if self
                    .leaf_range(index)
                    .any(|position| leaf(position, overlaps))
                {
                    return true;
                }
                continue;
            }
            let node = &self.nodes[next.0 as usize];
            for i in 0..WIDTH {
                let bounds = node.child_bounds(i, self.frame);
                if !bounds.is_empty() && overlaps(&bounds) {
                    stack.push(node.children[i]);
                }
            }
        }
        false
    }

    pub(in crate::geometry) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.nodes)
            + size_of_val(&*self.parts)
            + size_of_val(&*self.leaf_starts)
            + size_of_val(&*self.order)
    }
}

impl TreeNode {
    /// For each child a lower bound on the distances at which some rays enter it, and a bit that is set if
    /// one of them may do so before `limit`. Of one ray both are its own.
    ///
    /// Distances below 0 need no bound: a child that is entered there is entered at 0, and one that is left
    /// there is missed.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn entries(
        &self,
        lanes: impl Lanes,
        axes: &[AxisRange; 3],
        limit: f32,
    ) -> ([f32; WIDTH], u32) {
        let mut near = lanes.splat(0.0);
        let mut far = lanes.splat(limit);
        for (axis, range) in axes.iter().enumerate() {
            let side = (range.sign & 1) as usize;
            let entering = lanes.splat(range.entering_reciprocal);
            let leaving = lanes.splat(range.leaving_reciprocal);
            let first = lanes.load(&self.planes[2 * axis + side]);
            let last = lanes.load(&self.planes[2 * axis + 1 - side]);
            let enter = lanes.sub(first, lanes.splat(range.near_origin));
            let leave = lanes.sub(last, lanes.splat(range.far_origin));
            near = lanes.max(lanes.mul(enter, entering), near);
            far = lanes.min(lanes.mul(leave, leaving), far);
        }
        let mut entries = [0.0; WIDTH];
        lanes.store(near, &mut entries);
        (entries, lanes.at_most(near, far))
    }

    /// A child's box in world space, rounded outward.
    fn child_bounds(&self, child: usize, frame: TreeFrame) -> Bounds {
        let plane = |side: usize, axis: usize| f64::from(self.planes[2 * axis + side][child]);
        let corner = |side| DVec3::new(plane(side, 0), plane(side, 1), plane(side, 2));
        // The scale is a power of two: its reciprocal and the product are exact.
        let size = frame.scale.recip();
        let to_world = |local: DVec3| local * size + frame.center;
        Bounds {
            min: to_world(corner(0)).map(f64::next_down),
            max: to_world(corner(1)).map(f64::next_up),
        }
    }
}
