//! Caustic mapping, as a technique.

use super::buffers::Back;
use super::demands::{MAPS, check_outside, mode};
use super::run;
use super::settings::{self, Settings};
use super::splat::Photon;
use super::variants::{Mode, STAGES};
use crate::approximation::sources::sources;
use crate::approximation::{Frame, Prepared, SensorFilm, Stage, Technique};
use crate::run::{Context, Cost, Counter, Error, Light, Refusal, StageWork};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values};
use crate::transport::signature::{Event, Signature};

/// Caustic mapping.
#[derive(Clone, Copy, Debug)]
pub struct CausticMap;

impl Technique for CausticMap {
    fn name(&self) -> &'static str {
        "caustic-map"
    }

    fn meaning(&self) -> &'static str {
        "Caustic mapping (Wyman and Davis 2006): a real-time approximation, with its errors"
    }

    fn unit(&self) -> &'static str {
        "photons"
    }

    fn settings(&self) -> &'static [Setting] {
        settings::TABLE
    }

    fn stages(&self) -> &'static [Stage] {
        &STAGES
    }

    fn sweep(&self) -> (&'static str, &'static [&'static str]) {
        ("photons", &["128", "256", "512", "1024"])
    }

    fn light(&self, scene: &Scene, values: &Values) -> Result<Light, Refusal> {
        Ok(Light::Path(match mode(&Settings::of(values)?, scene)? {
            Mode::Refraction => Signature::DIRECT
                .then(Event::Transmission)
                .then(Event::Transmission),
            Mode::SingleRefraction => Signature::DIRECT.then(Event::Transmission),
            Mode::Reflection => Signature::DIRECT.then(Event::Reflection),
        }))
    }

    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal> {
        SensorFilm::new(scene, sensor)?;
        let mode = mode(&Settings::of(values)?, scene)?;
        let sources = sources(scene, MAPS)?;
        if mode == Mode::Refraction {
            check_outside(scene, &sources)?;
        }
        Ok(())
    }

    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        /// A triple of `f64`.
        const TRIPLE: u64 = 24;
        let side = |key| values.whole::<u64>(key).unwrap_or(0).pow(2);
        let lights = scene.emitters().len() as u64;
        let texels = u64::from(sensor.film.crop.width) * u64::from(sensor.film.crop.height);
        // Exact sums, values of two frames, the estimate's two layers and files.
        let film = texels * (TRIPLE + 2 * TRIPLE + 4 * TRIPLE + 6 * TRIPLE);
        // Photons as they are drawn, back faces, depths; flux by texel.
        let photon = (2 * size_of::<Photon>() + size_of::<Option<Back>>() + 8) as u64;
        let maps = lights * (side("photons") * photon + side("map") * TRIPLE);
        Cost {
            bytes: film.saturating_add(maps),
            work: vec![
                Counter::new("photons", side("photons") * lights),
                Counter::new("texels of the map", side("map") * lights),
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
        let mode = mode(&settings, scene)?;
        Ok(Box::new(Ready { settings, mode }))
    }
}

/// Caustic mapping with its settings: nothing outlives a frame.
struct Ready {
    settings: Settings,
    mode: Mode,
}

impl Prepared for Ready {
    fn work(&self) -> &[StageWork] {
        &[]
    }

    fn frame(&mut self, scene: &Scene, sensor: &Sensor, context: &Context) -> Result<Frame, Error> {
        run::run(&self.settings, self.mode, scene, sensor, &context.progress)
    }
}
