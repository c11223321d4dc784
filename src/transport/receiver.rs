//! Receiver grids: which texel of a surface light arrives in.

use glam::DVec2;

use crate::geometry::{Shape, SurfacePoint};
use crate::scene::{Crop, Scene, Sensor, SensorKind};

/// An irradiance meter: a grid of texels over the (u, v) of a shape's front side.
///
/// Texel (column, row) of the full film covers u in [column, column + 1) / width and v in
/// [row, row + 1) / height; row 0 is at v = 0, as in Mitsuba's images of an `irradiancemeter`.
/// Only the cropped part is measured. u = 1 and v = 1 belong to the last texel.
#[derive(Clone, Debug)]
pub struct Receiver {
    shape: u32,
    full: DVec2,
    crop: Crop,
    area: TexelArea,
}

/// The area of a texel, by what it depends on.
#[derive(Clone, Debug)]
enum TexelArea {
    /// All the same (rectangle, cylinder).
    Uniform(f64),
    /// One a column: rings of a disc, where u is the radius.
    Column(Vec<f64>),
    /// One a row: belts of a sphere, where v runs from pole to pole.
    Row(Vec<f64>),
}

/// Why a sensor cannot be used as a receiver.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReceiverError {
    /// It is a camera.
    #[error(
        "sensor \"{id}\" is a {plugin}: this method measures irradiance; \
         sensors of plugin irradiancemeter are allowed"
    )]
    NotAMeter {
        /// The sensor.
        id: String,
        /// Mitsuba's name of its kind.
        plugin: &'static str,
    },
    /// The shape has no (u, v) with known texel areas.
    #[error(
        "sensor \"{id}\" measures shape \"{shape}\" ({plugin}): receivers can be \
         rectangle, disk, sphere and cylinder"
    )]
    Shape {
        /// The sensor.
        id: String,
        /// The shape.
        shape: String,
        /// Mitsuba's name of the shape.
        plugin: &'static str,
    },
}

impl Receiver {
    /// The receiver that a sensor describes.
    ///
    /// # Errors
    ///
    /// For a camera, and for a meter on a mesh.
    pub fn new(scene: &Scene, sensor: &Sensor) -> Result<Self, ReceiverError> {
        let SensorKind::IrradianceMeter { shape } = sensor.kind else {
            return Err(ReceiverError::NotAMeter {
                id: sensor.id.clone(),
                plugin: sensor.plugin(),
            });
        };
        let film = &sensor.film;
        let (columns, rows) = (f64::from(film.width), f64::from(film.height));
        let belt = |i: u32, n: f64| (f64::from(i) / n, f64::from(i + 1) / n);
        let area = match &scene.world().shapes()[shape.0 as usize] {
            Shape::Rectangle(rectangle) => TexelArea::Uniform(rectangle.area() / (columns * rows)),
            Shape::Cylinder(cylinder) => TexelArea::Uniform(cylinder.area() / (columns * rows)),
            Shape::Disk(disk) => TexelArea::Column(
                (0..film.width)
                    .map(|column| {
                        let (from, to) = belt(column, columns);
                        disk.area() * (to - from) * (to + from) / rows
                    })
                    .collect(),
            ),
            Shape::Sphere(sphere) => TexelArea::Row(
                (0..film.height)
                    .map(|row| {
                        let (from, to) = belt(row, rows);
                        // cos a − cos b = 2 sin((a+b)/2) sin((b−a)/2), without cancellation.
                        let half = std::f64::consts::FRAC_PI_2;
                        let belt = (half * (from + to)).sin() * (half * (to - from)).sin();
                        sphere.area() * belt / columns
                    })
                    .collect(),
            ),
            Shape::Mesh(_) => {
                let object = &scene.objects()[shape.0 as usize];
                return Err(ReceiverError::Shape {
                    id: sensor.id.clone(),
                    shape: object.id.clone(),
                    plugin: object.plugin,
                });
            }
        };
        Ok(Self {
            shape: shape.0,
            full: DVec2::new(columns, rows),
            crop: film.crop,
            area,
        })
    }

    /// The shape that receives.
    #[inline]
    pub fn shape(&self) -> u32 {
        self.shape
    }

    /// Texels a row.
    #[inline]
    pub fn width(&self) -> usize {
        self.crop.width as usize
    }

    /// Rows.
    #[inline]
    pub fn height(&self) -> usize {
        self.crop.height as usize
    }

    /// How many texels there are.
    pub fn texels(&self) -> usize {
        self.width() * self.height()
    }

    /// The texel that light travelling along `direction` falls into at `point`, row by row;
    /// `None` where it arrives from behind or falls outside the crop.
    #[inline]
    pub fn texel(&self, point: &SurfacePoint, direction: glam::DVec3) -> Option<usize> {
        if direction.dot(point.geometric_normal) >= 0.0 {
            return None;
        }
        let place = |along: f64, size: f64, offset: u32, kept: u32| {
            // Rounding may put a point a hair outside [0, 1]: it belongs to the border texel.
            let index = (along * size).clamp(0.0, size - 1.0) as u32;
            index.checked_sub(offset).filter(|index| *index < kept)
        };
        let column = place(point.uv.x, self.full.x, self.crop.offset_x, self.crop.width)?;
        let row = place(
            point.uv.y,
            self.full.y,
            self.crop.offset_y,
            self.crop.height,
        )?;
        Some(row as usize * self.width() + column as usize)
    }

    /// Where light travelling along `direction` falls at `point`, in texels from the cropped film's
    /// corner, beyond its border too; `None` where it arrives from behind.
    #[inline]
    pub fn place(&self, point: &SurfacePoint, direction: glam::DVec3) -> Option<DVec2> {
        (direction.dot(point.geometric_normal) < 0.0).then(|| self.film_place(point.uv))
    }

    /// Surface parameters in texels from the cropped film's corner.
    #[inline]
    pub fn film_place(&self, uv: DVec2) -> DVec2 {
        uv * self.full
            - DVec2::new(
                f64::from(self.crop.offset_x),
                f64::from(self.crop.offset_y),
            )
    }

    /// The area of a texel \[m²\].
    pub fn texel_area(&self, texel: usize) -> f64 {
        let column = texel % self.width() + self.crop.offset_x as usize;
        let row = texel / self.width() + self.crop.offset_y as usize;
        match &self.area {
            TexelArea::Uniform(area) => *area,
            TexelArea::Column(areas) => areas[column],
            TexelArea::Row(areas) => areas[row],
        }
    }

    /// The surface at fractions `at` (in 0..=1) across a texel.
    ///
    /// # Panics
    ///
    /// For a scene other than the one the receiver was made for.
    #[inline]
    pub fn point(&self, scene: &Scene, texel: usize, at: DVec2) -> SurfacePoint {
        scene.world().shapes()[self.shape as usize]
            .at_uv(self.uv(texel, at))
            .expect("Receiver::new refuses shapes without surface parameters")
    }

    /// The nearest to `at`, fractions across a texel or a little beyond it, that the surface has.
    pub fn clamped(&self, texel: usize, at: DVec2) -> DVec2 {
        let corner = self.uv(texel, DVec2::ZERO) * self.full;
        at.clamp(-corner, self.full - corner)
    }

    /// The (u, v) at fractions `at` (in 0..=1) across a texel.
    #[inline]
    pub fn uv(&self, texel: usize, at: DVec2) -> DVec2 {
        let column = texel % self.width() + self.crop.offset_x as usize;
        let row = texel / self.width() + self.crop.offset_y as usize;
        (DVec2::new(column as f64, row as f64) + at) / self.full
    }
}
