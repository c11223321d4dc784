//! Stage `view`: what the light sees, in the precision of its buffers.

use glam::{DVec2, DVec3};

use super::loss::Loss;
use super::variants::{BackFaces, Mode};
use crate::approximation::{LightView, Precision};
use crate::geometry::{Hit, Ray, Shape, SurfaceElement, SurfacePoint, TraversalCounters};
use crate::scene::{Material, Scene};

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

/// A back face of a specular object, in a pixel.
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

/// True if a refractor has no back side that its light would leave by: a rectangle, a disc, or a mesh with a
/// border.
pub fn is_open(shape: &Shape) -> bool {
    match shape {
        Shape::Rectangle(_) | Shape::Disk(_) => true,
        Shape::Sphere(_) | Shape::Cylinder(_) => false,
        Shape::Mesh(mesh) => !mesh.diagnose().is_closed(),
    }
}

/// A specular object, where a ray of the light first meets it; `Ok(None)` where it meets anything else, or
/// nothing. `found` is what it meets first, and the ray to that.
///
/// # Errors
///
/// Where light would enter a closed refractor by its back, and where the buffer cannot hold the place.
#[inline]
pub fn front(
    scene: &Scene,
    found: Option<(Ray, Hit)>,
    mode: Mode,
    precision: Precision,
) -> Result<Option<Front>, Loss> {
    let Some((ray, hit)) = found else {
        return Ok(None);
    };
    if !takes_part(scene, scene.material_of(hit.shape), mode) {
        return Ok(None);
    }
    let point = scene.world().bounce_point(&ray, &hit);
    let is_back = ray.direction.dot(point.geometric_normal) >= 0.0;
    if is_back && mode == Mode::Refraction {
        return Err(Loss::EntersBehind);
    }
    let point = precision.of_point(point).ok_or(Loss::TooLarge)?;
    Ok(Some(Front { ray, hit, point }))
}

/// Whether a point is inside a closed surface: from there a ray that meets it does so from behind, whichever
/// ray.
pub fn is_inside(scene: &Scene, shape: u32, point: DVec3) -> bool {
    let element = SurfaceElement { shape, face: None };
    let surface = &scene.world().shapes()[shape as usize];
    if is_open(surface) {
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

/// The nearest or farthest back face along a light's ray, of the object whose front it met, as the buffers
/// hold it.
pub fn back(
    scene: &Scene,
    view: &LightView,
    front: &Front,
    (which, precision): (BackFaces, Precision),
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
            let stored = precision.of_depth(depth, view) / depth;
            found = Some(Back {
                distance: point.position.distance(start) * stored,
                normal: precision.of_vector(point.shading_normal).normalize(),
                curvature: mean_curvature(scene, &hit, &point),
                shape: hit.shape,
            });
            if which == BackFaces::Nearest {
                break;
            }
        }
        ray = point.spawn(ray.direction);
    }
    found
}

/// The picture of back faces.
#[derive(Clone, Debug, Default)]
pub struct Backs {
    /// By pixel, row by row; empty where nothing reads it.
    pub pixels: Vec<Option<Back>>,
    /// Where in its pixel each is, as a shift from the middle: that of the photons.
    pub shift: DVec2,
}

impl Backs {
    /// The back face of a shape in the pixel of an image point.
    #[inline]
    pub fn at(&self, view: &LightView, at: DVec2, shape: u32) -> Option<&Back> {
        let pixel = at - self.shift;
        let index = || pixel.y as usize * view.side() + pixel.x as usize;
        let found = view
            .holds(pixel)
            .then(|| self.pixels.get(index()))
            .flatten();
        found?.as_ref().filter(|back| back.shape == shape)
    }
}

/// Mean curvature [1/m] with the normal outward, positive where convex: half the trace of how the normal
/// turns.
pub fn mean_curvature(scene: &Scene, hit: &Hit, point: &SurfacePoint) -> f64 {
    let (s, t) = point.geometric_normal.any_orthonormal_pair();
    let turn = |along: DVec3| along.dot(scene.world().normal_derivative(hit, along));
    0.5 * (turn(s) + turn(t))
}
