//! The search among the triangles of meshes: for one ray here, for many in [`many`].

mod many;
mod sharing;

pub(super) use sharing::sharing;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{
    Bounds, Hit, Mesh, PlanePair, Ray,
    accel::{BoxTree, Lanes, LeafVisitor, LocalRay, Root, TrianglePack},
    counters::TraversalCounters,
    nearest::Nearest,
    triangle::ShearedRay,
};

/// What a search reads of a leaf: all but its candidates' corners.
#[repr(C, align(64))]
struct FaceLeaf {
    /// The triangles as the filter needs them.
    pack: TrianglePack,
    /// The position of the first among all faces in the order of leaves.
    first: u32,
    /// The shape that they belong to.
    shape: u32,
}

/// A tree over the distinct faces of one mesh, or of some of about the same size.
///
/// A search of all of them prepares its ray but once. Each can be searched alone, too.
pub(super) struct FaceTree {
    tree: BoxTree,
    leaves: Vec<FaceLeaf>,
    /// The faces, leaf by leaf.
    faces: Vec<u32>,
    /// Their corners: copies, so that a test reads from one place and not from five.
    corners: Vec<[DVec3; 3]>,
}

impl FaceTree {
    /// A tree over these shapes' meshes, each a part.
    pub(super) fn new(meshes: &[(u32, &Mesh)]) -> Self {
        let distinct: Vec<Vec<u32>> = meshes
            .par_iter()
            .map(|(_, mesh)| mesh.distinct_faces())
            .collect();
        let boxes: Vec<Vec<Bounds>> = (meshes.par_iter().zip(&distinct))
            .map(|((_, mesh), faces)| {
                let bounds = |&face: &u32| Bounds::from_points(mesh.corners(face));
                faces.par_iter().map(bounds).collect()
            })
            .collect();
        let boxes: Vec<&[Bounds]> = boxes.iter().map(Vec::as_slice).collect();
        let tree = BoxTree::of_parts(&boxes);
        // Of each box in the order of parts: the index of its mesh, and its face.
        let origin: Vec<(u32, u32)> = (0..)
            .zip(&distinct)
            .flat_map(|(part, faces)| faces.iter().map(move |&face| (part, face)))
            .collect();
        let corners = |&index: &u32| {
            let (part, face) = origin[index as usize];
            meshes[part as usize].1.corners(face)
        };
        let leaves = (0..tree.leaf_count())
            .into_par_iter()
            .map(|leaf| {
                let members = tree.leaf(leaf);
                let (part, _) = origin[members[0] as usize];
                FaceLeaf {
                    pack: TrianglePack::new(tree.frame(), members.iter().map(corners)),
                    first: tree.leaf_range(leaf).start as u32,
                    shape: meshes[part as usize].0,
                }
            })
            .collect();
        Self {
            leaves,
            faces: tree
                .order()
                .par_iter()
                .map(|&index| origin[index as usize].1)
                .collect(),
            corners: tree.order().par_iter().map(corners).collect(),
            tree,
        }
    }

    /// The root of all meshes.
    #[inline]
    pub(super) fn whole(&self) -> Root {
        self.tree.whole()
    }

    /// The root of one mesh, by its place among those given.
    #[inline]
    pub(super) fn part(&self, part: usize) -> Root {
        self.tree.part(part)
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes()
            + size_of_val(&*self.leaves)
            + size_of_val(&*self.faces)
            + size_of_val(&*self.corners)
    }

    #[inline]
    pub(super) fn closest_hit(
        &self,
        root: Root,
        ray: &Ray,
        nearest: &mut Nearest,
        counters: &mut TraversalCounters,
    ) {
        let limit = nearest.limit();
        let mut search = FaceSearch {
            tree: self,
            ray,
            tests: 0,
            limit,
            found: |hit: Hit| {
                nearest.offer(hit);
                nearest.limit()
            },
        };
        counters.node_visits += self.tree.search(root, ray, limit, &mut search);
        counters.primitive_tests += search.tests;
    }

