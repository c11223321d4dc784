//! The sensor that photons and beams fill: a receiver's texels or a camera's pixels.

use glam::DVec2;

use crate::film::PixelFilter;
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::run::{Quantity, Refusal};
use crate::scene::{
    Color, Material, ReconstructionFilter, Scene, Sensor, SensorKind, is_achromatic,
};
use crate::transport::camera::{Camera, CameraError};
use crate::transport::receiver::Receiver;
use crate::transport::scatter::ShadingNormals;
use crate::transport::screen::Screen;

/// A sensor, ready to be filled.
///
/// Light leaves flux on the film, of a camera radiance times an [étendue](Screen::Camera).
#[derive(Debug)]
pub enum Target {
    /// Texels on a surface.
    Receiver(Box<Receiver>),
    /// Pixels.
    Camera {
        /// The camera.
        camera: Box<Camera>,
        /// The étendue of a typical pixel [m² sr].
        etendue: f64,
        /// The weights of pixels that look beyond their borders; `None` if pixels are plain averages.
        filter: Option<Box<PixelFilter>>,
    },
}

/// The texels that light reaches, to whose mean errors are relative.
#[derive(Clone, Copy, Debug)]
pub struct LitTexels {
    /// Their number.
    pub texels: f64,
    /// Their mean, in the target's quantity.
    pub mean: f64,
}

impl LitTexels {
    /// The same with more light on them, all texels together.
    #[must_use]
    pub fn and(self, light: f64) -> Self {
        Self {
            mean: self.mean + light / self.texels,
            ..self
        }
    }

    /// The relative error, given the sum over texels of squared errors.
    pub fn relative_error(&self, squares: f64) -> f64 {
        (squares / self.texels).sqrt() / self.mean
    }
}

impl Target {
    /// The sensor of a scene. What a camera may be is the method's to say: `camera_of` is
    /// [`Camera::new`], or a constructor that allows more.
    ///
    /// # Errors
    ///
    /// As [`Receiver::new`] and `camera_of`.
    pub fn new(
        scene: &Scene,
        sensor: &Sensor,
        shading_normals: ShadingNormals,
        camera_of: impl FnOnce(&Scene, &Sensor) -> Result<Camera, CameraError>,
    ) -> Result<Self, Refusal> {
        if matches!(sensor.kind, SensorKind::IrradianceMeter { .. }) {
            return Ok(Self::Receiver(Box::new(Receiver::new(scene, sensor)?)));
        }
        let camera = camera_of(scene, sensor)?.with_shading_normals(shading_normals);
        let etendue = typical_etendue(scene, &camera);
        let is_plain = camera.filter() == ReconstructionFilter::Box;
        let filter = (!is_plain).then(|| Box::new(camera.pixel_filter()));
        let camera = Box::new(camera);
        Ok(Self::Camera {
            camera,
            etendue,
            filter,
        })
    }

