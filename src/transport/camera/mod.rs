//! Cameras: which point of the film light that arrives at a surface is seen at, and how brightly.
//!
//! A pixel of a box-filtered film holds the average radiance over the pixel, L = 1/A ∫ L(x) dx. Seen
//! from the surface the same is an integral over the pixel's footprint. With camera space
//! coordinates q = (x, y, 1) of a film point on the plane z = 1, M the linear part of the
//! camera's map to the world, and d the distance, the footprint's area is
//!
//! ```text
//! dA cos θ / d² = dω = |det M| / |M q|³ dx dy
//! ```
//!
//! (for a rigid M: dx dy cos³ of the angle to the axis). Flux Φ that arrives at a point of a Lambertian
//! surface leaves it with radiance ρ/π Φ/dA, so a pixel of area A on the plane z = 1 gains
//!
//! ```text
//! L = Φ · ρ/π · cos θ |M q|³ / (d² |det M| A)
//! ```
//!
//! This is the measurement contribution of Veach 1997 (*Robust Monte Carlo methods for light
//! transport simulation*), chapter 8: the BRDF times the geometric term times the pixel's importance We;
//! and We that of Pharr, Jakob and Humphreys, *Physically Based Rendering*, 3rd edition, 16.1.1, for one
//! pixel instead of the film. For parallel projection along the unit vector a, areas across a take
//! the place of solid angles: with X and Y the first columns of M,
//!
//! ```text
//! dA cos θ = |a · (X × Y)| dx dy
//! ```
//!
//! Through a thin lens a pixel's radiance is also the average over the lens. For each of its points the
//! equations are those of a pinhole there, whose film is shifted so that the plane in focus stays where it is.

mod diffuse;
mod error;
mod lens;

use glam::{DVec2, DVec3};

use super::scatter::ShadingNormals;
use super::visibility::transmittance;
use crate::geometry::{Ray, SurfacePoint, Transform, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::{Film, ReconstructionFilter, Scene, Sensor, SensorKind};
use diffuse::{has_unknown_reflectance, reflectance};
pub use error::CameraError;
use lens::Lens;

/// A camera: a film on which points of the scene are seen.
///
/// The film's coordinates are in pixels of its crop: x to the right, y down, the top left corner of the
/// crop at (0, 0). Mitsuba's conventions (checked against 3.9.1, see `tests/paths/camera/`): camera space
/// has +x to the *left* of the image, +y up, and looks along +z; a principal point's offset moves the
/// image left and up.
#[derive(Clone, Debug)]
pub struct Camera {
    film: Film,
    to_world: Transform,
    lens: Lens,
    near_clip: f64,
    far_clip: f64,
    /// The film point, in pixels of the crop, on the camera's axis.
    center: DVec2,
    /// Pixels a unit of camera space (on the plane z = 1, for a pinhole); the same along x and y.
    pixels: f64,
    shading_normals: ShadingNormals,
    /// Round what is near the film: see [`planes`](Self::planes).
    planes: [[DVec3; 2]; 5],
}

/// How a camera sees a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// In pixels of the cropped film, continuous; may lie outside of it.
    pub at: DVec2,
    /// From the point to the camera, a unit vector.
    pub towards: DVec3,
    /// From the point to the near plane, along `towards`.
    pub distance: f64,
    /// Radiance [W/m²/sr] averaged over a pixel, by radiance times surface area times cosine
    /// [W/sr] there: the pixel's importance times the geometric term [1/m²].
    pub importance: f64,
}

/// What a camera makes of flux that arrives at a point it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connection {
    /// In pixels of the cropped film, continuous; may lie outside of it.
    pub at: DVec2,
    /// Radiance of the pixel [W/m²/sr] by flux arriving at the point \[W\].
    pub radiance_per_flux: Rgb,
    /// From the point to the near plane (what lies between was found clear).
    pub distance: f64,
}

/// A camera's view through a point of its film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelRay {
    /// From the near plane on.
    pub ray: Ray,
    /// The distance to the far plane: what lies beyond is not seen.
    pub reach: f64,
}