    pub(super) fn any_hit(
        &self,
        ray: &Ray,
        max_distance: f64,
        blocks: &mut impl FnMut(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) -> bool {
        let root = self.whole();
        let mut blocked = false;
        let mut search = FaceSearch {
            tree: self,
            ray,
            tests: 0,
            limit: max_distance,
            found: |hit: Hit| {
                blocked = blocked || (hit.distance < max_distance && blocks(&hit));
                // Nothing is nearer than −∞: the search ends.
                if blocked {
                    f64::NEG_INFINITY
                } else {
                    max_distance
                }
            },
        };
        counters.node_visits += self.tree.search(root, ray, max_distance, &mut search);
        counters.primitive_tests += search.tests;
        blocked
    }

    /// Exact tests of some faces of a leaf.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn test(&self, leaf: usize, mut candidates: u32, ray: &Ray, mut found: impl FnMut(Hit)) {
        let sheared = ShearedRay::new(ray);
        let FaceLeaf { first, shape, .. } = self.leaves[leaf];
        while candidates != 0 {
            let position = (first + candidates.trailing_zeros()) as usize;
            candidates &= candidates - 1;
            if let Some(hit) = sheared.intersect(&self.corners[position]) {
                found(Hit {
                    distance: hit.distance,
                    shape,
                    face: self.faces[position],
                    barycentric: DVec2::new(hit.b1, hit.b2),
                });
            }
        }
    }

    pub(super) fn any_box(&self, root: Root, overlaps: &mut impl FnMut(&Bounds) -> bool) -> bool {
        self.tree.any_box(root, overlaps, |position, overlaps| {
            overlaps(&Bounds::from_points(self.corners[position]))
        })
    }

    pub(super) fn any_face(
        &self,
        root: Root,
        pairs: impl Iterator<Item = PlanePair>,
        mut test: impl FnMut(u32, &[DVec3; 3]) -> bool,
    ) -> bool {
        self.tree.any_between_planes(root, pairs, |position| {
            test(self.faces[position], &self.corners[position])
        })
    }
}

/// An exact test of the faces of the leaves visited.
struct FaceSearch<'a, F> {
    tree: &'a FaceTree,
    ray: &'a Ray,
    tests: u64,
    limit: f64,
    /// The action for a hit; returns the new limit.
    found: F,
}

