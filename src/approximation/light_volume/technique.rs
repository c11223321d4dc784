//! Hierarchical light volumes, as a technique.

use super::demands::{check, lights, water};
use super::run::{Kept, MIDPOINTS, run};
use super::settings::{Settings, TABLE};
use super::variants::{STAGES, TexelPoints, WaterSurface};
use super::water::Triangles;
use crate::approximation::{Frame, Prepared, SensorFilm, Stage, Technique};
use crate::run::{Context, Cost, Counter, Error, Light, Refusal, StageWork};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values};
use crate::transport::signature::{Event, Signature};

/// Hierarchical light volumes.
#[derive(Clone, Copy, Debug)]
pub struct LightVolume;

impl Technique for LightVolume {
    fn name(&self) -> &'static str {
        "light-volume"
    }

    fn meaning(&self) -> &'static str {
        "Hierarchical light volumes (Barczak and Olano): real-time caustics of water, with their errors"
    }

    fn unit(&self) -> &'static str {
        "beams"
    }

    fn settings(&self) -> &'static [Setting] {
        TABLE
    }

    fn stages(&self) -> &'static [Stage] {
        &STAGES
    }

    fn sweep(&self) -> (&'static str, &'static [&'static str]) {
        ("grid", &["60", "120", "200"])
    }

    fn light(&self, _scene: &Scene, _values: &Values) -> Result<Light, Refusal> {
        Ok(Light::Path(Signature::DIRECT.then(Event::Transmission)))
    }

    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal> {
        let settings = Settings::of(values)?;
        SensorFilm::new(scene, sensor)?;
        check(&settings)?;
        lights(scene, water(scene, &settings)?)?;
        Ok(())
    }

    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        /// Bytes of a beam with its draws, lists and parts of hulls.
        const BEAM: u64 = 640;
        /// Bytes of the vertices of a triangle: three, if normals are those of facets.
        const VERTICES: u64 = 3 * 448;
        /// A triple of `f64`.
        const TRIPLE: u64 = 24;
        let Ok(settings) = Settings::of(values) else {
            return Cost::default();
        };
        let triangles = water(scene, &settings).map_or(0, |shape| {
            Triangles::of(&settings, &scene.world().shapes()[shape as usize]).count()
        });
        let lights = scene.emitters().len() as u64;
        let parts = match settings.surface {
            WaterSurface::Triangles => 1,
            WaterSurface::Exact => 1 + 4_u64.pow(settings.levels),
        };
        let leaves = (u64::from(settings.buckets) << settings.splits).pow(2);
        let texels = u64::from(sensor.film.crop.width) * u64::from(sensor.film.crop.height);
        // Exact sums or a stencil buffer with the points that are seen, values of two lights, the estimate's
        // two layers and files.
        let film = texels * (16 * TRIPLE + 2 * TRIPLE + 4 * TRIPLE + 6 * TRIPLE);
        let beams = triangles.saturating_mul(parts).saturating_mul(BEAM) + triangles * VERTICES;
        let map = 12 * u64::from(settings.shadow_map).pow(2) * 6;
        let samples = match settings.lookup {
            TexelPoints::Center => 1,
            TexelPoints::Exact => u64::from(MIDPOINTS).pow(2),
        };
        Cost {
            bytes: film
                .saturating_add(beams)
                .saturating_add(map + 128 * leaves),
            work: vec![
                Counter::new("beams", triangles.saturating_mul(lights)),
                Counter::new("points", texels.saturating_mul(samples)),
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
        let start = std::time::Instant::now();
        let kept = Kept::new(scene, water(scene, &settings)?, &settings);
        let mut work = StageWork::new(STAGES[0].name);
        work.work.add("nodes", u64::from(kept.tree().all_nodes()));
        work.seconds = start.elapsed().as_secs_f64();
        Ok(Box::new(Ready {
            settings,
            kept,
            work: vec![work],
        }))
    }
}

/// Light volumes with their settings and the hierarchy.
struct Ready {
    settings: Settings,
    kept: Kept,
    work: Vec<StageWork>,
}

impl Prepared for Ready {
    fn work(&self) -> &[StageWork] {
        &self.work
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
