//! A camera's film, and the rays that belong to its points.

use glam::{DVec2, DVec3};

use super::diffuse::has_varying_reflectance;
use super::error::CameraError;
use super::lens::CameraLens;
use crate::film::PixelFilter;
use crate::geometry::{Ray, Transform, TraversalCounters};
use crate::numeric::math;
use crate::scene::{Film, MediumId, ReconstructionFilter, Scene, Sensor, SensorKind};
use crate::transport::bsdf::check_colors;
use crate::transport::media::medium_along;
use crate::transport::scatter::ShadingNormals;

/// A camera: a film on which points of the scene are seen.
///
/// The film's coordinates are in pixels of its crop: x to the right, y down, the top left corner of the crop
/// at (0, 0). The conventions are Mitsuba's (checked against 3.9.1, see `tests/paths/camera/`). Camera
/// space has +x to the *left* of the image, +y up, and looks along +z. A principal point's offset moves the
/// image left and up.
#[derive(Clone, Debug)]
pub struct Camera {
    film: Film,
    to_world: Transform,
    lens: CameraLens,
    near_clip: f64,
    far_clip: f64,
    /// The film point, in pixels of the crop, on the camera's axis.
    center: DVec2,
    /// Pixels per unit of camera space (on the plane z = 1, for a pinhole); the same along x and y.
    pixels: f64,
    pub(super) shading_normals: ShadingNormals,
    /// The medium that its views start in.
    medium: MediumId,
    /// Planes round the region near the film: see [`planes`](Self::planes).
    planes: [[DVec3; 2]; 5],
}

/// The projection of a point onto the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraProjection {
    /// Film point in pixels of the cropped film, continuous; may lie outside of it.
    pub at: DVec2,
    /// Unit vector from the point to the camera.
    pub towards: DVec3,
    /// Distance from the point to the near plane, along `towards`.
    pub distance: f64,
    /// Radiance [W/m²/sr] averaged over a pixel, per radiance times surface area times cosine [W/sr] at the
    /// point. It is the pixel's importance times the geometric term [1/m²].
    pub importance: f64,
}

/// A camera's view through a point of its film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelRay {
    /// The ray, from the near plane on.
    pub ray: Ray,
    /// The distance to the far plane: surfaces beyond it are not seen.
    pub reach: f64,
    /// The medium in which it starts.
    pub medium: MediumId,
}

/// A camera's near plane, on which its film is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearPlane {
    /// The place of film coordinates (0, 0).
    pub corner: DVec3,
    /// How that changes by a pixel to the right, and by one down.
    pub across: [DVec3; 2],
    /// The unit direction of view at the corner.
    pub direction: DVec3,
    /// The place at which lines of sight meet; `None` if they are parallel.
    pub eye: Option<DVec3>,
}

impl Camera {
    /// The camera that a sensor describes, for light on Lambertian surfaces of even reflectance that is
    /// connected to it, pixel by pixel.
    ///
    /// Its shading normals are [`ShadingNormals::Flux`].
    ///
    /// # Errors
    ///
    /// As [`connectable`](Self::connectable), and for a filter other than the box. Also if a diffuse surface
    /// of the scene has a reflectance that is not a constant colour.
    pub fn new(scene: &Scene, sensor: &Sensor) -> Result<Self, CameraError> {
        let id = || sensor.id.clone();
        let camera = Self::connectable(scene, sensor)?;
        let filter = camera.film.filter;
        if filter != ReconstructionFilter::Box {
            return Err(CameraError::Filter {
                id: id(),
                filter: filter.plugin(),
            });
        }
        let varies = |object: &&crate::scene::Object| {
            has_varying_reflectance(scene, scene.material(object.material))
        };
        match scene.objects().iter().find(varies) {
            None => Ok(camera),
            Some(object) => Err(CameraError::Reflectance {
                id: id(),
                shape: object.id.clone(),
            }),
        }
    }

    /// The camera that a sensor describes, for light on Lambertian surfaces of any colour that is connected
    /// to it, with any filter.
    ///
    /// # Errors
    ///
    /// For an irradiance meter or a thin lens, within a medium, for colours that are not known, and as
    /// [`of_sensor`](Self::of_sensor).
    pub fn connectable(scene: &Scene, sensor: &Sensor) -> Result<Self, CameraError> {
        let is_refused = matches!(
            sensor.kind,
            SensorKind::ThinLens { .. } | SensorKind::IrradianceMeter { .. }
        );
        if is_refused {
            return Err(CameraError::Kind {
                id: sensor.id.clone(),
                plugin: sensor.plugin(),
            });
        }
        check_colors(scene)?;
        let camera = Self::of_sensor(sensor)?.within(scene, sensor)?;
        if camera.medium != MediumId::CLEAR {
            return Err(CameraError::InMedium {
                id: sensor.id.clone(),
            });
        }
        Ok(camera)
    }