impl Camera {
    /// The camera that a sensor describes, for light that is connected to it from Lambertian surfaces of known
    /// reflectance, pixel by pixel; with shading normals that keep [`ShadingNormals::Flux`].
    ///
    /// # Errors
    ///
    /// For an irradiance meter or a thin lens, a filter other than the box, or where a diffuse surface
    /// of the scene has a reflectance that is not a constant colour.
    pub fn new(scene: &Scene, sensor: &Sensor) -> Result<Self, CameraError> {
        let id = || sensor.id.clone();
        let is_refused = matches!(
            sensor.kind,
            SensorKind::ThinLens { .. } | SensorKind::IrradianceMeter { .. }
        );
        if is_refused {
            return Err(CameraError::Kind {
                id: id(),
                plugin: sensor.plugin(),
            });
        }
        let camera = Self::of_sensor(sensor)?;
        let filter = camera.film.filter;
        if filter != ReconstructionFilter::Box {
            return Err(CameraError::Filter {
                id: id(),
                filter: filter.plugin(),
            });
        }
        let is_unknown = |object: &&crate::scene::Object| {
            has_unknown_reflectance(scene, scene.material(object.material))
        };
        match scene.objects().iter().find(is_unknown) {
            None => Ok(camera),
            Some(object) => Err(CameraError::Reflectance {
                id: id(),
                shape: object.id.clone(),
            }),
        }
    }

    /// The camera that a sensor describes, of any kind, with any filter and before any scene: for methods that
    /// ask each surface's [`Bsdf`](super::bsdf::Bsdf) what it scatters.
    ///
    /// # Errors
    ///
    /// For an irradiance meter, and where pixels or film coordinates overflow.
    pub fn of_sensor(sensor: &Sensor) -> Result<Self, CameraError> {
        let id = || sensor.id.clone();
        let film = &sensor.film;
        let (to_world, near_clip, far_clip, half_width, offset) = match &sensor.kind {
            SensorKind::Perspective(camera) | SensorKind::ThinLens { camera, .. } => (
                camera.to_world,
                camera.near_clip,
                camera.far_clip,
                (0.5 * camera.horizontal_fov).tan(),
                camera.principal_point_offset,
            ),
            SensorKind::Orthographic {
                to_world,
                near_clip,
                far_clip,
            } => (*to_world, *near_clip, *far_clip, 1.0, DVec2::ZERO),
            SensorKind::IrradianceMeter { .. } => {
                return Err(CameraError::NoCamera { id: id() });
            }
        };
        let full = DVec2::new(f64::from(film.width), f64::from(film.height));
        let crop = DVec2::new(f64::from(film.crop.offset_x), f64::from(film.crop.offset_y));
        let mut camera = Self {
            film: film.clone(),
            to_world,
            lens: Lens::new(&sensor.kind, &to_world),
            near_clip,
            far_clip,
            center: (0.5 - offset) * full - crop,
            pixels: 0.5 * full.x / half_width,
            shading_normals: ShadingNormals::Flux,
            planes: [[DVec3::ZERO; 2]; 5],
        };
        for size in [1.0, camera.lens.scale()].map(|scale| scale / camera.pixels) {
            if !(1e-70..=1e70).contains(&size) || !camera.center.is_finite() {
                return Err(CameraError::Size { id: id(), size });
            }
        }
        camera.planes = camera.planes_round(camera.near_film());
        Ok(camera)
    }

    /// The same camera, with what interpolated normals of diffuse surfaces do to light.
    ///
    /// With `Flux` a surface reflects what its true normal receives; with `Adjoint` its radiance is
    /// that of a surface with the shading normal s, as in Mitsuba's images: flux from w counts
    /// |w · s| / |w · g| times, g the true normal (Veach 1997, 5.3), and nothing where the two
    /// disagree about sides.
    #[must_use]
    pub fn with_shading_normals(mut self, shading_normals: ShadingNormals) -> Self {
        self.shading_normals = shading_normals;
        self
    }

    /// Pixels a row, of the crop.
    pub fn width(&self) -> usize {
        self.film.crop.width as usize
    }

    /// Rows of pixels, of the crop.
    pub fn height(&self) -> usize {
        self.film.crop.height as usize
    }

