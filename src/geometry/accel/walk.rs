//! The search down a tree, one node or leaf at a time.

use arrayvec::ArrayVec;

use super::{
    lanes::Lanes,
    ray::LocalRay,
    tree::{AxisRange, BoxTree, Child, LeafVisitor, Root},
};
use crate::geometry::Ray;

/// A ray's search under way: what it visits next, and what waits.
///
/// It goes step by step, so that it can wait for memory while others go on (see [`stream`](super::stream)).
pub(super) struct Walk {
    stack: Stack,
    next: Child,
    /// Primitives of the next leaf that are to be tested; 0 if the leaf was not looked at.
    candidates: u32,
    /// The distance in the tree's frame up to which to go on.
    limit: f32,
}

impl BoxTree {
    /// The search of one ray, to be compiled for each set of registers.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn search_local(
        &self,
        lanes: impl Lanes,
        root: Root,
        ray: &Ray,
        limit: f64,
        visitor: &mut impl LeafVisitor,
    ) -> u64 {
        let Some(ray) = &self.enter(root, ray, limit) else {
            return 0;
        };
        let mut walk = Walk::idle();
        walk.begin(root, ray, limit);
        let mut visits = 0;
        loop {
            visits += u64::from(walk.is_at_node());
            if !walk.step::<true>(lanes, self, ray, visitor) {
                return visits;
            }
        }
    }
}

impl Walk {
    /// A search that has not begun.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn idle() -> Self {
        Self {
            stack: Stack::new(),
            next: Child::NONE,
            candidates: 0,
            limit: 0.0,
        }
    }

    /// Begins at a root. Nothing waits: the search before has ended, or there was none.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn begin(&mut self, root: Root, ray: &LocalRay, limit: f64) {
        self.next = root.node;
        self.candidates = 0;
        self.limit = ray.local_limit(limit);
    }

    /// True if the next step visits a node.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn is_at_node(&self) -> bool {
        self.next.as_leaf().is_none()
    }

    /// Visits the next node, looks at the next leaf or tests its candidates; false if nothing is left.
    ///
    /// `AHEAD` hints at all children that wait, which pays if the search goes on at once.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn step<const AHEAD: bool>(
        &mut self,
        lanes: impl Lanes,
        tree: &BoxTree,
        ray: &LocalRay,
        visitor: &mut impl LeafVisitor,
    ) -> bool {
        if let Some(leaf) = self.next.as_leaf() {
            if self.candidates == 0 {
                self.candidates = visitor.candidates(lanes, leaf, ray);
                if self.candidates != 0 {
                    return true;
                }
            } else {
                self.limit = ray.local_limit(visitor.test(leaf, self.candidates));
                self.candidates = 0;
            }
        } else {
            let node = &tree.nodes[self.next.0 as usize];
            let (entries, mut hits) = node.entries(lanes, &AxisRange::of(ray), self.limit);
            if hits != 0 {
                let mut nearest = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                let bottom = self.stack.len();
                while hits != 0 {
                    let mut further = hits.trailing_zeros() as usize;
                    hits &= hits - 1;
                    if entries[further] < entries[nearest] {
                        std::mem::swap(&mut nearest, &mut further);
                    }
                    let child = node.children[further];
                    if AHEAD {
                        announce(lanes, tree, child, visitor);
                    }
                    self.stack.push_sorted(bottom, entries[further], child);
                }
                self.next = node.children[nearest];
                return true;
            }
        }
        loop {
            match self.stack.pop() {
                None => return false,
                Some((entry, child)) if entry <= self.limit => {
                    self.next = child;
                    return true;
                }
                Some(_) => {}
            }
        }
    }

    /// Hints that the next node or leaf will be read soon.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn announce(&self, lanes: impl Lanes, tree: &BoxTree, visitor: &impl LeafVisitor) {
        if self.candidates == 0 {
            announce(lanes, tree, self.next, visitor);
        }
    }
}

#[inline(always)]
#[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
fn announce(lanes: impl Lanes, tree: &BoxTree, child: Child, visitor: &impl LeafVisitor) {
    match child.as_leaf() {
        Some(leaf) => visitor.announce(lanes, leaf),
        None => lanes.prefetch(&tree.nodes[child.0 as usize]),
    }
}

/// Children still to be visited, with the distances at which the ray enters them.
///
/// The array is of fixed size, as nearly all searches need no more; the rest goes to the heap.
pub(super) struct Stack<T = Child> {
    fixed: ArrayVec<(f32, T), FIXED>,
    spilled: Vec<(f32, T)>,
}

const FIXED: usize = 48;

impl<T: Copy> Stack<T> {
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is copied to its place
    pub(super) fn new() -> Self {
        Self {
            fixed: ArrayVec::new_const(),
            spilled: Vec::new(),
        }
    }

    #[inline]
    pub(super) fn len(&self) -> usize {
        self.fixed.len()
    }

    /// Pushes a child whose distance does not matter.
    #[inline]
    pub(super) fn push(&mut self, child: T) {
        self.push_sorted(self.fixed.len(), 0.0, child);
    }

    /// Pushes below those entries above `bottom` that are nearer.
    #[inline]
    pub(super) fn push_sorted(&mut self, bottom: usize, entry: f32, child: T) {
        let mut place = self.fixed.len();
        if self.fixed.try_push((entry, child)).is_err() {
            // The nearest-first order is a matter of speed only.
            self.spilled.push((entry, child));
            return;
        }
        while place > bottom && self.fixed[place - 1].0 < entry {
            self.fixed.swap(place - 1, place);
            place -= 1;
        }
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<(f32, T)> {
        self.fixed.pop().or_else(|| self.spilled.pop())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stack_gives_back_all_that_it_was_given_and_the_nearest_above_its_bottom_first() {
        let mut stack = Stack::new();
        let count = 3 * FIXED;
        for number in 0..count {
            // Two at a time, the further one last.
            let bottom = number / 2 * 2;
            stack.push_sorted(bottom, (number % 2) as f32, number);
        }
        assert_eq!(stack.len(), FIXED);
        let mut given = Vec::new();
        while let Some((_, number)) = stack.pop() {
            given.push(number);
        }
        assert_eq!(given[..4], [FIXED - 2, FIXED - 1, FIXED - 4, FIXED - 3]);
        given.sort_unstable();
        assert!(given.into_iter().eq(0..count));
    }
}
