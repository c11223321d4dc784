//! The search among a mesh's triangles.

use glam::{DVec2, DVec3};

use super::{
    Bounds, Hit, Mesh, Ray,
    accel::{BoxTree, Lanes, LeafVisitor, LocalRay, TrianglePack},
    nearest::Nearest,
    triangle::ShearedRay,
    world::TraversalCounters,
};

/// A tree over a mesh's distinct faces.
pub(super) struct MeshTree {
    tree: BoxTree,
    /// One a leaf.
    packs: Vec<TrianglePack>,
    /// The faces, leaf by leaf.
    faces: Vec<u32>,
    /// Their corners: copies, so that a test looks in one place and not in five.
    corners: Vec<[DVec3; 3]>,
}

impl MeshTree {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let faces = mesh.distinct_faces();
        let boxes: Vec<Bounds> = faces
            .iter()
            .map(|&face| Bounds::from_points(mesh.corners(face)))
            .collect();
        let tree = BoxTree::new(&boxes);
        let ordered = |range: &[u32]| -> Vec<u32> {
            range.iter().map(|&index| faces[index as usize]).collect()
        };
        let packs = (0..tree.leaf_count())
            .map(|leaf| {
                let faces = ordered(tree.leaf(leaf));
                TrianglePack::new(tree.frame(), faces.iter().map(|&face| mesh.corners(face)))
            })
            .collect();
        let faces = ordered(tree.order());
        let corners = faces.iter().map(|&face| mesh.corners(face)).collect();
        Self {
            tree,
            packs,
            faces,
            corners,
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes()
            + size_of_val(&*self.packs)
            + size_of_val(&*self.faces)
            + size_of_val(&*self.corners)
    }

    #[inline]
    pub(super) fn closest_hit(
        &self,
        shape: u32,
        ray: &Ray,
        nearest: &mut Nearest,
        counters: &mut TraversalCounters,
    ) {
        let limit = nearest.limit();
        let Some(local) = self.tree.enter(ray, limit) else {
            return;
        };
        let mut search = FaceSearch {
            tree: self,
            sheared: ShearedRay::new(ray),
            shape,
            tests: 0,
            limit,
            found: |hit: Hit| {
                nearest.offer(hit);
                nearest.limit()
            },
        };
        counters.node_visits += self.tree.search(&local, limit, &mut search);
        counters.primitive_tests += search.tests;
    }

    pub(super) fn any_hit(
        &self,
        shape: u32,
        ray: &Ray,
        max_distance: f64,
        blocks: &mut impl FnMut(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) -> bool {
        let Some(local) = self.tree.enter(ray, max_distance) else {
            return false;
        };
        let mut blocked = false;
        let mut search = FaceSearch {
            tree: self,
            sheared: ShearedRay::new(ray),
            shape,
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
        counters.node_visits += self.tree.search(&local, max_distance, &mut search);
        counters.primitive_tests += search.tests;
        blocked
    }

    pub(super) fn any_box(&self, overlaps: &mut impl FnMut(&Bounds) -> bool) -> bool {
        self.tree.any_box(overlaps, |position, overlaps| {
            overlaps(&Bounds::from_points(self.corners[position]))
        })
    }
}

/// Tests the faces of the leaves visited, exactly.
struct FaceSearch<'a, F> {
    tree: &'a MeshTree,
    sheared: ShearedRay,
    shape: u32,
    tests: u64,
    limit: f64,
    /// What to do with a hit; returns the new limit.
    found: F,
}

impl<F: FnMut(Hit) -> f64> LeafVisitor for FaceSearch<'_, F> {
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn visit(&mut self, lanes: impl Lanes, leaf: usize, ray: &LocalRay) -> f64 {
        let first = self.tree.tree.leaf_range(leaf).start;
        let mut candidates = self.tree.packs[leaf].candidates(lanes, ray);
        while candidates != 0 {
            let position = first + candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            self.tests += 1;
            if let Some(hit) = self.sheared.intersect(&self.tree.corners[position]) {
                self.limit = (self.found)(Hit {
                    distance: hit.distance,
                    shape: self.shape,
                    face: self.tree.faces[position],
                    barycentric: DVec2::new(hit.b1, hit.b2),
                });
            }
        }
        self.limit
    }
}
