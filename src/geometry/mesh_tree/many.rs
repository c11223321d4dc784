//! The search among a mesh's triangles for many rays, which wait for memory together.

use super::MeshTree;
use crate::geometry::{
    Segment,
    accel::{Lanes, LocalRay, Searches},
    counters::TraversalCounters,
    nearest::Nearest,
    triangle::ShearedRay,
};

/// Leaves that a core's own caches may hold, so that searches do not wait for memory. Of 80,000 triangles
/// there are twice as many, and for rays at random searches by turns take 0.7 of the time; of 20,000 there
/// are half as many, and they take 1.04 times as long. Those cores had 1 MiB each.
const LEAVES_IN_CACHES: usize = 8192;

/// Mean number of leaves between a ray and its predecessor from which on searches by turns pay. Both ways
/// took the same time at 15, 8 and 8 of them for 80,000, 328,000 and 871,000 triangles.
const LEAVES_APART: f64 = 10.0;

impl MeshTree {
    /// [`Self::closest_hit`] of many rays, each with its own nearest hit so far.
    ///
    /// Searches go on by turns if that is likely to pay. The hits are the same.
    pub(in crate::geometry) fn closest_hits(
        &self,
        shape: u32,
        segments: &[Segment],
        nearest: &mut [Nearest],
        counters: &mut TraversalCounters,
    ) {
        if self.exceeds_caches() && self.are_apart(segments) {
            self.closest_hits_by_turns(shape, segments, nearest, counters);
        } else {
            for (segment, nearest) in segments.iter().zip(nearest) {
                self.closest_hit(shape, &segment.ray, nearest, counters);
            }
        }
    }

    /// The same by turns, whether it pays or not.
    pub(super) fn closest_hits_by_turns(
        &self,
        shape: u32,
        segments: &[Segment],
        nearest: &mut [Nearest],
        counters: &mut TraversalCounters,
    ) {
        let mut searches = HitSearches {
            tree: self,
            shape,
            segments,
            nearest,
            next: 0,
            tests: 0,
        };
        counters.node_visits += self.tree.search_all(&mut searches);
        counters.primitive_tests += searches.tests;
    }

    /// True if searches may wait for memory.
    pub(in crate::geometry) fn exceeds_caches(&self) -> bool {
        self.leaves.len() >= LEAVES_IN_CACHES
    }

    /// True if the rays are so far from their predecessors that they visit other leaves.
    ///
    /// Near rays find what they need in a core's own caches. A processor also foresees the way of their
    /// searches, which it cannot if they go on by turns. A surface's leaves are about 1 / √leaves apart, in
    /// units of its extent.
    fn are_apart(&self, segments: &[Segment]) -> bool {
        let scale = self.tree.frame().scale;
        let steps = segments.windows(2).map(|pair| {
            let [a, b] = [pair[0].ray, pair[1].ray];
            a.origin.distance(b.origin) * scale + a.direction.distance(b.direction)
        });
        let mean = steps.sum::<f64>() / segments.len() as f64;
        mean * (self.leaves.len() as f64).sqrt() > LEAVES_APART
    }
}

/// The searches for the nearest hits of many rays.
struct HitSearches<'a> {
    tree: &'a MeshTree,
    shape: u32,
    segments: &'a [Segment],
    nearest: &'a mut [Nearest],
    /// The next ray's index.
    next: usize,
    tests: u64,
}

impl Searches for HitSearches<'_> {
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn next(&mut self) -> Option<(LocalRay, usize, f64)> {
        while let Some(segment) = self.segments.get(self.next) {
            let number = self.next;
            self.next += 1;
            let limit = self.nearest[number].limit();
            if let Some(local) = self.tree.tree.enter(&segment.ray, limit) {
                return Some((local, number, limit));
            }
        }
        None
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn announce(&self, lanes: impl Lanes, leaf: usize) {
        lanes.prefetch(&self.tree.leaves[leaf]);
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn candidates(&self, lanes: impl Lanes, leaf: usize, ray: &LocalRay) -> u32 {
        let leaf = &self.tree.leaves[leaf];
        let candidates = leaf.pack.candidates(lanes, ray);
        let mut rest = candidates;
        while rest != 0 {
            let position = leaf.first as usize + rest.trailing_zeros() as usize;
            lanes.prefetch(&self.tree.corners[position]);
            rest &= rest - 1;
        }
        candidates
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn test(&mut self, ray: usize, leaf: usize, candidates: u32) -> f64 {
        self.tests += u64::from(candidates.count_ones());
        let sheared = ShearedRay::new(&self.segments[ray].ray);
        let nearest = &mut self.nearest[ray];
        self.tree
            .test(leaf, candidates, self.shape, &sheared, |hit| {
                nearest.offer(hit);
            });
        nearest.limit()
    }
}
