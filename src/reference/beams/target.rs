//! The sensor that beams fill: a receiver's texels or a camera's pixels.

use glam::DVec2;

use super::error::BeamError;
use crate::geometry::TraversalCounters;
use crate::reference::Quantity;
use crate::scene::{Scene, Sensor, SensorKind};
use crate::transport::camera::Camera;
use crate::transport::receiver::Receiver;
use crate::transport::scatter::ShadingNormals;
use crate::transport::screen::Screen;

/// A sensor, ready to be filled.
///
/// Beams leave flux on the film, of a camera radiance times an [étendue](Screen::Camera).
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
    },
}

impl Target {
    /// The sensor of a scene.
    ///
    /// # Errors
    ///
    /// As [`Receiver::new`] and [`Camera::new`].
    pub fn new(
        scene: &Scene,
        sensor: &Sensor,
        shading_normals: ShadingNormals,
    ) -> Result<Self, BeamError> {
        if matches!(sensor.kind, SensorKind::IrradianceMeter { .. }) {
            return Ok(Self::Receiver(Box::new(Receiver::new(scene, sensor)?)));
        }
        let camera = Camera::new(scene, sensor)?.with_shading_normals(shading_normals);
        let etendue = typical_etendue(scene, &camera);
        let camera = Box::new(camera);
        Ok(Self::Camera { camera, etendue })
    }

    /// What paths fall on.
    pub fn screen(&self) -> Screen<'_> {
        match self {
            Self::Receiver(receiver) => Screen::Receiver(receiver),
            Self::Camera { camera, etendue } => Screen::Camera {
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

    /// What is measured.
    pub fn quantity(&self) -> Quantity {
        match self {
            Self::Receiver(_) => Quantity::Irradiance,
            Self::Camera { .. } => Quantity::Radiance,
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
            let view = camera.pixel_ray((place + 0.5) / f64::from(PLACES) * film);
            let hit = scene
                .world()
                .closest_hit(&view.ray, view.reach, &mut counters)?;
            let point = scene.world().surface_point(&view.ray, &hit);
            // As if light came from the camera.
            let direction = view.ray.direction;
            let seen = camera.connect(scene, hit.shape, &point, direction, &mut counters)?;
            let etendue = 1.0 / seen.radiance_per_flux.mean();
            etendue.is_normal().then_some(etendue)
        })
        .collect();
    seen.sort_by(f64::total_cmp);
    seen.get(seen.len() / 2).copied().unwrap_or(1.0)
}