    /// The pixel at film coordinates, row by row from the top; `None` outside the crop.
    #[inline]
    pub fn pixel(&self, at: DVec2) -> Option<usize> {
        let (width, height) = (self.width(), self.height());
        let is_inside = at.x >= 0.0 && at.y >= 0.0 && at.x < width as f64 && at.y < height as f64;
        is_inside.then(|| at.y as usize * width + at.x as usize)
    }

    /// Where a point is seen, whatever lies between; `None` before the near plane and beyond the far one.
    ///
    /// Through the middle of a lens: see [`project_through`](Self::project_through).
    #[inline]
    pub fn project(&self, position: DVec3) -> Option<Projection> {
        self.project_through(position, LENS_MIDDLE)
    }

    /// Where a point is seen through the point `lens` of the lens, as in [`ray_through`](Self::ray_through).
    ///
    /// The mean of `importance` over uniform `lens` in [0, 1)² is the pixel's whole.
    #[inline]
    pub fn project_through(&self, position: DVec3, lens: DVec2) -> Option<Projection> {
        let seen = self
            .lens
            .project(&self.to_world, position, lens, self.near_clip)?;
        let pixel_area = 1.0 / (self.pixels * self.pixels);
        let at = self.center - seen.on_film * self.pixels;
        let importance = seen.importance / pixel_area;
        let is_seen = seen.depth > 0.0 && seen.depth <= self.far_clip - self.near_clip;
        (is_seen && at.is_finite() && importance.is_finite()).then_some(Projection {
            at,
            towards: seen.towards,
            distance: seen.distance,
            importance,
        })
    }

    /// What a pixel gains from flux that arrives at `point` of shape `shape`, travelling along the unit
    /// vector `direction`.
    ///
    /// `None` where nothing is seen of it: the surface is not diffuse (or a mask over it is
    /// open), light and camera are on different sides or on one that is black, the point is out of the clip
    /// planes, or something hides it. Film coordinates outside the crop are no reason: a
    /// beam's image may reach in.
    ///
    /// Mirrors and glass between point and camera hide it, too: what is seen by way of them is another path.
    pub fn connect(
        &self,
        scene: &Scene,
        shape: u32,
        point: &SurfacePoint,
        direction: DVec3,
        counters: &mut TraversalCounters,
    ) -> Option<Connection> {
        self.connect_through(scene, shape, point, direction, LENS_MIDDLE, counters)
    }

    /// As [`connect`](Self::connect), through a point of the lens: see [`project_through`](Self::project_through).
    pub fn connect_through(
        &self,
        scene: &Scene,
        shape: u32,
        point: &SurfacePoint,
        direction: DVec3,
        lens: DVec2,
        counters: &mut TraversalCounters,
    ) -> Option<Connection> {
        let projection = self.project_through(point.position, lens)?;
        let normal = point.geometric_normal;
        let (arriving, leaving) = (-direction.dot(normal), projection.towards.dot(normal));
        let is_one_side = arriving * leaving > 0.0;
        if !is_one_side {
            return None;
        }
        let reflectance = reflectance(scene, scene.material_of(shape), arriving > 0.0)?;
        let cosine = match self.shading_normals {
            ShadingNormals::Flux => leaving.abs(),
            ShadingNormals::Adjoint => {
                let normal = point.shading_normal;
                let bent = (-direction.dot(normal), projection.towards.dot(normal));
                let do_agree = bent.0 * arriving > 0.0 && bent.1 * leaving > 0.0;
                if !do_agree {
                    return None;
                }
                leaving.abs() * (bent.0 / arriving)
            }
        };
        let passed = transmittance(
            scene,
            point,
            projection.towards,
            projection.distance,
            counters,
        );
        let factor = cosine * projection.importance * passed * std::f64::consts::FRAC_1_PI;
        (factor > 0.0 && !reflectance.is_black()).then(|| Connection {
            at: projection.at,
            radiance_per_flux: reflectance * factor,
            distance: projection.distance,
        })
    }

