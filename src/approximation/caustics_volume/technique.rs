//! Caustics volumes, as a technique.

use std::time::Instant;

use super::advice::Pilot;
use super::demands::{Volume, check, is_specular};
use super::ellipse::PLACE_BYTES;
use super::photon::{Landing, PHOTON_BYTES, Photon};
use super::run::{Kept, run};
use super::settings::{Settings, TABLE};
use super::splat::Disc;
use super::variants::{Interface, Layers, STAGES, Splat, Step, Update};
use super::warnings::{idle, on_shapes};
use crate::approximation::{Frame, Prepared, SensorFilm, Stage, Technique, Twins};
use crate::run::{Context, Cost, Counter, Error, Light, Refusal, StageWork};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values, Words};

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

    fn twins(&self) -> Option<Twins> {
        Some(Twins::Halvings("border-levels"))
    }

    fn light(&self, _scene: &Scene, values: &Values) -> Result<Light, Refusal> {
        let max_depth = Settings::of(values)?.max_depth;
        Ok(Light::Specular { max_depth })
    }

    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal> {
        let settings = Settings::of(values)?;
        let film = SensorFilm::new(scene, sensor)?;
        if let Some(shape) = film.shape().filter(|shape| is_specular(scene, *shape)) {
            return Err(Refusal::new(format!(
                "the sensor is on shape \"{}\", which mirrors or refracts: photons land on what does neither",
                scene.objects()[shape as usize].id
            )));
        }
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
        let states = states + u64::from(settings.shares > 1 || settings.amortise > 0);
        // Photons that part in two or three.
        let ways = match settings.interface {
            Interface::Exact => 3,
            Interface::Refract
            | Interface::MirrorTotal
            | Interface::Schlick
            | Interface::Fresnel => 1,
        };
        let photons = photons * ways;
        let tiles = 24 * u64::from(settings.g_buffer.div_ceil(settings.tile)).pow(2);
        let photon = states * (size_of::<Photon>() + size_of::<Landing>()) as u64
            + (size_of::<Landing>() + size_of::<Disc>() + 64) as u64
            + if settings.splat == Splat::Ellipses {
                PLACE_BYTES
            } else {
                0
            }
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
                .saturating_add(photons * photon + tiles)
                .saturating_add(triangles as u64 * ITEM),
            work: vec![
                Counter::new("photons", u64::from(settings.photons)),
                Counter::new("texels", pictures * side),
                Counter::new("passes", u64::from(settings.slabs) + 1),
            ],
        }
    }

    fn advice(&self, scene: &Scene, values: &Values) -> Result<Vec<String>, Error> {
        let settings = Settings::of(values)?;
        let volume = Volume::new(scene, &settings)?;
        let pilot = Pilot::new(scene, &settings, &volume);
        let mut said = pilot.account();
        said.extend(pilot.advice());
        Ok(said)
    }

    fn keeps_frames(&self, values: &Values) -> bool {
        Settings::of(values).is_ok_and(|it| it.update == Update::Changed || it.trails())
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
        let mut warnings = idle(&settings, values);
        warnings.extend(on_shapes(scene, &settings, kept.volume()));
        let start = Instant::now();
        let pilot = Pilot::new(scene, &settings, kept.volume());
        warnings.extend(pilot.advice());
        let mut work = StageWork::new(Step::Layers.word());
        "pilot".clone_into(&mut work.pass);
        work.work.add("photons", pilot.photons());
        work.seconds = start.elapsed().as_secs_f64();
        Ok(Box::new(Ready {
            settings,
            kept,
            warnings,
            work: vec![work],
        }))
    }
}

/// A caustics volume with its settings and its last frame.
struct Ready {
    settings: Settings,
    kept: Kept,
    /// Of the scene that it was prepared for.
    warnings: Vec<String>,
    work: Vec<StageWork>,
}

impl Prepared for Ready {
    fn work(&self) -> &[StageWork] {
        &self.work
    }

    fn frame(&mut self, scene: &Scene, sensor: &Sensor, context: &Context) -> Result<Frame, Error> {
        let progress = &context.progress;
        let mut frame = run(&self.settings, &mut self.kept, scene, sensor, progress)?;
        frame.warnings.extend(self.warnings.iter().cloned());
        Ok(frame)
    }
}
