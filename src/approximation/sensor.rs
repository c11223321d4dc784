//! A sensor as techniques fill it: points of its texels or pixels in batches, and irradiance at them
//! averaged.

use std::f64::consts::FRAC_1_PI;
use std::ops::{AddAssign, Range};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::geometry::{Ray, SurfacePoint, TraversalCounters};
use crate::radiometry::Rgb;
use crate::run::Refusal;
use crate::scene::{Scene, Sensor, SensorKind};
use crate::transport::camera::{Camera, reflectance};
use crate::transport::path_end::next_hit;
use crate::transport::receiver::Receiver;
use crate::transport::screen::Screen;

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
    pub fn new(scene: &Scene, sensor: &Sensor) -> Result<Self, Refusal> {
        if matches!(sensor.kind, SensorKind::IrradianceMeter { .. }) {
            Ok(Self::Receiver(Box::new(Receiver::new(scene, sensor)?)))
        } else {
            Ok(Self::Camera(Box::new(Camera::new(scene, sensor)?)))
        }
    }

    /// The texels that light falls on; for a camera with an étendue of 1, so that flux counts as radiance.
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

    /// The shape that is measured on; `None` for a camera.
    pub fn shape(&self) -> Option<u32> {
        match self {
            Self::Receiver(receiver) => Some(receiver.shape()),
            Self::Camera(_) => None,
        }
    }

    /// The divisor of sums of the [`screen`](Self::screen): a texel's area \[m²\], or 1.
    pub fn measure(&self, texel: usize) -> f64 {
        match self {
            Self::Receiver(receiver) => receiver.texel_area(texel),
            Self::Camera(_) => 1.0,
        }
    }

    /// The typical length of a texel on surfaces \[m\]: of a camera the median distance of what neighbouring
    /// pixels of a row see, at 16 x 16 places of its film.
    pub fn texel_length(&self, scene: &Scene) -> f64 {
        const PLACES: usize = 16;
        let [width, height] = self.size();
        match self {
            Self::Receiver(receiver) => {
                let texels = 0..receiver.texels();
                let covered = texels
                    .clone()
                    .filter(|&texel| receiver.has_surface(texel))
                    .count();
                let area: f64 = texels.map(|texel| receiver.texel_area(texel)).sum();
                (area / covered.max(1) as f64).sqrt()
            }
            Self::Camera(_) => {
                let mut counters = TraversalCounters::default();
                let mut seen = |texel: usize| {
                    let (_, point) = self.point(scene, texel, DVec2::splat(0.5), &mut counters);
                    point.map(|point| point.point.position)
                };
                let mut lengths: Vec<f64> = (0..PLACES * PLACES)
                    .filter_map(|place| {
                        let column = (2 * (place % PLACES) + 1) * width / (2 * PLACES);
                        let row = (2 * (place / PLACES) + 1) * height / (2 * PLACES);
                        let texel = row * width + column;
                        let next = if column + 1 < width { texel + 1 } else { texel };
                        Some(seen(texel)?.distance(seen(next)?)).filter(|length| *length > 0.0)
                    })
                    .collect();
                lengths.sort_by(f64::total_cmp);
                lengths.get(lengths.len() / 2).copied().unwrap_or(1.0)
            }
        }
    }

    /// A bound on the factor of flux on the [`screen`](Self::screen), for the scale of sums: 1 for a
    /// receiver; for a camera 4096 times the median over the surfaces that it sees.
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
                let seen = camera.connect(scene, &hit, &point, ray.direction, &mut counters)?;
                Some(seen.radiance_per_flux.max_channel()).filter(|factor| factor.is_normal())
            })
            .collect();
        factors.sort_by(f64::total_cmp);
        HEADROOM * factors.get(factors.len() / 2).copied().unwrap_or(1.0)
    }

    /// The points at which some texels are sampled: the midpoints of a sub-grid of `samples` x `samples` in
    /// each, in their order. Of a camera the surface that each ray meets first, if it is diffuse.
    ///
    /// Points on no surface, or on a black one, are left out; [`SensorPoints::weights`] counts them.
    pub fn points(
        &self,
        scene: &Scene,
        texels: Range<usize>,
        samples: u32,
        counters: &mut TraversalCounters,
    ) -> SensorPoints {
        let mut found = SensorPoints {
            first: texels.start,
            weights: vec![0.0; texels.len()],
            points: Vec::with_capacity(texels.len() * (samples * samples) as usize),
        };
        for texel in texels {
            for place in 0..samples * samples {
                let at = midpoint(place, samples);
                let (weight, point) = self.point(scene, texel, at, counters);
                found.weights[texel - found.first] += weight;
                found.points.extend(point);
            }
        }
        found
    }

    /// All [`points`](Self::points), in batches of texels, with the work of finding them.
    pub fn batches<'a>(
        &'a self,
        scene: &'a Scene,
        samples: u32,
    ) -> impl IndexedParallelIterator<Item = (SensorPoints, TraversalCounters)> + 'a {
        let [width, height] = self.size();
        let texels = width * height;
        let batch = texels_of_batch(samples);
        (0..texels.div_ceil(batch))
            .into_par_iter()
            .map(move |index| {
                let range = index * batch..((index + 1) * batch).min(texels);
                let mut counters = TraversalCounters::default();
                (self.points(scene, range, samples, &mut counters), counters)
            })
    }

    /// The point of a texel at fractions `at` across it, and the weight that it has, also if it is on no
    /// surface or on a black one.
    #[inline]
    pub fn point(
        &self,
        scene: &Scene,
        texel: usize,
        at: DVec2,
        counters: &mut TraversalCounters,
    ) -> (f64, Option<SensorPoint>) {
        match self {
            Self::Receiver(receiver) => {
                let Some(patch) = receiver.patch(scene, texel, at) else {
                    return (0.0, None);
                };
                let point = SensorPoint {
                    texel,
                    weight: patch.density,
                    normal: patch.point.geometric_normal,
                    point: patch.point,
                    albedo: None,
                    view: None,
                };
                (patch.density, Some(point))
            }
            Self::Camera(camera) => {
                let column = (texel % camera.width()) as f64;
                let row = (texel / camera.width()) as f64;
                let view = camera.pixel_ray(DVec2::new(column, row) + at);
                (
                    1.0,
                    visible_point(scene, texel, view.ray, view.reach, counters),
                )
            }
        }
    }

    /// Averages irradiance over each texel: `irradiance(point, work)` at the [`points`](Self::points),
    /// weighted by the area that they stand for. Of a camera E ρ/π.
    ///
    /// Texels without any surface are zero. Work is the sum of all calls', in the order of texels; view rays
    /// are counted apart.
    pub fn evaluate<W: Default + AddAssign + Send>(
        &self,
        scene: &Scene,
        samples: u32,
        irradiance: impl Fn(&SensorPoint, &mut W) -> Rgb + Sync,
    ) -> (Vec<Rgb>, W, TraversalCounters) {
        let [width, height] = self.size();
        let mut values = vec![Rgb::BLACK; width * height];
        let batches: Vec<(W, TraversalCounters)> = self
            .batches(scene, samples)
            .zip(values.par_chunks_mut(texels_of_batch(samples)))
            .map(|((found, counters), values)| {
                let mut work = W::default();
                for point in &found.points {
                    let value = point.measured(irradiance(point, &mut work));
                    values[point.texel - found.first] += value * point.weight;
                }
                for (value, weight) in values.iter_mut().zip(&found.weights) {
                    if *weight > 0.0 {
                        *value = *value / *weight;
                    }
                }
                (work, counters)
            })
            .collect();
        let (mut work, mut counters) = (W::default(), TraversalCounters::default());
        for (done, rays) in batches {
            work += done;
            counters += rays;
        }
        (values, work, counters)
    }
}

