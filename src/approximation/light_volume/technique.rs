//! Hierarchical light volumes, as a technique.

use glam::DVec3;

use super::beam::Beam;
use super::cull::Draw;
use super::demands::{check, lights, water};
use super::hull::Hull;
use super::run::{Kept, MIDPOINTS, run};
use super::search::{Drawn, SEARCH_BYTES};
use super::settings::{Settings, TABLE};
use super::shadow::ShadowMap;
use super::stencil::PIXEL_BYTES;
use super::variants::{Inside, STAGES, ShadowCull, TexelPoints, WaterShadow, WaterSurface};
use super::volume::LitVertex;
use super::water::Triangles;
use crate::approximation::sensor::SensorPoint;
use crate::approximation::{Frame, Prepared, SensorFilm, Stage, Technique};
use crate::geometry::SurfacePoint;
use crate::run::cost::{TRIPLE, of_frame, texels};
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
        /// Bytes of `T`.
        const fn bytes<T>() -> u64 {
            size_of::<T>() as u64
        }
        let Ok(settings) = Settings::of(values) else {
            return Cost::default();
        };
        // Of a scene that is refused nothing is known.
        let water = water(scene, &settings).ok();
        let (triangles, vertices) = water.map_or((0, 0), |shape| {
            let all = Triangles::of(&settings, &scene.world().shapes()[shape as usize]);
            (all.count(), all.vertices())
        });
        let lights = scene.emitters().len() as u64;
        let parts = match settings.surface {
            WaterSurface::Triangles => 0,
            WaterSurface::Exact => 4_u64.pow(settings.levels),
        };
        let leaves = (u64::from(settings.buckets) << settings.splits).pow(2);
        let texels = texels(sensor);
        let samples = match settings.lookup {
            TexelPoints::Center => 1,
            TexelPoints::Exact => u64::from(MIDPOINTS).pow(2),
        };
        // Values of all lights and of one. Before cameras beams are drawn on pixels, and on
        // what these see, which comes in rows.
        let of_pixel = 2 * bytes::<Option<SensorPoint>>() + PIXEL_BYTES + 8;
        let is_drawn = sensor.is_camera() && settings.inside == Inside::Stencil;
        let film = texels * (2 * TRIPLE + if is_drawn { of_pixel } else { 0 });
        // The surface, and the light at its vertices with their rays.
        let surface = vertices * (bytes::<SurfacePoint>() + bytes::<DVec3>())
            + triangles * bytes::<[u32; 3]>();
        let lit = vertices * (bytes::<Option<LitVertex>>() + 8);
        // Beams, marked, drawn with their parts, and searched.
        let beam = bytes::<Option<Beam>>();
        let drawn = beam + 1 + bytes::<Draw>() + parts * bytes::<Beam>();
        let drawn = drawn + parts.max(1) * (bytes::<Drawn>() + SEARCH_BYTES);
        // Coarser water has its own surface.
        let surfaces = 1 + u64::from(settings.lod > 0.0);
        let beams = triangles.saturating_mul(drawn);
        // Depths of each view, and counts of them.
        let is_mapped =
            settings.shadow == WaterShadow::Vertex || settings.shadow_cull == ShadowCull::Hierarchy;
        let views = water
            .filter(|_| is_mapped)
            .map_or(0, |shape| ShadowMap::most_views(scene, shape));
        let map = (8 + 4) * u64::from(settings.shadow_map).pow(2) * views;
        // The hierarchy: where each leaf begins, its triangles, and its hulls on all levels.
        let tree = 4 * (leaves + triangles);
        let hulls = leaves * bytes::<Option<Hull>>() * 4 / 3;
        let stages = film
            .saturating_add(surfaces * surface + lit + beams)
            .saturating_add(map + surfaces * tree + hulls);
        Cost {
            bytes: of_frame(sensor, stages, tree),
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

    fn frame(&mut self, scene: &Scene, sensor: &Sensor, context: &Context) -> Result<Frame, Error> {
        let progress = &context.progress;
        run(&self.settings, &mut self.kept, scene, sensor, progress)
    }
}