    /// [`connect`](Self::connect), for light that counts in one pixel alone: that pixel, row by row from the
    /// top, and its radiance [W/m²/sr] by flux arriving at the point \[W\].
    ///
    /// `None` also where the point is seen outside of the crop: no shadow ray is spent on it.
    pub fn connect_pixel(
        &self,
        scene: &Scene,
        shape: u32,
        point: &SurfacePoint,
        direction: DVec3,
        counters: &mut TraversalCounters,
    ) -> Option<(usize, Rgb)> {
        // Most surfaces that light meets on its way are glass: they cost no projection either.
        let front = direction.dot(point.geometric_normal) < 0.0;
        reflectance(scene, scene.material_of(shape), front)?;
        let pixel = self.pixel(self.project(point.position)?.at)?;
        let seen = self.connect(scene, shape, point, direction, counters)?;
        Some((pixel, seen.radiance_per_flux))
    }

    /// Whether a shape's surface is diffuse and not black on either side, so that light on it may be seen.
    pub fn may_see_surface(&self, scene: &Scene, shape: u32) -> bool {
        let material = scene.material_of(shape);
        [true, false]
            .iter()
            .any(|&front| reflectance(scene, material, front).is_some_and(|seen| !seen.is_black()))
    }

    /// The view through film coordinates `at` (pixels of the crop; may lie outside of it) and the middle of the lens.
    ///
    /// The inverse of [`project`](Self::project). Its radiance needs no weight: a pixel's is the average over it.
    pub fn pixel_ray(&self, at: DVec2) -> PixelRay {
        self.ray_through(at, LENS_MIDDLE)
    }

    /// The view through film coordinates `at` and the point `lens` of the lens, which uniform numbers in
    /// [0, 1)² spread evenly over it; other cameras do not look at `lens`.
    ///
    /// The inverse of [`project_through`](Self::project_through): a pixel's radiance is the average over both.
    pub fn ray_through(&self, at: DVec2, lens: DVec2) -> PixelRay {
        let on_film = (self.center - at) / self.pixels;
        let depth = self.far_clip - self.near_clip;
        let (ray, stretch) = self.lens.ray(&self.to_world, on_film, lens, self.near_clip);
        PixelRay {
            ray,
            reach: depth * stretch,
        }
    }

    /// The corners of a film three times as wide and high, about the camera's.
    pub fn near_film(&self) -> [DVec2; 2] {
        let film = DVec2::new(self.width() as f64, self.height() as f64);
        [-film, 2.0 * film]
    }

    /// The planes round what is seen near the film ([`near_film`](Self::near_film)) through the middle of the
    /// lens: the near plane, then the four sides. Each is a point of it and its normal (of any length) that points out of sight.
    ///
    /// What is behind the camera is out of sight by the near plane, whatever the sides say.
    pub fn planes(&self) -> &[[DVec3; 2]; 5] {
        &self.planes
    }

    fn planes_round(&self, [low, high]: [DVec2; 2]) -> [[DVec3; 2]; 5] {
        let corners = [
            low,
            DVec2::new(high.x, low.y),
            high,
            DVec2::new(low.x, high.y),
        ];
        let rays = corners.map(|at| self.pixel_ray(at).ray);
        let middle = self.pixel_ray(0.5 * (low + high)).ray;
        let side = |index: usize| {
            let (ray, next) = (rays[index], rays[(index + 1) % 4]);
            // Both lines of sight are in it, whether they meet in a pinhole or are parallel.
            let across = next.origin + next.direction - ray.origin;
            let normal = ray.direction.cross(across);
            let inside = normal.dot(middle.origin + middle.direction - ray.origin);
            [ray.origin, if inside > 0.0 { -normal } else { normal }]
        };
        let [a, b, c, _] = rays.map(|ray| ray.origin);
        let near = (b - a).cross(c - b);
        let near = if near.dot(middle.direction) > 0.0 {
            -near
        } else {
            near
        };
        [[a, near], side(0), side(1), side(2), side(3)]
    }

    /// How samples spread over pixels.
    pub fn filter(&self) -> ReconstructionFilter {
        self.film.filter
    }

    /// How many pixels beyond the film's crop, each way, paths from the camera sample: those that the filter
    /// reaches in from, where the film asks for it (`sample_border`).
    pub fn sampled_border(&self) -> usize {
        if self.film.sample_border {
            self.film.filter.border()
        } else {
            0
        }
    }

    /// Whether rays start anywhere on a lens of some size.
    pub fn has_aperture(&self) -> bool {
        self.lens.has_aperture()
    }
}

/// The numbers of the middle of the lens.
const LENS_MIDDLE: DVec2 = DVec2::splat(0.5);
