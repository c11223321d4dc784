//! The search among the triangles of meshes for many rays, which wait for memory together.

use super::FaceTree;
use crate::geometry::{
    Segment,
    accel::{Lanes, LocalRay, Searches},
    counters::TraversalCounters,
    nearest::Nearest,
};

/// Number of leaves from which on searches wait for memory, by measurement. With 16,000 of them (80,000
/// triangles), rays at random take 0.7 of the time by turns. With 4,000 they take 1.04.
const MANY_LEAVES: usize = 8192;

/// Mean number of leaves between a ray and its predecessor from which on searches by turns pay. Both ways
/// took the same time at 15, 8 and 8 of them for 80,000, 328,000 and 871,000 triangles.
const LEAVES_APART: f64 = 10.0;

impl FaceTree {
    /// [`Self::closest_hit`] of many rays, each with its own nearest hit so far.
    ///
    /// Searches go on by turns if that is likely to pay. The hits are the same.
    pub(in crate::geometry) fn closest_hits(
        &self,
        segments: &[Segment],
        nearest: &mut [Nearest],
        counters: &mut TraversalCounters,
    ) {
        if self.waits_for_memory() && self.are_apart(segments) {
            self.closest_hits_by_turns(segments, nearest, counters);
        } else {
            for (segment, nearest) in segments.iter().zip(nearest) {
                self.closest_hit(self.whole(), &segment.ray, nearest, counters);
            }
        }
    }

    /// The same by turns, whether it pays or not.
    pub(super) fn closest_hits_by_turns(
        &self,
        segments: &[Segment],
        nearest: &mut [Nearest],
        counters: &mut TraversalCounters,
    ) {
        let mut searches = HitSearches {
            tree: self,
            segments,
            nearest,
            next: 0,
            tests: 0,
        };
        counters.node_visits += self.tree.search_all(&mut searches);
        counters.primitive_tests += searches.tests;
    }

    /// True if searches may wait for memory.
    pub(in crate::geometry) fn waits_for_memory(&self) -> bool {
        self.leaves.len() >= MANY_LEAVES
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
            // Beyond the tree's extent, further is not more apart.
            let origins = (a.origin.distance(b.origin) * scale).min(2.0);
            origins + a.direction.distance(b.direction)
        });
        let mean = steps.sum::<f64>() / segments.len() as f64;
        mean * (self.leaves.len() as f64).sqrt() > LEAVES_APART
    }
}

/// The searches for the nearest hits of many rays.
struct HitSearches<'a> {
    tree: &'a FaceTree,
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
            if let Some(local) = self.tree.tree.enter(self.tree.whole(), &segment.ray, limit) {
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
            lanes.prefetch(&self.tree.faces[position]);
            rest &= rest - 1;
        }
        candidates
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn test(&mut self, ray: usize, leaf: usize, candidates: u32) -> f64 {
        self.tests += u64::from(candidates.count_ones());
        let nearest = &mut self.nearest[ray];
        let ray = &self.segments[ray].ray;
        self.tree.test(leaf, candidates, ray, |hit| {
            nearest.offer(hit);
        });
        nearest.limit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Mesh, MeshParts, Ray};
    use crate::numeric::{Stream, StreamKind};
    use glam::DVec3;

    /// A flat sheet of 2 n² triangles in -1..1.
    fn sheet(n: u32) -> FaceTree {
        let row = n + 1;
        let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
        let positions = (0..row * row).map(|i| DVec3::new(at(i % row), at(i / row), 0.0));
        let squares = (0..n * n).map(|i| i / n * row + i % n);
        let triangles = squares.flat_map(|a| [[a, a + 1, a + row], [a + 1, a + row + 1, a + row]]);
        let mesh = Mesh::new(MeshParts {
            positions: positions.collect(),
            triangles: triangles.collect(),
            ..MeshParts::default()
        });
        FaceTree::new(&[(0, &mesh.expect("valid"))])
    }

    fn downward(origins: impl Iterator<Item = DVec3>) -> Vec<Segment> {
        let segment = |origin| Segment {
            ray: Ray::new(origin, DVec3::NEG_Z),
            length: f64::INFINITY,
        };
        origins.map(segment).collect()
    }

    #[test]
    fn searches_take_turns_if_many_leaves_are_met_at_random() {
        let (small, large) = (sheet(20), sheet(200));
        assert!(!small.waits_for_memory());
        assert!(large.waits_for_memory());
        let stream = Stream::new(StreamKind::Random, 1);
        let at = |i: u64, width: f64| {
            let [x, y] = stream.point2(i);
            DVec3::new(width * (2.0 * x - 1.0), width * (2.0 * y - 1.0), 1.0)
        };
        let random = downward((0..512).map(|i| at(i, 1.0)));
        let near = downward((0..512).map(|i| at(i, 1e-3)));
        let with_one_far = downward((0..512).map(|i| at(i, if i == 99 { 1e6 } else { 1e-3 })));
        assert!(large.are_apart(&random));
        assert!(!large.are_apart(&near));
        assert!(!large.are_apart(&with_one_far));
        assert!(!large.are_apart(&random[..1]));
        assert!(!large.are_apart(&[]));
    }
}
