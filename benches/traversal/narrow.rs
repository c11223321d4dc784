//! The search that obvhs itself offers: an eight-wide compressed tree over triangles, all in `f32`.

use std::time::Duration;

use glam::DVec3;
use nephroid::internals::geometry::{Mesh, Ray};
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    ray::{Ray as NarrowRay, RayHit},
    triangle::Triangle,
};

/// A mesh in `f32`, to be hit by rays in `f32`.
pub struct Narrow {
    tree: CwBvh,
    /// The triangles, in the order of the tree's leaves.
    triangles: Vec<Triangle>,
}

impl Narrow {
    pub fn new(mesh: &Mesh) -> Self {
        let triangles: Vec<Triangle> = (0..mesh.triangle_count() as u32)
            .map(|face| {
                let [v0, v1, v2] = mesh.corners(face).map(narrow);
                Triangle { v0, v1, v2 }
            })
            .collect();
        // Its clusters look as far for partners as ours do (see `geometry/accel/clustering.rs`).
        let parameters = BvhBuildParams::medium_build();
        let tree = build_cwbvh_from_tris(&triangles, parameters, &mut Duration::default());
        let triangles = tree
            .primitive_indices
            .iter()
            .map(|&face| triangles[face as usize])
            .collect();
        Self { tree, triangles }
    }

    /// The nearest hit: triangle and distance.
    #[inline]
    pub fn hit(&self, ray: &Ray) -> Option<(u32, f32)> {
        let mut hit = RayHit::none();
        let ray = NarrowRay::new_inf(narrow(ray.origin), narrow(ray.direction));
        self.tree
            .ray_traverse(ray, &mut hit, |ray, slot| {
                self.triangles[slot].intersect(ray)
            })
            .then(|| {
                let face = self.tree.primitive_indices[hit.primitive_id as usize];
                (face, hit.t)
            })
    }
}

fn narrow(v: DVec3) -> glam::Vec3A {
    v.as_vec3a()
}
