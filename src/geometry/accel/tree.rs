//! A tree over boxes.

use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ray::{Ray as NarrowRay, RayHit},
};

use crate::geometry::{Bounds, Ray, rounding::gamma};

/// A tree over boxes, in `f32`, that never loses a candidate.
pub(in crate::geometry) struct BoxTree {
    bounds: Bounds,
    center: DVec3,
    tree: Bvh2,
}

/// A ray as seen by one tree.
pub(in crate::geometry) struct LocalRay {
    narrow: NarrowRay,
    /// How far along the ray its narrow copy starts.
    start: f64,
}

impl BoxTree {
    pub(in crate::geometry) fn new(boxes: &[Bounds]) -> Self {
        let bounds = boxes.iter().fold(Bounds::EMPTY, |all, &one| all.union(one));
        let center = bounds.center();
        let half = (0.5 * bounds.extent()).max_element();
        let pad = half * 2f64.powi(-19);
        let narrow: Vec<Aabb> = boxes
            .iter()
            .map(|bounds| {
                Aabb::new(
                    round_down(bounds.min - center - DVec3::splat(pad)),
                    round_up(bounds.max - center + DVec3::splat(pad)),
                )
            })
            .collect();
        let tree = build_bvh2(
            &narrow,
            BvhBuildParams::medium_build(),
            &mut Duration::default(),
        );
        Self {
            bounds,
            center,
            tree,
        }
    }

    /// The ray in the tree's own space, unless it misses all boxes before `limit`.
    pub(in crate::geometry) fn enter(&self, ray: &Ray, limit: f64) -> Option<LocalRay> {
        let inverse = ray.direction.recip();
        let start = slab_entry(&self.bounds, ray, inverse, limit)?;
        let start = start * (1.0 - gamma(8));
        let origin = (ray.origin - self.center) + ray.direction * start;
        Some(LocalRay {
            narrow: NarrowRay::new(
                origin.as_vec3a(),
                ray.direction.as_vec3a(),
                0.0,
                narrow_limit(limit - start),
            ),
            start,
        })
    }

    /// Calls `visit(primitive)` for all boxes that the ray may enter before the limit that the
    /// last call returned.
    pub(in crate::geometry) fn traverse(&self, ray: &LocalRay, mut visit: impl FnMut(u32) -> f64) {
        let mut hit = RayHit::none();
        self.tree.ray_traverse(ray.narrow, &mut hit, |_, slot| {
            narrow_limit(visit(self.tree.primitive_indices[slot]) - ray.start)
        });
    }

    /// Whether `overlaps` holds for a box of the tree all the way down to `leaf(primitive)`.
    pub(in crate::geometry) fn any_box(
        &self,
        overlaps: &mut impl FnMut(&Bounds) -> bool,
        leaf: &mut impl FnMut(u32, &mut dyn FnMut(&Bounds) -> bool) -> bool,
    ) -> bool {
        let mut stack = vec![0u32];
        while let Some(index) = stack.pop() {
            let Some(node) = self.tree.nodes.get(index as usize) else {
                continue;
            };
            let world = Bounds {
                min: node.aabb.min.as_dvec3() + self.center,
                max: node.aabb.max.as_dvec3() + self.center,
            };
            if !overlaps(&world) {
                continue;
            }
            if node.is_leaf() {
                for slot in node.first_index..node.first_index + node.prim_count {
                    if leaf(self.tree.primitive_indices[slot as usize], overlaps) {
                        return true;
                    }
                }
            } else {
                stack.push(node.first_index);
                stack.push(node.first_index + 1);
            }
        }
        false
    }

    pub(in crate::geometry) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.tree.nodes) + size_of_val(&*self.tree.primitive_indices)
    }
}

/// Where the ray enters the box (0 if it starts inside), if it does before `limit`.
#[inline]
pub(in crate::geometry) fn slab_entry(
    bounds: &Bounds,
    ray: &Ray,
    inverse: DVec3,
    limit: f64,
) -> Option<f64> {
    let a = (bounds.min - ray.origin) * inverse;
    let b = (bounds.max - ray.origin) * inverse;
    let entry = a.min(b).max_element().max(0.0);
    let exit = a.max(b).min_element();
    (entry * (1.0 - gamma(4)) <= exit * (1.0 + gamma(4)) && entry * (1.0 - gamma(4)) <= limit)
        .then_some(entry)
}

/// The `f32` just above.
fn narrow_limit(limit: f64) -> f32 {
    (limit as f32).next_up()
}

fn round_down(v: DVec3) -> Vec3A {
    Vec3A::new(
        (v.x as f32).next_down(),
        (v.y as f32).next_down(),
        (v.z as f32).next_down(),
    )
}

fn round_up(v: DVec3) -> Vec3A {
    Vec3A::new(
        (v.x as f32).next_up(),
        (v.y as f32).next_up(),
        (v.z as f32).next_up(),
    )
}
