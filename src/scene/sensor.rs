//! The sensors of a scene.

use glam::DVec2;

use super::{MediumId, ShapeId};
use crate::film::ReconstructionFilter;
use crate::geometry::Transform;

/// A place where light is measured, and the grid it is measured on.
///
/// # Example: the size of the maps
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// assert_eq!((sensor.plugin(), sensor.size()), ("irradiancemeter", [8, 8]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// The file's `id`, or one made from the kind and a number.
    pub id: String,
    /// The quantity that it measures, and the place that it measures from.
    #[doc(hidden)]
    pub kind: SensorKind,
    /// The grid.
    #[doc(hidden)]
    pub film: Film,
    /// The medium that the file says is around it, if it says any.
    #[doc(hidden)]
    pub medium: Option<MediumId>,
}

/// The quantity that a sensor measures, and the place that it measures from.
#[derive(Clone, Debug, PartialEq)]
pub enum SensorKind {
    /// Irradiance [W/m²] on the front side of a shape, over its (u, v).
    IrradianceMeter {
        /// The shape.
        shape: ShapeId,
    },
    /// A pinhole camera.
    Perspective(Perspective),
    /// A camera with a thin lens.
    ThinLens {
        /// The pinhole camera that a lens of radius zero would make.
        camera: Perspective,
        /// The lens' radius [scene units].
        aperture_radius: f64,
        /// Distance of the plane in focus, along the axis [scene units].
        focus_distance: f64,
    },
    /// Parallel projection along +z; the scale of `to_world` sets the image's size.
    Orthographic {
        /// Camera space to world.
        to_world: Transform,
        /// Distance of the near plane.
        near_clip: f64,
        /// Distance of the far plane.
        far_clip: f64,
    },
}

/// A pinhole camera that looks along +z of its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perspective {
    /// Camera space to world.
    pub to_world: Transform,
    /// The full horizontal field of view of the uncropped film \[rad\].
    pub horizontal_fov: f64,
    /// Distance of the near plane.
    pub near_clip: f64,
    /// Distance of the far plane.
    pub far_clip: f64,
    /// Shift of the principal point, as a fraction of the film's width and height.
    pub principal_point_offset: DVec2,
}

/// A grid of pixels or texels.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Full size in pixels, before cropping.
    pub width: u32,
    /// Full size in pixels, before cropping.
    pub height: u32,
    /// The part that is computed.
    pub crop: Crop,
    /// The filter that spreads samples over pixels; an irradiance meter always uses a box.
    pub filter: ReconstructionFilter,
    /// True if paths from a camera also sample the border that the filter reaches in from (Mitsuba's
    /// `sample_border`).
    pub sample_border: bool,
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Columns left out on the left.
    pub offset_x: u32,
    /// Rows left out above.
    pub offset_y: u32,
    /// Columns kept.
    pub width: u32,
    /// Rows kept.
    pub height: u32,
}

impl Sensor {
    /// Columns and rows of the film's crop: of the maps that methods deliver.
    pub fn size(&self) -> [usize; 2] {
        [
            self.film.crop.width as usize,
            self.film.crop.height as usize,
        ]
    }

    /// The same view on fewer pixels: at most so many along the longer side of the crop.
    pub(crate) fn shrunk_to(&self, side: u32) -> Self {
        let Crop { width, height, .. } = self.film.crop;
        let by = width.max(height).div_ceil(side.max(1)).max(1);
        let less = |pixels: u32| pixels.div_ceil(by);
        let mut small = self.clone();
        let film = &mut small.film;
        (film.width, film.height) = (less(film.width), less(film.height));
        let offset = |at: u32, kept: u32, all: u32| (at / by).min(all - less(kept).min(all));
        film.crop = Crop {
            offset_x: offset(film.crop.offset_x, width, film.width),
            offset_y: offset(film.crop.offset_y, height, film.height),
            width: less(width).min(film.width),
            height: less(height).min(film.height),
        };
        small
    }

    /// True if it sees surfaces from afar, rather than measuring on one.
    #[doc(hidden)]
    pub fn is_camera(&self) -> bool {
        !matches!(self.kind, SensorKind::IrradianceMeter { .. })
    }

    /// The name of Mitsuba's plugin.
    pub fn plugin(&self) -> &'static str {
        match self.kind {
            SensorKind::IrradianceMeter { .. } => "irradiancemeter",
            SensorKind::Perspective(_) => "perspective",
            SensorKind::ThinLens { .. } => "thinlens",
            SensorKind::Orthographic { .. } => "orthographic",
        }
    }
}
