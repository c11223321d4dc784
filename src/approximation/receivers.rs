//! The receivers of a scene: its surfaces that are neither specular nor passed.

use crate::geometry::{Hit, Ray, Shape, SurfacePoint, TraversalCounters, World};
use crate::scene::Scene;

/// The receivers of a scene, by themselves: every surface that is neither specular nor passed as if it were
/// not there.
#[derive(Debug)]
pub struct Receivers {
    world: World,
    /// The shape of the scene that each is.
    shapes: Vec<u32>,
}

impl Receivers {
    /// The receivers of a scene.
    pub fn new(scene: &Scene) -> Self {
        Self::chosen(scene, |_| true)
    }

    /// Those of a scene's receivers that are chosen.
    pub fn chosen(scene: &Scene, choose: impl Fn(&Shape) -> bool) -> Self {
        let all = scene.world().shapes();
        let receives = |shape: &u32| {
            let material = scene.material_of(*shape);
            !material.is_specular(scene.materials())
                && !material.is_passed(scene.materials())
                && choose(&all[*shape as usize])
        };
        let shapes: Vec<u32> = (0..all.len() as u32).filter(receives).collect();
        let world = World::new(
            shapes
                .iter()
                .map(|&shape| all[shape as usize].clone())
                .collect(),
        );
        Self { world, shapes }
    }

    /// The shapes that they are.
    pub fn shapes(&self) -> &[Shape] {
        self.world.shapes()
    }

    /// True if one of them may hide a part of another, or of itself, from a light.
    pub fn may_hide(&self) -> bool {
        !matches!(self.world.shapes(), [Shape::Rectangle(_) | Shape::Disk(_)])
    }

    /// True if one of them is met before a distance along a ray.
    #[inline]
    pub fn hide(&self, ray: &Ray, distance: f64, counters: &mut TraversalCounters) -> bool {
        self.world.any_hit(ray, distance, |_| true, counters)
    }

    /// The first of them along a ray, whatever specular is before it.
    #[inline]
    pub fn first(
        &self,
        ray: &Ray,
        counters: &mut TraversalCounters,
    ) -> Option<(Hit, SurfacePoint)> {
        let hit = self.world.closest_hit(ray, f64::INFINITY, counters)?;
        let point = self.world.bounce_point(ray, &hit);
        let shape = self.shapes[hit.shape as usize];
        Some((Hit { shape, ..hit }, point))
    }
}
