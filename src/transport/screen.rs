//! The sensor at the end of a light path: texels or pixels for a photon, film coordinates for the end of a
//! path of fixed signature.

use glam::{DVec2, DVec3};

use super::camera::Camera;
use super::chain::Arrival;
use super::path_end::{End, next_hit};
use super::receiver::Receiver;
use crate::geometry::{Hit, Hull, Ray, Shape, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::Scene;

/// A sensor as light meets it.
#[derive(Clone, Copy, Debug)]
pub enum Screen<'a> {
    /// An irradiance meter: it sums up flux itself.
    Receiver(&'a Receiver),
    /// A camera that looks at diffuse surfaces.
    Camera {
        /// The camera.
        camera: &'a Camera,
        /// The étendue [m² sr] by which flux counts: the film sums up the radiance [W/m²/sr] of a pixel times
        /// it. With that of a typical pixel, film sums are about flux \[W\], as for a receiver.
        etendue: f64,
    },
}

impl Screen<'_> {
    /// Columns and rows of the film.
    pub fn size(&self) -> [usize; 2] {
        match self {
            Self::Receiver(receiver) => [receiver.width(), receiver.height()],
            Self::Camera { camera, .. } => [camera.width(), camera.height()],
        }
    }

    /// True if film coordinates are on the film, not beside it.
    #[inline]
    pub fn is_on_film(&self, at: DVec2) -> bool {
        let [width, height] = self.size();
        let end = DVec2::new(width as f64, height as f64);
        at.cmpge(DVec2::ZERO).all() && at.cmple(end).all()
    }

    /// Some points that the sensor measures, spread over its film: nine, less those at which it has no
    /// surface.
    pub fn points(&self, scene: &Scene) -> Vec<DVec3> {
        const PARTS: [f64; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];
        let size = self.size();
        let film = DVec2::new(size[0] as f64, size[1] as f64);
        let places = PARTS
            .iter()
            .flat_map(|&y| PARTS.map(|x| film * DVec2::new(x, y)));
        let mut counters = TraversalCounters::default();
        places
            .filter_map(|at| match self {
                Self::Receiver(receiver) => {
                    let texel = at.floor();
                    let index = texel.y as usize * size[0] + texel.x as usize;
                    Some(receiver.point(scene, index, at - texel)?.position)
                }
                Self::Camera { camera, .. } => {
                    let view = camera.pixel_ray(at);
                    let (ray, hit) = next_hit(scene, view.ray, &mut counters)?;
                    let is_seen = camera.may_see_surface(scene, hit.shape);
                    is_seen.then(|| ray.at(hit.distance))
                }
            })
            .collect()
    }

    /// The texel or pixel that counts light arriving at a surface, and the factor from its flux \[W\] to the
    /// sum on the film. `None` if no texel does.
    ///
    /// A camera sees the light that diffuse surfaces reflect. A receiver counts the light that falls on its
    /// front, on any material.
    #[inline]
    pub fn texel<const N: usize>(
        &self,
        scene: &Scene,
        arrival: &Arrival<N>,
        counters: &mut TraversalCounters,
    ) -> Option<(usize, Rgb)> {
        match self {
            Self::Receiver(receiver) => {
                let Arrival {
                    ray, hit, point, ..
                } = *arrival;
                if hit.shape != receiver.shape() {
                    return None;
                }
                let point = scene.world().with_uv(*point, hit);
                let texel = receiver.texel(&point, ray.direction)?;
                Some((texel, Rgb::WHITE))
            }
            Self::Camera { camera, .. } => {
                let is_on_film = |at| camera.pixel(at).is_some();
                let (at, factor) = self.seen(scene, arrival, is_on_film, counters)?;
                Some((camera.pixel(at)?, factor))
            }
        }
    }

    /// The film coordinates at which a camera sees light arriving at a surface, and the factor from its flux
    /// \[W\] to the sum on the film of a pixel that counts it whole. `None` if it sees nothing of the light,
    /// if the coordinates are not wanted, and for a receiver.
    #[inline]
    pub fn seen<const N: usize>(
        &self,
        scene: &Scene,
        arrival: &Arrival<N>,
        is_wanted: impl FnOnce(DVec2) -> bool,
        counters: &mut TraversalCounters,
    ) -> Option<(DVec2, Rgb)> {
        let Self::Camera { camera, etendue } = self else {
            return None;
        };
        let Arrival {
            ray, hit, point, ..
        } = *arrival;
        let seen = camera.connect_where(scene, hit, point, ray.direction, is_wanted, counters)?;
        Some((seen.at, seen.radiance_per_flux * *etendue))
    }

    /// The end of a path whose last leg is `ray`, which met `hit` or nothing at all.
    ///
    /// The other results are the factor from its flux to the sum on the film, and a mark of the surface on
    /// which it ended.
    #[inline]
    pub fn end(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<&Hit>,
        counters: &mut TraversalCounters,
    ) -> (End, Rgb, u64) {
        match self {
            Self::Receiver(receiver) => on_receiver(receiver, scene, ray, hit),
            Self::Camera { camera, etendue } => {
                let Some(hit) = hit else {
                    return (End::Escaped, Rgb::BLACK, 0);
                };
                match on_camera(camera, scene, ray, hit, counters) {
                    Some((at, factor)) => (
                        End::Landed(at),
                        factor * *etendue,
                        seen_surface(scene, ray, hit),
                    ),
                    None => (End::Stopped, Rgb::BLACK, 0),
                }
            }
        }
    }

    /// Planes a little beside what is seen, each a point of it and its outward normal: none for a receiver.
    pub fn planes_beside_view(&self) -> Vec<[DVec3; 2]> {
        match self {
            Self::Receiver(_) => Vec::new(),
            Self::Camera { camera, .. } => camera.planes_beside_view().to_vec(),
        }
    }

    /// True if a camera sees nothing in a bundle of segments, with any hit: all of it is before the near
    /// plane, or beyond the same side of the film. For a receiver, the shape of a hit decides instead.
    pub fn sees_nothing_of(&self, bundle: &Hull) -> bool {
        self.is_beyond_a_side(|normal, side| bundle.reach(normal)[0] > side)
    }

    /// True if light on a surface of `shape` may be measured at all.
    pub fn may_see(&self, scene: &Scene, shape: u32) -> bool {
        match self {
            Self::Receiver(receiver) => receiver.shape() == shape,
            Self::Camera { camera, .. } => camera.may_see_surface(scene, shape),
        }
    }

    /// True if no light lands that ends on a surface of `shape` within the convex hull of `places`. The test
    /// ignores anything else that may hide it from a camera.
    pub fn is_out_of_sight(&self, scene: &Scene, shape: u32, places: &[DVec3]) -> bool {
        let are_beyond = |normal: DVec3, side| places.iter().all(|it| normal.dot(*it) > side);
        !self.may_see(scene, shape) || self.is_beyond_a_side(are_beyond)
    }

    /// True if something is wholly on the far side of one of a camera's planes, n · p = `side`; false for
    /// NaN.
    fn is_beyond_a_side(&self, is_beyond: impl Fn(DVec3, f64) -> bool) -> bool {
        match self {
            Self::Receiver(_) => false,
            Self::Camera { camera, .. } => camera
                .planes()
                .iter()
                .any(|[point, normal]| is_beyond(*normal, normal.dot(*point))),
        }
    }
}

