//! Searches of many rays by turns.

use super::{
    lanes::Lanes,
    ray::LocalRay,
    tree::{BoxTree, LeafVisitor},
    walk::Walk,
};

/// Number of searches under way at a time: enough that a node has come from memory when its search has its
/// next turn.
const AT_A_TIME: usize = 12;

/// A supply of rays, and the work at the leaves that they meet.
pub(in crate::geometry) trait Searches {
    /// The next ray to search for, its number, and the distance up to which.
    fn next(&mut self) -> Option<(LocalRay, usize, f64)>;

    /// Called when a leaf is likely to be visited soon.
    fn announce(&self, lanes: impl Lanes, leaf: usize);

    /// As [`LeafVisitor::candidates`].
    fn candidates(&self, lanes: impl Lanes, leaf: usize, ray: &LocalRay) -> u32;

    /// As [`LeafVisitor::test`], for the ray of this number.
    fn test(&mut self, ray: usize, leaf: usize, candidates: u32) -> f64;
}

/// A search under way.
struct Slot {
    walk: Walk,
    ray: LocalRay,
    number: usize,
}

/// The work at the leaves of one of the searches.
struct Turn<'a, S> {
    searches: &'a mut S,
    number: usize,
}

impl<S: Searches> LeafVisitor for Turn<'_, S> {
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn announce(&self, lanes: impl Lanes, leaf: usize) {
        self.searches.announce(lanes, leaf);
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn candidates(&self, lanes: impl Lanes, leaf: usize, ray: &LocalRay) -> u32 {
        self.searches.candidates(lanes, leaf, ray)
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn test(&mut self, leaf: usize, candidates: u32) -> f64 {
        self.searches.test(self.number, leaf, candidates)
    }
}

impl BoxTree {
    /// All searches, some at a time by turns. Returns the number of nodes visited.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn search_all_local(&self, lanes: impl Lanes, searches: &mut impl Searches) -> u64 {
        let mut slots: Vec<Slot> = Vec::with_capacity(AT_A_TIME);
        let mut visits = 0;
        while slots.len() < AT_A_TIME
            && let Some((ray, number, limit)) = searches.next()
        {
            let mut walk = Walk::idle();
            walk.begin(self.whole, &ray, limit);
            slots.push(Slot { walk, ray, number });
        }
        while !slots.is_empty() {
            let mut turn = 0;
            while let Some(slot) = slots.get_mut(turn) {
                visits += u64::from(slot.walk.is_at_node());
                let mut visitor = Turn {
                    searches: &mut *searches,
                    number: slot.number,
                };
                if slot
                    .walk
                    .step::<false>(lanes, self, &slot.ray, &mut visitor)
                {
                    slot.walk.announce(lanes, self, &visitor);
                } else if let Some((ray, number, limit)) = searches.next() {
                    slot.walk.begin(self.whole, &ray, limit);
                    (slot.ray, slot.number) = (ray, number);
                } else {
                    slots.swap_remove(turn);
                    continue;
                }
                turn += 1;
            }
        }
        visits
    }
}