impl<F: FnMut(Hit) -> f64> LeafVisitor for FaceSearch<'_, F> {
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn announce(&self, lanes: impl Lanes, leaf: usize) {
        lanes.prefetch(&self.tree.leaves[leaf]);
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn candidates(&self, lanes: impl Lanes, leaf: usize, ray: &LocalRay) -> u32 {
        self.tree.leaves[leaf].pack.candidates(lanes, ray)
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn test(&mut self, leaf: usize, candidates: u32) -> f64 {
        self.tests += u64::from(candidates.count_ones());
        self.tree.test(leaf, candidates, self.ray, |hit| {
            self.limit = (self.found)(hit);
        });
        self.limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{MeshParts, Segment};
    use crate::numeric::math;

    /// Numbers in -1..1, the same ones each time.
    struct Sequence(u64);

    impl Sequence {
        fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 * math::powi(2f64, -52) - 1.0
        }

        fn point(&mut self) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next())
        }
    }

    /// The hit found by exact tests of every face, with neither boxes nor filter.
    fn try_every_face(mesh: &Mesh, ray: &Ray) -> Option<Hit> {
        let sheared = ShearedRay::new(ray);
        let mut nearest = Nearest::before(f64::INFINITY);
        for face in 0..mesh.triangle_count() as u32 {
            if let Some(hit) = sheared.intersect(&mesh.corners(face)) {
                nearest.offer(Hit {
                    distance: hit.distance,
                    shape: 0,
                    face,
                    barycentric: DVec2::new(hit.b1, hit.b2),
                });
            }
        }
        nearest.hit()
    }

    /// A crumpled sheet: a height field over an n × n grid, scaled and moved.
    fn sheet(n: u32, scale: f64, offset: DVec3) -> Mesh {
        let mut sequence = Sequence(5);
        let positions = (0..n * n)
            .map(|i| {
                let grid =
                    DVec3::new(f64::from(i % n), f64::from(i / n), 0.0) * (2.0 / f64::from(n));
                (grid - DVec3::new(1.0, 1.0, 0.0) + 0.2 * sequence.point() * DVec3::Z) * scale
                    + offset
            })
            .collect();
        let mut triangles = Vec::new();
        for y in 0..n - 1 {
            for x in 0..n - 1 {
                let a = y * n + x;
                triangles.extend([[a, a + 1, a + n], [a + 1, a + n + 1, a + n]]);
            }
        }
        Mesh::new(MeshParts {
            positions,
            triangles,
            ..MeshParts::default()
        })
        .expect("valid")
    }

    #[test]
    fn all_ways_to_search_find_the_very_hit_that_trying_every_face_finds() {
        let mut hits = 0;
        for (scale, offset, away) in [
            (1.0, DVec3::ZERO, 1.0),
            (1e-6, DVec3::ONE, 1.0),
            (1e6, DVec3::splat(3e5), 1.0),
            (1.0, DVec3::splat(1_048_576.0), 1.0),
            // From so far away that `f32` could not tell the start from the mesh.
            (1e-3, DVec3::ZERO, 1e7),
        ] {
            let mesh = sheet(24, scale, offset);
            let tree = FaceTree::new(&[(0, &mesh)]);
            let mut sequence = Sequence(9);
            let (mut segments, mut alone) = (Vec::new(), Vec::new());
            let mut counters = TraversalCounters::default();
            let mut one_by_one = TraversalCounters::default();
            for i in 0..40_000 {
                let mut from = sequence.point() * 2.0 * away;
                // On a vertex, on an edge, or anywhere.
                let [a, b, c] = mesh.corners((i * 7) % mesh.triangle_count() as u32);
                let to = match i % 4 {
                    0 => a,
                    1 => 0.5 * (a + b),
                    2 => (a + b + c) / 3.0,
                    _ => sequence.point() * scale + offset,
                };
                from = from * scale + offset;
                if i % 5 == 0 {
                    from = DVec3::new(to.x, to.y, from.z); // along an axis
                }
                let Some(direction) = (to - from).try_normalize() else {
                    continue;
                };
                let ray = Ray::new(from, direction);
                let mut nearest = Nearest::before(f64::INFINITY);
                tree.closest_hit(tree.whole(), &ray, &mut nearest, &mut counters);
                let expected = try_every_face(&mesh, &ray);
                hits += usize::from(expected.is_some());
                assert_eq!(nearest.clone().hit(), expected, "scale {scale:e}, {ray:?}");
                // Every other segment ends at the hit: it is not reached.
                let length = if segments.len() % 2 == 0 {
                    f64::INFINITY
                } else {
                    nearest.limit()
                };
                let mut before = Nearest::before(length);
                tree.closest_hit(tree.whole(), &ray, &mut before, &mut one_by_one);
                alone.push(expected.filter(|hit| hit.distance < length));
                segments.push(Segment { ray, length });
            }
            let before = |segments: &[Segment]| -> Vec<Nearest> {
                let lengths = segments.iter().map(|segment| segment.length);
                lengths.map(Nearest::before).collect()
            };
            let hits_of =
                |found: Vec<Nearest>| -> Vec<_> { found.into_iter().map(Nearest::hit).collect() };
            let mut turns = TraversalCounters::default();
            let mut found = before(&segments);
            tree.closest_hits_by(BoxTree::search_all, &segments, &mut found, &mut turns);
            assert_eq!(hits_of(found), alone, "scale {scale:e}");
            assert_eq!(turns, one_by_one);
            // Packets of few rays, and full ones whose rays have but the signs of their directions in common.
            let mut order: Vec<usize> = (0..segments.len()).collect();
            for is_sorted in [false, true] {
                if is_sorted {
                    let signs = |i: &usize| {
                        let direction = segments[*i].ray.direction.to_array();
                        direction.map(f64::is_sign_negative)
                    };
                    order.sort_by_key(signs);
                }
                let asked: Vec<Segment> = order.iter().map(|&i| segments[i]).collect();
                let expected: Vec<_> = order.iter().map(|&i| alone[i]).collect();
                let mut found = before(&asked);
                let mut packets = TraversalCounters::default();
                let search = BoxTree::search_packets;
                tree.closest_hits_by(search, &asked, &mut found, &mut packets);
                assert_eq!(hits_of(found), expected, "scale {scale:e}, {is_sorted}");
            }
        }
        assert!(hits > 120_000, "only {hits} hits: the rays test little");
    }
}
