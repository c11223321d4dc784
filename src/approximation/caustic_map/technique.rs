//! Caustic mapping, as a technique.

use super::demands::{MAPS, check_outside, mode};
use super::run::{self, LightBuffers, buffers, bytes_of_stages};
use super::settings::{self, Settings};
use super::variants::{Mode, STAGES};
use crate::approximation::sources::sources;
use crate::approximation::{Frame, Prepared, SensorFilm, Stage, Technique};
use crate::run::cost::{TRIPLE, of_frame, texels};
use crate::run::{Context, Cost, Counter, Error, Light, Progress, Refusal, StageWork};
use crate::scene::{Scene, Sensor, SensorKind};
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
        let Ok(settings) = Settings::of(values) else {
            return Cost::default();
        };
        let side = |key| values.whole::<u64>(key).unwrap_or(0).pow(2);
        let lights = scene.emitters().len() as u64;
        // Of a scene that is refused nothing is known.
        let stages = stages(&settings, scene, sensor, 1.0).unwrap_or(0);
        Cost {
            bytes: of_frame(sensor, stages, 0),
            work: vec![
                Counter::new("photons", side("photons") * lights),
                Counter::new("texels of the map", side("map") * lights),
            ],
        }
    }

    fn pilot(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<u64, Error> {
        /// Photons along each side of the pilot's buffer.
        const SIDE: u32 = 64;
        let settings = Settings::of(values)?;
        let small = Settings {
            photons: SIDE,
            frames: 1,
            ..settings.clone()
        };
        let mode = mode(&settings, scene)?;
        // A few texels: it is photons that are counted.
        let few = sensor.shrunk_to(8);
        let frame = run::run(&small, mode, scene, &few, &Progress::default())?;
        let lit: u64 = buffers_of(&small, mode, scene, sensor)?
            .iter()
            .map(|light| light.maps * light.photons)
            .sum();
        let part = frame.counters.get("splats") as f64 / lit.max(1) as f64;
        let stages = stages(&settings, scene, sensor, part.min(1.0))?;
        Ok(of_frame(sensor, stages, 0))
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

/// The buffers of a frame on a sensor.
fn buffers_of(
    settings: &Settings,
    mode: Mode,
    scene: &Scene,
    sensor: &Sensor,
) -> Result<Vec<LightBuffers>, Refusal> {
    let measured = match sensor.kind {
        SensorKind::IrradianceMeter { shape } => Some(shape.0),
        _ => None,
    };
    buffers(settings, mode, scene, measured)
}

/// Memory \[bytes\] of the stages of a frame, of whose photons that may land a part does.
fn stages(settings: &Settings, scene: &Scene, sensor: &Sensor, part: f64) -> Result<u64, Refusal> {
    let mode = mode(settings, scene)?;
    let mut buffers = buffers_of(settings, mode, scene, sensor)?;
    for light in &mut buffers {
        for photons in [&mut light.photons, &mut light.largest] {
            *photons = (*photons as f64 * part).ceil() as u64;
        }
    }
    let texels = texels(sensor);
    // Values of all frames so far, and of one.
    let values = 2 * TRIPLE * texels;
    let stages = bytes_of_stages(settings, mode, scene, texels, &buffers);
    Ok(stages.saturating_add(values))
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
