//! The search among the triangles of meshes for many rays, which wait for memory together.

use super::FaceTree;
use crate::geometry::{
    Ray, Segment,
    accel::{BoxTree, Lanes, LocalRay, Searches},
    counters::TraversalCounters,
    nearest::Nearest,
};

/// Number of leaves from which on searches wait for memory, by measurement. With 16,000 of them (80,000
/// triangles), rays at random take 0.7 of the time by turns. With 4,000 they take 1.04.
const MANY_LEAVES: usize = 8192;

/// Mean number of leaves between a ray and its predecessor from which on searches by turns pay. Both ways
/// took the same time at 15, 8 and 8 of them for 80,000, 328,000 and 871,000 triangles.
const LEAVES_APART: f64 = 10.0;

/// Number of leaves from which on packets pay.
const PACKET_LEAVES: usize = 16;

/// The distance of neighbours up to which packets pay, times the fourth root of the number of leaves: in the
/// tree's frame, where they pass its middle, and between their unit directions.
///
/// By measurement of rows of images, of 200 to 871,000 triangles. From outside of a mesh packets and single
/// rays take the same time at 0.26 to 0.6, from inside at 1.3 or more. In rows a tenth as wide packets take
/// 0.6 of it.
const PACKET_SPREAD: f64 = 0.3;

impl FaceTree {
    /// [`Self::closest_hit`] of many rays, each with its own nearest hit so far.
    ///
    /// Rays that go about the same way go down the tree in packets, those that are far apart by turns, if
    /// that is likely to pay. The hits are the same.
    pub(in crate::geometry) fn closest_hits(
        &self,
        segments: &[Segment],
        nearest: &mut [Nearest],
        counters: &mut TraversalCounters,
    ) {
        if self.are_near(segments) {
            self.closest_hits_by(BoxTree::search_packets, segments, nearest, counters);
        } else if self.waits_for_memory() && self.are_apart(segments) {
            self.closest_hits_by(BoxTree::search_all, segments, nearest, counters);
        } else {
            for (segment, nearest) in segments.iter().zip(nearest) {
                self.closest_hit(self.whole(), &segment.ray, nearest, counters);
            }
        }
    }

    /// The same by one of the tree's searches of many rays, whether it pays or not.
    pub(super) fn closest_hits_by<'a>(
        &'a self,
        search: impl FnOnce(&BoxTree, &mut HitSearches<'a>) -> u64,
        segments: &'a [Segment],
        nearest: &'a mut [Nearest],
        counters: &mut TraversalCounters,
    ) {
        let mut searches = HitSearches::new(self, segments, nearest);
        counters.node_visits += search(&self.tree, &mut searches);
        counters.primitive_tests += searches.tests;
    }

    /// True if many searches may be sooner than one after the other.
    pub(in crate::geometry) fn gains_by_many(&self) -> bool {
        self.leaves.len() >= PACKET_LEAVES
    }

    /// True if searches may wait for memory.
    fn waits_for_memory(&self) -> bool {
        self.leaves.len() >= MANY_LEAVES
    }

    /// True if nearly all rays go about the same way as their predecessors: with the same signs, and as far
    /// apart, where they pass the middle of the tree, as a packet's may be.
    fn are_near(&self, segments: &[Segment]) -> bool {
        if !self.gains_by_many() {
            return false;
        }
        let frame = self.tree.frame();
        let near = PACKET_SPREAD / (self.leaves.len() as f64).sqrt().sqrt();
        let middle = |ray: &Ray| {
            let along = ray.direction.dot(frame.center - ray.origin).max(0.0);
            ray.origin + ray.direction * along
        };
        let is_near = |pair: &&[Segment]| {
            let [a, b] = [pair[0].ray, pair[1].ray];
            let places = middle(&a).distance(middle(&b)) * frame.scale;
            let signs = |ray: &Ray| ray.direction.is_negative_bitmask();
            signs(&a) == signs(&b) && places + a.direction.distance(b.direction) < near
        };
        // One pair of eight rays tells enough.
        let pairs = segments.chunks_exact(2).step_by(4);
        let all = pairs.len();
        all > 0 && 8 * pairs.filter(is_near).count() >= 7 * all
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
pub(super) struct HitSearches<'a> {
    tree: &'a FaceTree,
    segments: &'a [Segment],
    nearest: &'a mut [Nearest],
    /// The next ray's index.
    next: usize,
    tests: u64,
}

impl<'a> HitSearches<'a> {
    fn new(tree: &'a FaceTree, segments: &'a [Segment], nearest: &'a mut [Nearest]) -> Self {
        Self {
            tree,
            segments,
            nearest,
            next: 0,
            tests: 0,
        }
    }
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
    use crate::geometry::{Mesh, MeshParts};
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
    fn rays_go_down_the_tree_in_packets_if_nearly_all_are_near_their_predecessors() {
        let tree = sheet(200);
        // Neighbours are so much of the largest spread apart: in places from here, in directions from afar.
        let spread = PACKET_SPREAD / (tree.leaves.len() as f64).sqrt().sqrt();
        let scale = tree.tree.frame().scale;
        let row = |share: f64| {
            let step = share * spread / scale;
            downward((0..64).map(|i| DVec3::new(step * f64::from(i % 2), 0.0, 1.0)))
        };
        assert!(tree.are_near(&row(0.99)));
        assert!(!tree.are_near(&row(1.01)));
        // From ten units away, directions a tenth as far apart lead as far; they count, too.
        let fan = |share: f64| -> Vec<Segment> {
            let angle = share * spread / (10.0 * scale + 1.0);
            let ray = |i: u32| {
                let x = angle * f64::from(i % 2);
                Ray::new(DVec3::Z * 10.0, DVec3::new(x, 0.0, -1.0).normalize())
            };
            let segment = |ray| Segment {
                ray,
                length: f64::INFINITY,
            };
            (0..64).map(ray).map(segment).collect()
        };
        assert!(tree.are_near(&fan(0.99)));
        assert!(!tree.are_near(&fan(1.02)));
        // Rays that leave the middle behind are as far apart as where they start.
        let mut away = row(0.99);
        for (i, segment) in away.iter_mut().enumerate() {
            let side = 2.0 * (i % 2) as f64 - 1.0;
            let out = DVec3::new(0.1 * spread * side, 0.1 * spread, 1.0);
            segment.ray = Ray::new(DVec3::new(0.0, 0.0, 30.0), out.normalize());
        }
        assert!(!tree.are_near(&away), "directions of other signs");
        for (i, segment) in away.iter_mut().enumerate() {
            let out = DVec3::new(0.1 * spread * (1 + i % 2) as f64, 0.1 * spread, 1.0);
            segment.ray = Ray::new(DVec3::new(0.0, 0.0, 30.0), out.normalize());
        }
        assert!(tree.are_near(&away));
        // Of 64 rays eight pairs are looked at.
        let mut odd = row(0.5);
        odd[8].ray.origin.x += 1.0;
        assert!(tree.are_near(&odd));
        odd[16].ray.origin.x += 1.0;
        assert!(!tree.are_near(&odd));
        assert!(!tree.are_near(&row(0.5)[..1]));
        assert!(!sheet(5).are_near(&row(0.5)), "few leaves");
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
