//! Caustics volumes, as a technique.

use std::time::Instant;

use glam::DVec3;

use super::advice::Pilot;
use super::cuboid::Face;
use super::demands::{Volume, check, is_specular};
use super::ellipse::PLACE_BYTES;
use super::photon::{Landing, Photon};
use super::run::{Kept, run};
use super::settings::{Settings, TABLE};
use super::splat::Disc;
use super::variants::{Interface, Layers, STAGES, Splat, Step, Update};
use super::warnings::{idle, on_shapes};
use crate::approximation::{Frame, Prepared, SensorFilm, Stage, Technique, Twins};
use crate::run::cost::{TRIPLE, of_frame, texels};
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
        /// A texel of a picture, as it is kept.
        const TEXEL: u64 = 12;
        /// A triangle as it is drawn.
        const ITEM: u64 = 96;
        /// Bytes of `T`.
        const fn bytes<T>() -> u64 {
            size_of::<T>() as u64
        }
        let Ok(settings) = Settings::of(values) else {
            return Cost::default();
        };
        let texels = texels(sensor);
        // Values, and exact sums, or smoothed ones.
        let film = texels * 2 * TRIPLE;
        let layers = match settings.layers {
            Layers::NearFar => 2,
            Layers::Peel => u64::from(settings.peels),
            Layers::Exact => 0,
        };
        let pictures = u64::from(settings.slabs) * layers + 6;
        let side = u64::from(settings.g_buffer).pow(2);
        let photons = u64::from(settings.photons);
        // The queue before each slab is kept, with what landed by then, for the frame after.
        let queue = bytes::<Photon>() + bytes::<Landing>();
        let queues = match settings.update {
            Update::Full => 0,
            Update::Changed => u64::from(settings.slabs) + 1,
        };
        // Landings of frames before.
        let before = u64::from(settings.shares > 1 || settings.amortise > 0) * bytes::<Landing>();
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
        // A pass has photons before a slab, in chunks and joined as they leave it, and before the next one.
        // Of the projectors' pass photons land, in chunks and joined. Then landings are drawn.
        let out = bytes::<(Face, Photon)>();
        let pass = 2 * bytes::<Photon>() + 2 * out;
        let landing = bytes::<Photon>() + 2 * bytes::<Landing>();
        let drawing = bytes::<Landing>() + bytes::<Disc>() + 2 * bytes::<DVec3>();
        let places = if settings.splat == Splat::Ellipses {
            PLACE_BYTES
        } else {
            0
        };
        let kept = photons * (queues * queue + before);
        let photon = pass.max(landing).max(drawing + places);
        let triangles: usize = (scene.world().shapes().iter())
            .map(|shape| match shape {
                crate::geometry::Shape::Mesh(mesh) => mesh.triangle_count(),
                _ => 2,
            })
            .sum();
        let pictures = pictures * side * TEXEL;
        let stages = film
            .saturating_add(pictures + kept)
            .saturating_add(photons * photon + tiles)
            .saturating_add(triangles as u64 * ITEM);
        let beside = kept + if queues > 0 { pictures } else { 0 };
        Cost {
            bytes: of_frame(sensor, stages, beside),
            work: vec![
                Counter::new("photons", u64::from(settings.photons)),
                Counter::new("texels", pictures / TEXEL),
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
