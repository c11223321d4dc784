//! All shapes of a scene, and the search among them. (Contract; bodies being built.)

use super::{Bounds, Hit, Ray, Shape, SurfacePoint};

/// Work done while searching.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraversalCounters {
    /// Rays searched for.
    pub rays: u64,
    /// Box tests: nodes of the tree visited.
    pub node_visits: u64,
    /// Exact intersection tests.
    pub primitive_tests: u64,
}

/// All shapes of a scene, and a tree over their primitives.
#[derive(Debug)]
pub struct World;

impl World {
    /// Builds the tree.
    pub fn new(_shapes: Vec<Shape>) -> Self {
        todo!()
    }
    /// The shapes, in the order given.
    pub fn shapes(&self) -> &[Shape] {
        todo!()
    }
    /// The box round everything.
    pub fn bounds(&self) -> Bounds {
        todo!()
    }
    /// The nearest hit nearer than `max_distance` (exclusive).
    pub fn closest_hit(
        &self,
        _ray: &Ray,
        _max_distance: f64,
        _counters: &mut TraversalCounters,
    ) -> Option<Hit> {
        todo!()
    }
    /// Whether any hit nearer than `max_distance` satisfies `blocks`, in no particular order.
    pub fn any_hit(
        &self,
        _ray: &Ray,
        _max_distance: f64,
        _blocks: impl FnMut(&Hit) -> bool,
        _counters: &mut TraversalCounters,
    ) -> bool {
        todo!()
    }
    /// Everything about a hit.
    pub fn surface_point(&self, _ray: &Ray, _hit: &Hit) -> SurfacePoint {
        todo!()
    }
    /// Whether `overlaps` may hold for a primitive of the chosen shapes: descends the tree while
    /// `overlaps(box)` is true; at a leaf asks `overlaps` of each chosen primitive's own box.
    pub fn any_primitive_box(
        &self,
        _choose: impl Fn(u32) -> bool,
        _overlaps: impl FnMut(&Bounds) -> bool,
    ) -> bool {
        todo!()
    }
}