    /// What paths fall on.
    pub fn screen(&self) -> Screen<'_> {
        match self {
            Self::Receiver(receiver) => Screen::Receiver(receiver),
            Self::Camera {
                camera, etendue, ..
            } => Screen::Camera {
                camera,
                etendue: *etendue,
            },
        }
    }

    /// Columns and rows of the film.
    pub fn size(&self) -> [usize; 2] {
        self.screen().size()
    }

    /// How many texels or pixels.
    pub fn texels(&self) -> usize {
        let [width, height] = self.size();
        width * height
    }

    /// The weights of a camera's pixels that look beyond their borders; `None` if light counts in the texel
    /// or pixel where it falls.
    pub fn filter(&self) -> Option<&PixelFilter> {
        match self {
            Self::Receiver(_) => None,
            Self::Camera { filter, .. } => filter.as_deref(),
        }
    }

    /// What is measured.
    pub fn quantity(&self) -> Quantity {
        match self {
            Self::Receiver(_) => Quantity::Irradiance,
            Self::Camera { .. } => Quantity::Radiance,
        }
    }

    /// Whether one channel can stand for red, green and blue: a camera shows the colours of what it sees,
    /// too.
    pub fn is_achromatic(&self, scene: &Scene) -> bool {
        let is_grey = |material: &Material| match material {
            Material::Diffuse {
                reflectance: Color::Constant(reflectance),
            } => reflectance.is_grey(),
            Material::Diffuse { .. }
            | Material::Plastic(_)
            | Material::RoughPlastic { .. }
            | Material::Principled(_)
            | Material::PrincipledThin(_)
            | Material::RoughConductor { .. }
            | Material::RoughDielectric { .. }
            | Material::Turned { .. } => false,
            _ => true,
        };
        is_achromatic(scene)
            && match self {
                Self::Receiver(_) => true,
                Self::Camera { .. } => scene.materials().iter().all(is_grey),
            }
    }

    /// Number of channels that light is followed in: 1 or 3.
    pub fn channels(&self, scene: &Scene) -> u8 {
        if self.is_achromatic(scene) { 1 } else { 3 }
    }

    /// How many times the light's whole flux sums of one texel must have room for.
    ///
    /// A receiver's texel gets no more than all of it. What a pixel counts is flux by the
    /// [étendue](Screen::Camera) of a typical one over its own, which grows with the squared distance: a
    /// surface 256 times nearer than the typical one has room. Beyond, sums say that they overflow.
    pub fn headroom(&self) -> f64 {
        match self {
            Self::Receiver(_) => 1.0,
            Self::Camera { .. } => 65536.0,
        }
    }

    /// What the film's sum is divided by: the texel's area \[m²\] or the pixels' étendue [m² sr]; 0
    /// for a texel without any surface.
    pub fn measure(&self, texel: usize) -> f64 {
        match self {
            Self::Receiver(receiver) => receiver.texel_area(texel),
            Self::Camera { etendue, .. } => *etendue,
        }
    }

    /// What a texel gains from flux that falls where its middle is: 1 / area \[1/m²\], or a pixel's radiance
    /// by flux \[1/(m² sr)\]; that of a typical pixel where a camera sees nothing in the middle, and nothing
    /// for a texel without a surface.
    pub fn gain(&self, scene: &Scene, texel: usize) -> Rgb {
        let typical = match self.measure(texel) {
            0.0 => Rgb::BLACK,
            measure => Rgb::grey(1.0 / measure),
        };
        let Self::Camera { camera, .. } = self else {
            return typical;
        };
        let width = self.size()[0];
        let corner = DVec2::new((texel % width) as f64, (texel / width) as f64);
        let mut counters = TraversalCounters::default();
        radiance_per_flux(scene, camera, corner + 0.5, &mut counters).unwrap_or(typical)
    }
}

/// Of the pixel at film coordinates, for light that falls where its view ends; as if it came from the camera.
fn radiance_per_flux(
    scene: &Scene,
    camera: &Camera,
    at: DVec2,
    counters: &mut TraversalCounters,
) -> Option<Rgb> {
    let view = camera.pixel_ray(at);
    let hit = scene.world().closest_hit(&view.ray, view.reach, counters)?;
    let point = scene.world().surface_point(&view.ray, &hit);
    let seen = camera.connect(scene, &hit, &point, view.ray.direction, counters)?;
    Some(seen.radiance_per_flux)
}

/// The camera is asked this many times along each side of its film.
const PLACES: u32 = 32;

/// The étendue of a typical pixel [m² sr]: the median of flux by radiance over what the camera
/// sees; 1 where it sees nothing that could be lit. It is a unit for sums, and has no influence on results
/// beyond rounding and the choice of what to refine.
fn typical_etendue(scene: &Scene, camera: &Camera) -> f64 {
    let film = DVec2::new(camera.width() as f64, camera.height() as f64);
    let mut counters = TraversalCounters::default();
    let mut seen: Vec<f64> = (0..PLACES * PLACES)
        .filter_map(|index| {
            let place = DVec2::new(f64::from(index % PLACES), f64::from(index / PLACES));
            let at = (place + 0.5) / f64::from(PLACES) * film;
            let gain = radiance_per_flux(scene, camera, at, &mut counters)?;
            let etendue = 1.0 / gain.mean();
            etendue.is_normal().then_some(etendue)
        })
        .collect();
    seen.sort_by(f64::total_cmp);
    seen.get(seen.len() / 2).copied().unwrap_or(1.0)
}
