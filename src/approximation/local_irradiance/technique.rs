//! Local precomputed irradiance, as a technique.

use std::path::{Path, PathBuf};

use super::run::Run;
use super::scenery::Kept;
use super::settings::{Settings, TABLE};
use super::size::Size;
use super::variants::STAGES;
use super::{bytes, demands, export};
use crate::approximation::{
    Frame, Prepared, SensorFilm, Stage, TableChoices, TableReport, Technique, Twins,
};
use crate::film::atomic::WriteError;
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

    fn twins(&self) -> Option<Twins> {
        Some(Twins::Error("noise-error"))
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
            bytes: size.bytes(),
            work: vec![
                Counter::new("samples", size.samples),
                Counter::new("photons", size.samples.saturating_mul(settings.photons)),
                Counter::new("bytes of tables", size.tables),
            ],
        }
    }

    fn too_large(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        values: &Values,
        available: u64,
    ) -> Option<String> {
        let settings = Settings::of(values).ok()?;
        Some(Size::refusal(scene, sensor, &settings, available))
    }

    fn keeps_tables(&self, values: &Values) -> Result<(), Refusal> {
        demands::check_kept(&Settings::of(values)?)
    }

    fn within_bytes(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        values: &Values,
        bytes: u64,
        context: &Context,
    ) -> Result<TableChoices, Error> {
        let (settings, given) = (Settings::of(values)?, values.given());
        bytes::choices(scene, sensor, (&settings, given), bytes, context)
    }

    fn keeps_frames(&self, _values: &Values) -> bool {
        true
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

    fn tables(&self) -> TableReport {
        TableReport {
            account: self.kept.account,
            warnings: self
                .kept
                .last
                .as_ref()
                .map_or(Vec::new(), |last| last.warnings.clone()),
        }
    }

    fn export(&self, scene: &Scene, folder: &Path) -> Result<Vec<PathBuf>, WriteError> {
        export::write(&self.settings, &self.kept, scene, folder)
    }

    fn frame(&mut self, scene: &Scene, sensor: &Sensor, context: &Context) -> Result<Frame, Error> {
        let mut run = Run::new(&self.settings, context, scene, sensor)?;
        run.make(&mut self.kept, sensor)?;
        Ok(run.frame(&self.kept))
    }
}
