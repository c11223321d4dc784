//! The search among a mesh's triangles.

use glam::DVec2;

use super::{
    Bounds, Hit, Mesh, Ray,
    accel::{BoxTree, LeafVisitor, LocalRay, TrianglePack},
    nearest::Nearest,
    triangle::ShearedRay,
    world::TraversalCounters,
};

/// A tree over a mesh's distinct faces.
pub(super) struct MeshTree {
    tree: BoxTree,
    /// One a leaf.
    packs: Vec<TrianglePack>,
    /// The face of each box.
    faces: Vec<u32>,
}

impl MeshTree {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let faces = mesh.distinct_faces();
        let boxes: Vec<Bounds> = faces
            .iter()
            .map(|&face| Bounds::from_points(mesh.corners(face)))
            .collect();
        let tree = BoxTree::new(&boxes);
        let packs = (0..tree.leaf_count())
            .map(|leaf| {
                let triangles = tree.leaf(leaf).iter().map(|&index| {
                    let face = faces[index as usize];
                    (face, mesh.corners(face))
                });
                TrianglePack::new(tree.frame(), triangles)
            })
            .collect();
        Self { tree, packs, faces }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes() + size_of_val(&*self.packs) + size_of_val(&*self.faces)
    }

    #[inline]
    pub(super) fn closest_hit(
        &self,
        mesh: &Mesh,
        shape: u32,
        ray: &Ray,
        nearest: &mut Nearest,
        counters: &mut TraversalCounters,
    ) {
        let mut search = FaceSearch {
            tree: self,
            mesh,
            sheared: ShearedRay::new(ray),
            shape,
            tests: 0,
            limit: nearest.limit(),
            found: |hit: Hit| {
                nearest.offer(hit);
                nearest.limit()
            },
        };
        let limit = search.limit;
        counters.node_visits += self.tree.search(ray, limit, &mut search);
        counters.primitive_tests += search.tests;
    }

    pub(super) fn any_hit(
        &self,
        mesh: &Mesh,
        shape: u32,
        ray: &Ray,
        max_distance: f64,
        blocks: &mut impl FnMut(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) -> bool {
        let mut blocked = false;
        let mut search = FaceSearch {
            tree: self,
            mesh,
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
        counters.node_visits += self.tree.search(ray, max_distance, &mut search);
        counters.primitive_tests += search.tests;
        blocked
    }

    pub(super) fn any_box(&self, mesh: &Mesh, overlaps: &mut impl FnMut(&Bounds) -> bool) -> bool {
        self.tree.any_box(overlaps, |index, overlaps| {
            let face = self.faces[index as usize];
            overlaps(&Bounds::from_points(mesh.corners(face)))
        })
    }
}

/// Tests the faces of the leaves visited, exactly.
struct FaceSearch<'a, F> {
    tree: &'a MeshTree,
    mesh: &'a Mesh,
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
    fn visit(&mut self, leaf: usize, ray: &LocalRay) -> f64 {
        let pack = &self.tree.packs[leaf];
        let mut candidates = pack.candidates(ray);
        while candidates != 0 {
            let slot = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            let face = pack.face(slot);
            self.tests += 1;
            if let Some(hit) = self.sheared.intersect(self.mesh.corners(face)) {
                self.limit = (self.found)(Hit {
                    distance: hit.distance,
                    shape: self.shape,
                    face,
                    barycentric: DVec2::new(hit.b1, hit.b2),
                });
            }
        }
        self.limit
    }
}