/// Texels of a batch, with so many points along each side.
fn texels_of_batch(samples: u32) -> usize {
    /// Points of a batch: they stay in a core's cache.
    const BATCH: usize = 1024;
    (BATCH / (samples * samples) as usize).max(1)
}

/// The midpoint of a cell of a sub-grid of `samples` x `samples` in a texel, in fractions across it.
#[inline]
pub fn midpoint(cell: u32, samples: u32) -> DVec2 {
    let at = DVec2::new(f64::from(cell % samples), f64::from(cell / samples));
    (at + 0.5) / f64::from(samples)
}

/// The points at which some texels are sampled.
#[derive(Clone, Debug)]
pub struct SensorPoints {
    /// The first texel.
    pub first: usize,
    /// By texel: the weights of all its points, those included that see nothing.
    pub weights: Vec<f64>,
    /// The points on surfaces, texel by texel.
    pub points: Vec<SensorPoint>,
}

/// A point of a texel's or pixel's surface.
#[derive(Clone, Copy, Debug)]
pub struct SensorPoint {
    /// The texel, row by row.
    pub texel: usize,
    /// The area that it stands for, in any unit.
    pub weight: f64,
    /// The surface.
    pub point: SurfacePoint,
    /// The unit normal on the side that is measured.
    pub normal: DVec3,
    /// Albedo ρ of the side that a camera sees; `None` on a receiver, whose irradiance is measured.
    pub albedo: Option<Rgb>,
    /// The ray from the camera; `None` on a receiver.
    pub view: Option<Ray>,
}

impl SensorPoint {
    /// The sensor's quantity for irradiance E [W/m²] at the point: E itself, or radiance E ρ/π [W/m²/sr].
    #[inline]
    pub fn measured(&self, irradiance: Rgb) -> Rgb {
        measured(self.albedo, irradiance)
    }
}

/// A sensor's quantity for irradiance [W/m²] at a point whose side has an [`albedo`](SensorPoint::albedo).
#[inline]
pub fn measured(albedo: Option<Rgb>, irradiance: Rgb) -> Rgb {
    match albedo {
        Some(albedo) => albedo * irradiance * FRAC_1_PI,
        None => irradiance,
    }
}

/// The point that a camera's ray meets first, if its surface is diffuse.
fn visible_point(
    scene: &Scene,
    texel: usize,
    ray: Ray,
    reach: f64,
    counters: &mut TraversalCounters,
) -> Option<SensorPoint> {
    let (ray, hit) = next_hit(scene, ray, counters)?;
    let point = scene.world().surface_point(&ray, &hit);
    if point.position.distance(ray.origin) > reach {
        return None;
    }
    let front = ray.direction.dot(point.geometric_normal) < 0.0;
    let albedo = reflectance(scene, &hit, &point, front)?;
    let normal = if front {
        point.geometric_normal
    } else {
        -point.geometric_normal
    };
    Some(SensorPoint {
        texel,
        weight: 1.0,
        point,
        normal,
        albedo: Some(albedo),
        view: Some(ray),
    })
}
