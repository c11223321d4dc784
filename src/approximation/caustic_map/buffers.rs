//! Stage `view`: what the light sees, in the precision of its buffers.

use glam::{DVec2, DVec3};
use half::f16;
use rayon::prelude::*;

use super::settings::{Buffers, Mode};
use super::view::LightView;
use crate::approximation::Work;
use crate::geometry::{Element, Hit, Ray, Shape, SurfacePoint, TraversalCounters, World};
use crate::scene::{Material, Scene};
use crate::transport::path_end::next_hit;

/// A pixel of the photon buffer: where the light's ray meets a specular object.
#[derive(Clone, Copy, Debug)]
pub struct Front {
    /// From the light.
    pub ray: Ray,
    /// What it meets.
    pub hit: Hit,
    /// The surface there, as the buffers hold it.
    pub point: SurfacePoint,
}

/// The farthest back face of a specular object, in a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Back {
    /// How far behind the light, along the pixel's ray.
    pub distance: f64,
    /// The outward unit normal.
    pub normal: DVec3,
    /// Mean curvature [1/m].
    pub curvature: f64,
    /// The shape.
    pub shape: u32,
}

/// Whether photons of a mode start at a material.
pub fn takes_part(scene: &Scene, material: &Material, mode: Mode) -> bool {
    match material {
        Material::Dielectric { .. } | Material::ThinDielectric { .. } => true,
        Material::Conductor { .. } => mode == Mode::Reflection,
        Material::Mask { .. } | Material::TwoSided { .. } => material
            .nested()
            .any(|id| takes_part(scene, scene.material(id), mode)),
        _ => false,
    }
}

/// The place where a ray of the light first meets a specular object; `None` where something hides it, and where light would
/// enter a refractor by its back.
#[inline]
pub fn front(
    scene: &Scene,
    ray: Ray,
    mode: Mode,
    buffers: Buffers,
    counters: &mut TraversalCounters,
) -> Option<Front> {
    let (ray, hit) = next_hit(scene, ray, counters)?;
    if !takes_part(scene, scene.material_of(hit.shape), mode) {
        return None;
    }
    let point = scene.world().bounce_point(&ray, &hit);
    let is_back = ray.direction.dot(point.geometric_normal) >= 0.0;
    if is_back && mode == Mode::Refraction {
        return None;
    }
    let point = store(point, buffers)?;
    Some(Front { ray, hit, point })
}

/// Whether a point is inside a closed surface: from there a ray that meets it does so from behind, whichever ray.
pub fn is_inside(scene: &Scene, shape: u32, point: DVec3) -> bool {
    let element = Element { shape, face: None };
    let surface = &scene.world().shapes()[shape as usize];
    if matches!(surface, Shape::Rectangle(_) | Shape::Disk(_)) {
        return false;
    }
    let towards = (surface.bounds().center() - point)
        .try_normalize()
        .unwrap_or(DVec3::X);
    let ray = Ray::new(point, towards);
    let found = scene
        .world()
        .meet_element(&ray, element, &mut TraversalCounters::default());
    found.is_some_and(|(_, met)| towards.dot(met.geometric_normal) > 0.0)
}

/// The farthest back face along a light's ray, of the object whose front it met, as the buffers hold it.
pub fn back(
    scene: &Scene,
    view: &LightView,
    front: &Front,
    buffers: Buffers,
    counters: &mut TraversalCounters,
) -> Option<Back> {
    /// Faces of one object along one ray: a closed surface has an even number of them.
    const MOST: usize = 256;
    let world = scene.world();
    let start = front.ray.origin;
    let mut ray = front.point.spawn(front.ray.direction);
    let mut found = None;
    for _ in 0..MOST {
        let Some(hit) = world.closest_hit(&ray, f64::INFINITY, counters) else {
            break;
        };
        let point = world.bounce_point(&ray, &hit);
        if hit.shape == front.hit.shape && ray.direction.dot(point.geometric_normal) > 0.0 {
            let depth = view.project(point.position)?.depth;
            // Along one ray distances are as depths are.
            let stored = quantised(depth, view, buffers) / depth;
            found = Some(Back {
                distance: point.position.distance(start) * stored,
                normal: rounded(point.shading_normal, buffers).normalize(),
                curvature: mean_curvature(scene, &hit, &point),
                shape: hit.shape,
            });
        }
        ray = point.spawn(ray.direction);
    }
    found
}

/// Mean curvature [1/m] with the normal outward, positive where convex: half the trace of how the normal turns.
pub fn mean_curvature(scene: &Scene, hit: &Hit, point: &SurfacePoint) -> f64 {
    let (s, t) = point.geometric_normal.any_orthonormal_pair();
    let turn = |along: DVec3| along.dot(scene.world().normal_derivative(hit, along));
    0.5 * (turn(s) + turn(t))
}

/// What is left of a vector in a buffer.
fn rounded(v: DVec3, buffers: Buffers) -> DVec3 {
    match buffers {
        Buffers::Exact => v,
        Buffers::F32 => v.map(|x| f64::from(x as f32)),
        Buffers::F16 => v.map(|x| f16::from_f64(x).to_f64()),
    }
}