/// The end of a path on a receiver.
///
/// The plane of a rectangle or disc goes on beyond its border if nothing else is in the way. Then the border
/// needs no attention: the film's edge cuts the light that lands there.
#[inline]
fn on_receiver(
    receiver: &Receiver,
    scene: &Scene,
    ray: &Ray,
    hit: Option<&Hit>,
) -> (End, Rgb, u64) {
    let shape = &scene.world().shapes()[receiver.shape() as usize];
    if let Some(hit) = hit
        && hit.shape == receiver.shape()
    {
        let point = scene.world().surface_point(ray, hit);
        return match receiver.place(&point, ray.direction) {
            Some(at) => (End::Landed(at), Rgb::WHITE, half_turn(shape, point.uv)),
            None => (End::Stopped, Rgb::BLACK, 0),
        };
    }
    if let Some([_, normal]) = shape.plane()
        && normal.dot(ray.direction) < 0.0
        && let Some((distance, uv)) = shape.meet_beyond(ray)
        && hit.is_none_or(|hit| hit.distance > distance)
    {
        let end = End::Landed(receiver.film_place(uv));
        return (end, Rgb::WHITE, half_turn(shape, uv));
    }
    match hit {
        Some(_) => (End::Stopped, Rgb::BLACK, 0),
        None => (End::Escaped, Rgb::BLACK, 0),
    }
}

/// A number for each half of a round surface's turn: film coordinates jump at the end of a turn.
#[inline]
fn half_turn(shape: &Shape, uv: DVec2) -> u64 {
    let turn = match shape {
        Shape::Disk(_) => uv.y,
        Shape::Sphere(_) | Shape::Cylinder(_) => uv.x,
        Shape::Rectangle(_) | Shape::Mesh(_) => return 0,
    };
    // The bits are clear of those that tell how a path ended.
    u64::from(turn < 0.5) << 4
}

/// The film point at which a camera sees the point that was hit, and the pixel's radiance per flux arriving
/// there.
///
/// `None` if the camera does not see it, and would not on a film three times as wide and high. Towards the
/// plane through the pinhole, film coordinates and factors grow without limit, and beams that go there are
/// dark.
#[inline]
fn on_camera(
    camera: &Camera,
    scene: &Scene,
    ray: &Ray,
    hit: &Hit,
    counters: &mut TraversalCounters,
) -> Option<(DVec2, Rgb)> {
    let point = scene.world().surface_point(ray, hit);
    let at = camera.project(point.position)?.at;
    let [low, high] = camera.near_film();
    let is_near = at.cmpge(low).all() && at.cmple(high).all();
    let seen = is_near
        .then(|| camera.connect(scene, hit, &point, ray.direction, counters))
        .flatten()?;
    Some((seen.at, seen.radiance_per_flux))
}

/// A number for the smooth surface that was hit. Its brightness to the camera jumps between flat faces, and
/// so does its reflectance between its two sides.
#[inline]
fn seen_surface(scene: &Scene, ray: &Ray, hit: &Hit) -> u64 {
    let facet = match &scene.world().shapes()[hit.shape as usize] {
        Shape::Mesh(mesh) if !mesh.has_vertex_normals() => u64::from(hit.face) + 1,
        _ => 0,
    };
    let point = scene.world().surface_point(ray, hit);
    let front = ray.direction.dot(point.geometric_normal) < 0.0;
    // The bits are clear of those that tell how a path ended.
    (u64::from(hit.shape) + 1) << 38 | facet << 4 | u64::from(front) << 3
}