    /// The same camera in the medium around its sensor: that which the file says, else that in which its
    /// views start, at the corners of its film and in the middle.
    ///
    /// # Errors
    ///
    /// If a border of media goes through its near plane.
    pub fn within(self, scene: &Scene, sensor: &Sensor) -> Result<Self, CameraError> {
        // Of what the file says it knows already.
        if scene.is_clear() || sensor.medium.is_some() {
            return Ok(self);
        }
        let around = |[x, y]: [f64; 2]| {
            let at = DVec2::new(x * self.width() as f64, y * self.height() as f64);
            let ray = self.pixel_ray(at).ray;
            medium_along(scene, &ray, &mut TraversalCounters::default())
        };
        let places = [[0.5, 0.5], [0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
        let media = places.map(around);
        let medium = media[0];
        if media != [medium; 5] {
            return Err(CameraError::AcrossMedia {
                id: sensor.id.clone(),
            });
        }
        Ok(Self { medium, ..self })
    }

    /// The camera that a sensor describes, of any kind, with any filter and before any scene: in the clear.
    ///
    /// It is for methods that ask each surface's [`Bsdf`](crate::transport::bsdf::Bsdf) for its scattering.
    ///
    /// # Errors
    ///
    /// For an irradiance meter, and if pixels or film coordinates overflow.
    pub fn of_sensor(sensor: &Sensor) -> Result<Self, CameraError> {
        let id = || sensor.id.clone();
        let film = &sensor.film;
        let (to_world, near_clip, far_clip, half_width, offset) = match &sensor.kind {
            SensorKind::Perspective(camera) | SensorKind::ThinLens { camera, .. } => (
                camera.to_world,
                camera.near_clip,
                camera.far_clip,
                math::tan(0.5 * camera.horizontal_fov),
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
            lens: CameraLens::new(&sensor.kind, &to_world),
            near_clip,
            far_clip,
            center: (0.5 - offset) * full - crop,
            pixels: 0.5 * full.x / half_width,
            shading_normals: ShadingNormals::Flux,
            medium: sensor.medium.unwrap_or_default(),
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

    /// The same camera, with another effect of interpolated normals on light from diffuse surfaces.
    ///
    /// With `Flux` a surface reflects the light that its true normal receives. With `Adjoint` its radiance is
    /// that of a surface with the shading normal s, as in Mitsuba's images. Let g be the true normal. Then
    /// flux from w is scaled by the factor |w · s| / |w · g| (Veach 1997, 5.3). It counts nothing if the two
    /// normals disagree about sides.
    #[must_use]
    pub fn with_shading_normals(mut self, shading_normals: ShadingNormals) -> Self {
        self.shading_normals = shading_normals;
        self
    }

    /// Number of pixels in a row of the crop.
    pub fn width(&self) -> usize {
        self.film.crop.width as usize
    }

    /// Number of rows of the crop.
    pub fn height(&self) -> usize {
        self.film.crop.height as usize
    }

    /// The pixel at film coordinates, counted row by row from the top; `None` outside the crop.
    #[inline]
    pub fn pixel(&self, at: DVec2) -> Option<usize> {
        let (width, height) = (self.width(), self.height());
        let is_inside = at.x >= 0.0 && at.y >= 0.0 && at.x < width as f64 && at.y < height as f64;
        is_inside.then(|| at.y as usize * width + at.x as usize)
    }

    /// The projection of a point, hidden or not; `None` before the near plane and beyond the far one.
    ///
    /// It is through the middle of a lens: see [`project_through`](Self::project_through).
    #[inline]
    pub fn project(&self, position: DVec3) -> Option<CameraProjection> {
        self.project_through(position, LENS_MIDDLE)
    }

    /// The projection of a point through the point `lens` of the lens, as in
    /// [`ray_through`](Self::ray_through).
    ///
    /// The mean of `importance` over uniform `lens` in [0, 1)² is the importance of the whole pixel.
    #[inline]
    pub fn project_through(&self, position: DVec3, lens: DVec2) -> Option<CameraProjection> {
        let seen = self
            .lens
            .project(&self.to_world, position, lens, self.near_clip)?;
        let pixel_area = 1.0 / (self.pixels * self.pixels);
        let at = self.center - seen.on_film * self.pixels;
        let importance = seen.importance / pixel_area;
        let is_seen = seen.depth > 0.0 && seen.depth <= self.far_clip - self.near_clip;
        (is_seen && at.is_finite() && importance.is_finite()).then_some(CameraProjection {
            at,
            towards: seen.towards,
            distance: seen.distance,
            importance,
        })
    }

    /// The view through film coordinates `at` (pixels of the crop; may lie outside of it) and the middle of
    /// the lens.
    ///
    /// It is the inverse of [`project`](Self::project). Its radiance needs no weight: a pixel's is the
    /// average over it.
    pub fn pixel_ray(&self, at: DVec2) -> PixelRay {
        self.ray_through(at, LENS_MIDDLE)
    }

    /// The view through film coordinates `at` and the point `lens` of the lens.
    ///
    /// Uniform numbers in [0, 1)² spread evenly over the lens. Cameras without a lens ignore `lens`.
    ///
    /// It is the inverse of [`project_through`](Self::project_through): a pixel's radiance is the average
    /// over both arguments.
    pub fn ray_through(&self, at: DVec2, lens: DVec2) -> PixelRay {
        let on_film = (self.center - at) / self.pixels;
        let depth = self.far_clip - self.near_clip;
        let (ray, stretch) = self.lens.ray(&self.to_world, on_film, lens, self.near_clip);
        PixelRay {
            ray,
            reach: depth * stretch,
            medium: self.medium,
        }
    }

    /// The corners of a film three times as wide and high as the camera's, about the same middle.
    pub fn near_film(&self) -> [DVec2; 2] {
        let film = DVec2::new(self.width() as f64, self.height() as f64);
        [-film, 2.0 * film]
    }

    /// The planes round the region seen near the film ([`near_film`](Self::near_film)) through the middle of
    /// the lens: the near plane, then the four sides.
    ///
    /// Each plane is a point of it and its normal (of any length), which points out of sight.
    ///
    /// Points behind the camera are out of sight by the near plane, even inside of the sides.
    pub fn planes(&self) -> &[[DVec3; 2]; 5] {
        &self.planes
    }

    /// The planes round what the film sees through the middle of the lens, as [`planes`](Self::planes).
    pub fn frustum(&self) -> [[DVec3; 2]; 5] {
        let film = DVec2::new(self.width() as f64, self.height() as f64);
        self.planes_round([DVec2::ZERO, film])
    }

    /// The four sides of [`planes`](Self::planes), half a film farther out.
    pub fn planes_beside_view(&self) -> [[DVec3; 2]; 4] {
        let [low, high] = self.near_film();
        let out = (high - low) / 6.0;
        let [_, sides @ ..] = self.planes_round([low - out, high + out]);
        sides
    }

    /// Where the camera is: the middle of its lens, or of the film's plane for parallel rays.
    pub fn eye(&self) -> DVec3 {
        self.to_world.point(DVec3::ZERO)
    }

    /// The near plane, on which the film is seen through the middle of the lens.
    pub fn near_plane(&self) -> NearPlane {
        let film = DVec2::new(self.width() as f64, self.height() as f64);
        let corners = [
            DVec2::ZERO,
            DVec2::new(film.x, 0.0),
            DVec2::new(0.0, film.y),
        ];
        let [corner, right, below] = corners.map(|at| self.pixel_ray(at).ray);
        let is_parallel = matches!(self.lens, CameraLens::Parallel { .. });
        NearPlane {
            corner: corner.origin,
            across: [
                (right.origin - corner.origin) / film.x,
                (below.origin - corner.origin) / film.y,
            ],
            direction: corner.direction,
            eye: (!is_parallel).then(|| self.eye()),
        }
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
            // Both lines of sight are in the plane, whether they meet in a pinhole or are parallel.
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

    /// The filter by which samples spread over pixels.
    pub fn filter(&self) -> ReconstructionFilter {
        self.film.filter
    }

    /// The filter as an average over each pixel's surroundings.
    pub fn pixel_filter(&self) -> PixelFilter {
        let size = [self.width(), self.height()];
        PixelFilter::new(self.film.filter, size, self.sampled_border())
    }

    /// Number of pixels beyond the film's crop, each way, that paths from the camera sample.
    ///
    /// The filter reaches in from these pixels, if the film asks for it (`sample_border`).
    pub fn sampled_border(&self) -> usize {
        if self.film.sample_border {
            self.film.filter.border()
        } else {
            0
        }
    }

    /// True if rays start anywhere on a lens of some size.
    pub fn has_aperture(&self) -> bool {
        self.lens.has_aperture()
    }
}

/// The coordinates of the middle of the lens.
pub(super) const LENS_MIDDLE: DVec2 = DVec2::splat(0.5);