/// What is left of a surface point in a buffer. The error of its position grows, so that rays leave the surface from
/// where it is stored. `None` where it lies beyond what the buffer's numbers reach: 65504 of half floats.
pub fn store(mut point: SurfacePoint, buffers: Buffers) -> Option<SurfacePoint> {
    let unit = match buffers {
        Buffers::Exact => return Some(point),
        Buffers::F32 => f64::from(f32::EPSILON),
        Buffers::F16 => f16::EPSILON.to_f64(),
    };
    let stored = rounded(point.position, buffers);
    // Half a unit in the last place, and half of the smallest half float.
    point.position_error += stored.abs() * (0.5 * unit) + 3e-8;
    point.position = stored;
    point.geometric_normal = rounded(point.geometric_normal, buffers).normalize();
    point.shading_normal = rounded(point.shading_normal, buffers).normalize();
    stored.is_finite().then_some(point)
}

/// The receivers by themselves: every surface that is neither specular nor passed as if it were not there.
#[derive(Debug)]
pub struct Receivers {
    world: World,
    /// Which shape of the scene each is.
    shapes: Vec<u32>,
}

impl Receivers {
    /// Those of a scene.
    pub fn new(scene: &Scene) -> Self {
        let all = scene.world().shapes();
        let receives = |shape: &u32| {
            let material = scene.material_of(*shape);
            !material.is_specular(scene.materials()) && !material.is_passed(scene.materials())
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

    /// Whether one of them may hide a part of another, or of itself, from a light.
    pub fn may_hide(&self) -> bool {
        !matches!(self.world.shapes(), [Shape::Rectangle(_) | Shape::Disk(_)])
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

/// The nearest receiver in each pixel: its depth, or infinity.
#[derive(Clone, Debug)]
pub struct DepthMap {
    view: LightView,
    depths: Vec<f64>,
}

impl DepthMap {
    /// Depths of receivers at pixel centres, as if nothing specular were there.
    pub fn new(receivers: &Receivers, view: LightView, buffers: Buffers) -> (Self, Work) {
        let side = view.side();
        let mut depths = vec![f64::INFINITY; side * side];
        let counters = depths
            .par_chunks_mut(side)
            .enumerate()
            .map(|(row, depths)| {
                let mut counters = TraversalCounters::default();
                for (column, depth) in depths.iter_mut().enumerate() {
                    let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                    let found = receivers.first(&view.ray(at), &mut counters);
                    if let Some(seen) = found.and_then(|(_, point)| view.project(point.position)) {
                        *depth = quantised(seen.depth, &view, buffers);
                    }
                }
                counters
            })
            .reduce(TraversalCounters::default, |mut a, b| {
                a += b;
                a
            });
        let mut work = Work {
            bytes: (side * side * 4) as u64,
            ..Work::default()
        };
        work.add_rays(counters);
        (Self { view, depths }, work)
    }

    /// The view that it is of.
    pub fn view(&self) -> &LightView {
        &self.view
    }

    /// The depth in the pixel of an image point; `None` outside.
    #[inline]
    pub fn at(&self, at: DVec2) -> Option<f64> {
        let side = self.view.side();
        self.view
            .holds(at)
            .then(|| self.depths[at.y as usize * side + at.x as usize])
    }
}

/// A depth as a 24-bit depth buffer holds it: evenly in 1/depth between the nearest and the farthest, of parallel light in
/// depth itself.
fn quantised(depth: f64, view: &LightView, buffers: Buffers) -> f64 {
    const STEPS: f64 = 16_777_215.0;
    if buffers == Buffers::Exact {
        return depth;
    }
    let stored = |place: f64| (place.clamp(0.0, 1.0) * STEPS).round() / STEPS;
    let [near, far] = view.range();
    if view.is_parallel() {
        return near + stored((depth - near) / (far - near)) * (far - near);
    }
    let (a, b) = (1.0 / near, 1.0 / far);
    1.0 / (a - stored((a - 1.0 / depth) / (a - b)) * (a - b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored(x: f64, buffers: Buffers) -> Option<SurfacePoint> {
        let point = SurfacePoint {
            position: DVec3::splat(x),
            position_error: DVec3::ZERO,
            geometric_normal: DVec3::Z,
            shading_normal: DVec3::Z,
            uv: DVec2::ZERO,
        };
        store(point, buffers)
    }

    #[test]
    fn what_is_stored_is_within_the_error_that_is_told() {
        for buffers in [Buffers::Exact, Buffers::F32, Buffers::F16] {
            for x in [0.0, 1e-7, 0.1, -3.3, 60_000.0] {
                let point = stored(x, buffers).unwrap();
                let off = (point.position - DVec3::splat(x)).abs();
                assert!(
                    off.cmple(point.position_error).all(),
                    "{buffers:?} {x}: {off}"
                );
            }
        }
    }

    #[test]
    fn what_is_beyond_half_floats_is_not_stored() {
        assert!(stored(7e4, Buffers::F16).is_none());
        assert!(stored(7e4, Buffers::F32).is_some());
        assert!(stored(1e39, Buffers::F32).is_none());
    }
}
