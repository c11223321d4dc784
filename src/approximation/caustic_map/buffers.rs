//! Stage `view`: what the light sees, in the precision of its buffers.

use glam::{DVec2, DVec3};
use half::f16;
use rayon::prelude::*;

use super::settings::{Buffers, Mode};
use super::view::LightView;
use crate::approximation::Work;
use crate::geometry::{Hit, Ray, SurfacePoint, TraversalCounters};
use crate::scene::{Material, Scene};
use crate::transport::prescribed::next_hit;

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

/// Why a light's ray makes no photon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFront {
    /// It meets nothing specular first.
    Elsewhere,
    /// It meets a specular object's surface from inside.
    Inside(u32),
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

/// The place where a ray of the light first meets a specular object, unless something hides it.
#[inline]
pub fn front(
    scene: &Scene,
    ray: Ray,
    mode: Mode,
    buffers: Buffers,
    counters: &mut TraversalCounters,
) -> Result<Front, NoFront> {
    let (ray, hit) = next_hit(scene, ray, counters).ok_or(NoFront::Elsewhere)?;
    if !takes_part(scene, scene.material_of(hit.shape), mode) {
        return Err(NoFront::Elsewhere);
    }
    let mut point = scene.world().bounce_point(&ray, &hit);
    let is_back = ray.direction.dot(point.geometric_normal) >= 0.0;
    if is_back && mode == Mode::Refraction {
        return Err(NoFront::Inside(hit.shape));
    }
    store(&mut point, buffers);
    Ok(Front { ray, hit, point })
}

/// The farthest back face along a light's ray, of the object whose front it met.
pub fn back(scene: &Scene, front: &Front, counters: &mut TraversalCounters) -> Option<Back> {
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
            found = Some(Back {
                distance: point.position.distance(start),
                normal: point.shading_normal,
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

/// What is left of a surface point in a buffer. The error of its position grows, so that rays leave the surface from
/// where it is stored.
pub fn store(point: &mut SurfacePoint, buffers: Buffers) {
    let (round, unit): (fn(f64) -> f64, f64) = match buffers {
        Buffers::Exact => return,
        Buffers::F32 => (|x| f64::from(x as f32), f64::from(f32::EPSILON)),
        Buffers::F16 => (|x| f16::from_f64(x).to_f64(), f16::EPSILON.to_f64()),
    };
    let each = |v: DVec3| DVec3::new(round(v.x), round(v.y), round(v.z));
    let stored = each(point.position);
    // Half a unit in the last place, and half of the smallest half float.
    point.position_error += stored.abs() * (0.5 * unit) + 3e-8;
    point.position = stored;
    point.geometric_normal = each(point.geometric_normal).normalize();
    point.shading_normal = each(point.shading_normal).normalize();
}

/// The nearest receiver in each pixel: its depth, or infinity.
#[derive(Clone, Debug)]
pub struct DepthMap {
    view: LightView,
    depths: Vec<f64>,
}

impl DepthMap {
    /// Depths of what is not specular, at pixel centres, seen through everything that is.
    pub fn new(scene: &Scene, view: LightView, buffers: Buffers) -> (Self, Work) {
        let side = view.side();
        let rows: Vec<(Vec<f64>, TraversalCounters)> = (0..side)
            .into_par_iter()
            .map(|row| {
                let mut counters = TraversalCounters::default();
                let depths = (0..side)
                    .map(|column| {
                        let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                        let depth = receiver_behind(scene, view.ray(at), &mut counters)
                            .and_then(|(_, _, point)| view.project(point.position))
                            .map_or(f64::INFINITY, |seen| seen.depth);
                        quantised(depth, view.range(), buffers)
                    })
                    .collect();
                (depths, counters)
            })
            .collect();
        let mut work = Work {
            bytes: (side * side * 4) as u64,
            ..Work::default()
        };
        let mut depths = Vec::with_capacity(side * side);
        for (row, counters) in rows {
            depths.extend(row);
            work.add_rays(counters);
        }
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

/// The first surface along a ray that is not specular, whatever specular is before it.
pub fn receiver_behind(
    scene: &Scene,
    mut ray: Ray,
    counters: &mut TraversalCounters,
) -> Option<(Ray, Hit, SurfacePoint)> {
    /// Specular faces before a receiver.
    const MOST: usize = 1024;
    for _ in 0..MOST {
        let (here, hit) = next_hit(scene, ray, counters)?;
        let point = scene.world().bounce_point(&here, &hit);
        let material = scene.material_of(hit.shape);
        if !material.is_specular(scene.materials()) {
            return Some((here, hit, point));
        }
        ray = point.spawn(here.direction);
    }
    None
}

/// A depth as a 24-bit depth buffer between `near` and `far` holds it: evenly in 1/depth.
fn quantised(depth: f64, [near, far]: [f64; 2], buffers: Buffers) -> f64 {
    const STEPS: f64 = 16_777_215.0;
    if buffers == Buffers::Exact || !depth.is_finite() {
        return depth;
    }
    let (a, b) = (1.0 / near, 1.0 / far);
    let place = ((a - 1.0 / depth) / (a - b)).clamp(0.0, 1.0);
    let stored = (place * STEPS).round() / STEPS;
    1.0 / (a - stored * (a - b))
}
