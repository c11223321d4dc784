//! Caustics volumes, as a technique.

use super::demands::{Volume, check};
use super::photon::{Landing, PHOTON_BYTES, Photon};
use super::run::{Kept, run};
use super::settings::{Settings, TABLE};
use super::splat::Disc;
use super::variants::{Layers, STAGES, Update};
use crate::approximation::{Frame, Prepared, SensorFilm, Stage, Technique};
use crate::run::{Context, Cost, Counter, Error, Light, Refusal, StageWork};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values};

/// Caustics volumes.
#[derive(Clone, Copy, Debug)]
pub struct CausticsVolume;

impl Technique for CausticsVolume {
    fn name(&self) -> &'static str {
        "caustics-volume"
    }

    fn meaning(&self) -> &'static str {
        "Caustics volumes (De Barro et al.): photons marched through slabs of pictures, with their errors"
    }

    fn unit(&self) -> &'static str {
        "photons"
    }

    fn settings(&self) -> &'static [Setting] {
        TABLE
    }

    fn stages(&self) -> &'static [Stage] {
        &STAGES
    }

    fn sweep(&self) -> (&'static str, &'static [&'static str]) {
        ("preset", &["lowest", "middle", "best"])
    }

    fn light(&self, _scene: &Scene, values: &Values) -> Result<Light, Refusal> {
        let max_depth = Settings::of(values)?.max_depth;
        Ok(Light::Specular { max_depth })
    }

    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal> {
        let settings = Settings::of(values)?;
        SensorFilm::new(scene, sensor)?;
        if !sensor.is_camera() && (settings.lod_distance > 0.0 || settings.frustum) {
            return Err(Refusal::new(
                "lod-distance and frustum go by a camera, and the sensor is a meter: allowed are lod-distance=0 and \
                 frustum=false",
            ));
        }
        check(&settings)?;
        Volume::new(scene, &settings)?;
        Ok(())
    }

    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        /// A triple of `f64`.
        const TRIPLE: u64 = 24;
        /// A texel of a picture, as it is kept.
        const TEXEL: u64 = 12;
        /// A triangle as it is drawn.
        const ITEM: u64 = 96;
        let Ok(settings) = Settings::of(values) else {
            return Cost::default();
        };
        let texels = u64::from(sensor.film.crop.width) * u64::from(sensor.film.crop.height);
        // Values twice, points of tiles, exact sums, the estimate's two layers and files.
        let film = texels * (2 * TRIPLE + TRIPLE + 4 * TRIPLE + 6 * TRIPLE);
        let layers = match settings.layers {
            Layers::NearFar => 2,
            Layers::Peel => u64::from(settings.peels),
            Layers::Exact => 0,
        };
        let pictures = u64::from(settings.slabs) * layers + 6;
        let side = u64::from(settings.g_buffer).pow(2);
        let photons = u64::from(settings.photons);
        let states = match settings.update {
            Update::Full => 4,
            Update::Changed => 4 + u64::from(settings.slabs),
        };
        // Landings of frames before.
        let states = states + u64::from(settings.progressive < 1.0 || settings.amortise > 0);
        let photon = states * size_of::<Photon>() as u64
            + (size_of::<Landing>() + size_of::<Disc>()) as u64
            + PHOTON_BYTES;
        let triangles: usize = (scene.world().shapes().iter())
            .map(|shape| match shape {
                crate::geometry::Shape::Mesh(mesh) => mesh.triangle_count(),
                _ => 2,
            })
            .sum();
        Cost {
            bytes: film
                .saturating_add(pictures * side * TEXEL)
                .saturating_add(photons * photon)
                .saturating_add(triangles as u64 * ITEM),
            work: vec![
                Counter::new("photons", photons),
                Counter::new("texels", pictures * side),
                Counter::new("passes", u64::from(settings.slabs) + 1),
            ],
        }
    }

    fn prepare(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        values: &Values,
        _context: &Context,
    ) -> Result<Box<dyn Prepared>, Error> {
        self.supports(scene, sensor, values)?;
        let settings = Settings::of(values)?;
        let kept = Kept::new(scene, &settings)?;
        Ok(Box::new(Ready { settings, kept }))
    }
}

/// A caustics volume with its settings and its last frame.
struct Ready {
    settings: Settings,
    kept: Kept,
}

impl Prepared for Ready {
    fn work(&self) -> &[StageWork] {
        &[]
    }

    fn frame(
        &mut self,
        scene: &Scene,
        sensor: &Sensor,
        _context: &Context,
    ) -> Result<Frame, Error> {
        run(&self.settings, &mut self.kept, scene, sensor)
    }
}
