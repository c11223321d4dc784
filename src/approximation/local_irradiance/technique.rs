//! Local precomputed irradiance, as a technique.

use super::demands;
use super::run::Run;
use super::scenery::Kept;
use super::settings::{Settings, TABLE};
use super::storage::bytes_each;
use super::variants::{Directions, STAGES, SampleAt, Space, Symmetry, Tables, Tree};
use crate::approximation::{Frame, Prepared, SensorFilm, Stage, Technique};
use crate::run::{Context, Cost, Counter, Error, Light, Refusal, StageWork};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values};

/// Local precomputed irradiance.
#[derive(Clone, Copy, Debug)]
pub struct LocalIrradiance;

impl Technique for LocalIrradiance {
    fn name(&self) -> &'static str {
        "local-irradiance"
    }

    fn meaning(&self) -> &'static str {
        "Local precomputed irradiance (Wyman, Hansen and Shirley): tables around an object, with their errors"
    }

    fn unit(&self) -> &'static str {
        "queries"
    }

    fn settings(&self) -> &'static [Setting] {
        TABLE
    }

    fn stages(&self) -> &'static [Stage] {
        &STAGES
    }

    fn sweep(&self) -> (&'static str, &'static [&'static str]) {
        ("cells", &["16", "32", "64", "128"])
    }

    fn light(&self, _scene: &Scene, values: &Values) -> Result<Light, Refusal> {
        let max_depth = Settings::of(values)?.max_depth;
        Ok(Light::Specular { max_depth })
    }

    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal> {
        let settings = Settings::of(values)?;
        let film = SensorFilm::new(scene, sensor)?;
        demands::samples(&settings)?;
        demands::of_scene(scene, &film, &settings).map(|_| ())
    }

    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        let Ok(settings) = Settings::of(values) else {
            return Cost::default();
        };
        let size = Size::new(scene, sensor, &settings);
        Cost {
            bytes: size
                .film
                .saturating_add(size.tables)
                .saturating_add(size.scratch),
            work: vec![
                Counter::new("samples", size.samples),
                Counter::new("photons", size.samples.saturating_mul(settings.photons)),
                Counter::new("bytes of tables", size.tables),
            ],
        }
    }

    fn prepare(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        values: &Values,
        context: &Context,
    ) -> Result<Box<dyn Prepared>, Error> {
        let settings = Settings::of(values)?;
        let mut kept = Kept::default();
        let mut run = Run::new(&settings, context, scene, sensor)?;
        run.make(&mut kept, sensor)?;
        let work = run.work();
        Ok(Box::new(Ready {
            settings,
            kept,
            work,
        }))
    }
}

/// Memory \[bytes\] of a run, and its samples.
struct Size {
    film: u64,
    tables: u64,
    scratch: u64,
    samples: u64,
}

impl Size {
    fn new(scene: &Scene, sensor: &Sensor, settings: &Settings) -> Self {
        /// A triple of `f64`.
        const TRIPLE: u64 = 24;
        let texels = u64::from(sensor.film.crop.width) * u64::from(sensor.film.crop.height);
        let lights = scene.emitters().len() as u64;
        let f = u64::from(settings.frequency);
        let all = match (settings.directions, settings.symmetry) {
            (Directions::Exact, _) => lights,
            (_, Symmetry::Sphere) => 1,
            (_, Symmetry::Axis) => u64::from(settings.axis_samples),
            (_, Symmetry::None) => match settings.sample_at {
                SampleAt::Vertices => 10 * f * f + 2,
                SampleAt::Centres => 20 * f * f,
            },
        };
        let is_fitted = settings.directions == Directions::Harmonics;
        let needed = match settings.tables {
            Tables::Needed if !is_fitted => all.min(3 * lights),
            _ => all,
        };
        let cells = match super::layout::kind(settings) {
            None => texels,
            Some(Tree::Grid) => u64::from(settings.cells).pow(3),
            Some(Tree::Shells) => u64::from(settings.shells) * (20 << (2 * settings.shell_level)),
        };
        let coefficients = u64::from(settings.order).pow(2);
        let kept = if is_fitted {
            cells * coefficients * bytes_each(settings.storage)
        } else {
            let numbers = match settings.space {
                Space::ShellHarmonics => u64::from(settings.shells) * coefficients,
                _ => cells,
            };
            needed * numbers * bytes_each(settings.storage)
        };
        let fitted = if is_fitted {
            cells * coefficients * TRIPLE
        } else {
            0
        };
        Self {
            film: texels * (TRIPLE + 4 * TRIPLE + 6 * TRIPLE),
            tables: kept,
            // Sums of each thread, and values of a sample.
            scratch: (rayon::current_num_threads() as u64 + 2) * cells * TRIPLE + fitted,
            samples: needed,
        }
    }
}

/// Tables with their settings.
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
        let mut run = Run::new(&self.settings, context, scene, sensor)?;
        run.make(&mut self.kept, sensor)?;
        run.frame(&self.kept)
    }
}
