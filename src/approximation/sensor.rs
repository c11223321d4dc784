//! A field of irradiance on a sensor's texels or pixels.

use glam::DVec2;
use rayon::prelude::*;

use super::{ApproximationError, Work};
use crate::geometry::{Ray, SurfacePoint, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::{Color, Material, Scene, Sensor, SensorKind};
use crate::transport::camera::Camera;
use crate::transport::path_end::next_hit;
use crate::transport::receiver::Receiver;
use crate::transport::screen::Screen;

/// Irradiance as a technique knows it: at any point of any surface.
pub trait IrradianceField: Sync {
    /// Irradiance E [W/m²] at a point of a surface, on the side of its unit `normal`.
    fn irradiance(&self, point: &SurfacePoint, normal: glam::DVec3, work: &mut Work) -> Rgb;
}

/// A sensor, ready to be filled.
#[derive(Clone, Debug)]
pub enum SensorFilm {
    /// Texels on a surface.
    Receiver(Box<Receiver>),
    /// Pixels.
    Camera(Box<Camera>),
}

impl SensorFilm {
    /// The sensor of a scene.
    ///
    /// # Errors
    ///
    /// As [`Receiver::new`] and [`Camera::new`].
    pub fn new(scene: &Scene, sensor: &Sensor) -> Result<Self, ApproximationError> {
        if matches!(sensor.kind, SensorKind::IrradianceMeter { .. }) {
            Ok(Self::Receiver(Box::new(Receiver::new(scene, sensor)?)))
        } else {
            Ok(Self::Camera(Box::new(Camera::new(scene, sensor)?)))
        }
    }

    /// What paths fall on; of a camera with an étendue of 1, so that flux counts as radiance.
    pub fn screen(&self) -> Screen<'_> {
        match self {
            Self::Receiver(receiver) => Screen::Receiver(receiver),
            Self::Camera(camera) => Screen::Camera {
                camera,
                etendue: 1.0,
            },
        }
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        self.screen().size()
    }

    /// The shape that is measured on; `None` of a camera.
    pub fn shape(&self) -> Option<u32> {
        match self {
            Self::Receiver(receiver) => Some(receiver.shape()),
            Self::Camera(_) => None,
        }
    }

    /// What sums of the [`screen`](Self::screen) are divided by: a texel's area \[m²\], or 1.
    pub fn measure(&self, texel: usize) -> f64 {
        match self {
            Self::Receiver(receiver) => receiver.texel_area(texel),
            Self::Camera(_) => 1.0,
        }
    }

    /// A bound on what flux is multiplied by on the [`screen`](Self::screen), for the scale of sums: 1 of a receiver, of a camera
    /// 4096 times the median over what it sees.
    pub fn largest_factor(&self, scene: &Scene) -> f64 {
        /// The camera is asked this many times along each side of its film.
        const PLACES: u32 = 16;
        /// Squared distances vary so much: a surface 64 times nearer than the typical one has room.
        const HEADROOM: f64 = 4096.0;
        let Self::Camera(camera) = self else {
            return 1.0;
        };
        let film = DVec2::new(camera.width() as f64, camera.height() as f64);
        let mut counters = TraversalCounters::default();
        let mut factors: Vec<f64> = (0..PLACES * PLACES)
            .filter_map(|index| {
                let place = DVec2::new(f64::from(index % PLACES), f64::from(index / PLACES));
                let view = camera.pixel_ray((place + 0.5) / f64::from(PLACES) * film);
                let (ray, hit) = next_hit(scene, view.ray, &mut counters)?;
                let point = scene.world().surface_point(&ray, &hit);
                // As if light came from the camera.
                let seen =
                    camera.connect(scene, hit.shape, &point, ray.direction, &mut counters)?;
                Some(seen.radiance_per_flux.max_channel()).filter(|factor| factor.is_normal())
            })
            .collect();
        factors.sort_by(f64::total_cmp);
        HEADROOM * factors.get(factors.len() / 2).copied().unwrap_or(1.0)
    }

    /// Averages a field over each texel: the mean over the midpoints of a sub-grid of `samples` x `samples`, weighted by
    /// the area they stand for. Of a camera E ρ/π of the surface that each ray meets first, if it is diffuse.
    ///
    /// Texels without any surface are zero.
    pub fn evaluate(
        &self,
        scene: &Scene,
        field: &impl IrradianceField,
        samples: u32,
    ) -> (Vec<Rgb>, Work) {
        let [width, height] = self.size();
        let rows: Vec<(Vec<Rgb>, Work)> = (0..height)
            .into_par_iter()
            .map(|row| {
                let mut work = Work::default();
                let values = (row * width..(row + 1) * width)
                    .map(|texel| self.texel(scene, field, texel, samples, &mut work))
                    .collect();
                (values, work)
            })
            .collect();
        let mut work = Work::default();
        let mut values = Vec::with_capacity(width * height);
        for (row, done) in rows {
            values.extend(row);
            work += done;
        }
        (values, work)
    }

    fn texel(
        &self,
        scene: &Scene,
        field: &impl IrradianceField,
        texel: usize,
        samples: u32,
        work: &mut Work,
    ) -> Rgb {
        let (mut sum, mut weights) = (Rgb::BLACK, 0.0);
        for place in 0..samples * samples {
            let at = DVec2::new(f64::from(place % samples), f64::from(place / samples));
            let at = (at + 0.5) / f64::from(samples);
            let seen = match self {
                Self::Receiver(receiver) => receiver.patch(scene, texel, at).map(|patch| {
                    let normal = patch.point.geometric_normal;
                    (field.irradiance(&patch.point, normal, work), patch.density)
                }),
                Self::Camera(camera) => {
                    let column = (texel % camera.width()) as f64;
                    let row = (texel / camera.width()) as f64;
                    let view = camera.pixel_ray(DVec2::new(column, row) + at);
                    Some((radiance(scene, field, view.ray, view.reach, work), 1.0))
                }
            };
            if let Some((value, weight)) = seen {
                sum += value * weight;
                weights += weight;
            }
        }
        if weights > 0.0 {
            sum / weights
        } else {
            Rgb::BLACK
        }
    }
}

/// Radiance E ρ/π [W/m²/sr] of what a ray meets.
fn radiance(
    scene: &Scene,
    field: &impl IrradianceField,
    ray: Ray,
    reach: f64,
    work: &mut Work,
) -> Rgb {
    let mut counters = TraversalCounters::default();
    let found = next_hit(scene, ray, &mut counters);
    work.add_rays(counters);
    let Some((ray, hit)) = found else {
        return Rgb::BLACK;
    };
    let point = scene.world().surface_point(&ray, &hit);
    if point.position.distance(ray.origin) > reach {
        return Rgb::BLACK;
    }
    let front = ray.direction.dot(point.geometric_normal) < 0.0;
    let Some(reflectance) = diffuse_reflectance(scene, scene.material_of(hit.shape), front) else {
        return Rgb::BLACK;
    };
    let normal = if front {
        point.geometric_normal
    } else {
        -point.geometric_normal
    };
    reflectance * field.irradiance(&point, normal, work) * std::f64::consts::FRAC_1_PI
}

/// The albedo of one side of a surface; `None` where it is black or not diffuse.
fn diffuse_reflectance(scene: &Scene, material: &Material, front: bool) -> Option<Rgb> {
    match material {
        Material::Diffuse {
            reflectance: Color::Constant(reflectance),
        } if front => Some(*reflectance),
        Material::TwoSided { front: one, back } => {
            let side = if front { one } else { back };
            diffuse_reflectance(scene, scene.material(*side), true)
        }
        _ => None,
    }
}
