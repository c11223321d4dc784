//! Caustic mapping: photons traced in pictures from the light, drawn into a map that is projected back like a shadow map.
//!
//! Wyman and Davis, *Interactive image-space techniques for approximating caustics* (I3D 2006); with splats of variable
//! size: Wyman and Dachsbacher, *Improving image-space caustics via variable-sized splatting* (Technical Report UICS-06-02,
//! 2006), whose sections and equations are cited as such.
//!
//! | stage | file | variants | exact |
//! |---|---|---|---|
//! | `view` | [`buffers`], of [`LightView`](super::LightView) | positions and normals in `f16`, `f32`; 24-bit depths | `f64` |
//! | `refraction` | [`refraction`], of [`interface`](super::interface) | `image-space` | the ray is traced |
//! | `hit` | [`hit`] | `depth-map` | the ray is traced |
//! | `flux` | [`trace`] | `uniform` | by solid angle |
//! | `fresnel` | [`interface`](super::interface) | `none`, `schlick` | Fresnel's equations |
//! | `splat` | [`splat`], [`resolve`]; widths by [`lens`] | Gaussians, fixed or variable | [`footprint`]: beams |
//! | `lookup` | [`lookup`] | `nearest`, `bilinear` | [`project`]: none, light is dealt out to the sensor's own texels |
//!
//! The light that it models is `LTTD`, or `LRD`; total internal reflection, third interfaces and whatever a photon
//! meets on its way after the specular object are not modelled.

pub mod buffers;
mod demands;
pub mod footprint;
pub mod hit;
pub mod lens;
pub mod lookup;
mod photons;
pub mod project;
pub mod refraction;
pub mod resolve;
mod run;
pub mod settings;
pub mod splat;
mod spread;
pub mod trace;
pub mod work;

use super::sources::sources;
use super::{Frame, Prepared, SensorFilm, Stage, Technique};
use crate::run::{Context, Cost, Counter, Error, Light, Refusal, StageWork};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values};
use crate::transport::signature::{Event, Signature};

use demands::{check_outside, mode};
use settings::Mode;
pub use settings::Settings;

/// Caustic mapping.
#[derive(Clone, Copy, Debug)]
pub struct CausticMap;

/// The plural of the technique, in errors.
const MAPS: &str = "caustic maps";

impl CausticMap {
    fn typed(values: &Values) -> Result<Settings, Refusal> {
        Settings::of(values).ok_or_else(|| Refusal::new("settings of another technique"))
    }
}

impl Technique for CausticMap {
    fn name(&self) -> &'static str {
        "caustic-map"
    }

    fn meaning(&self) -> &'static str {
        "Caustic mapping (Wyman and Davis 2006): a real-time approximation, with its errors"
    }

    fn settings(&self) -> &'static [Setting] {
        settings::TABLE
    }

    fn stages(&self) -> &'static [Stage] {
        settings::STAGES
    }

    fn sweep(&self) -> (&'static str, &'static [&'static str]) {
        ("photons", &["128", "256", "512", "1024"])
    }

    fn light(&self, scene: &Scene, values: &Values) -> Result<Light, Refusal> {
        Ok(Light::Path(match mode(&Self::typed(values)?, scene)? {
            Mode::Refraction => Signature::DIRECT
                .then(Event::Transmission)
                .then(Event::Transmission),
            Mode::Reflection => Signature::DIRECT.then(Event::Reflection),
        }))
    }

    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal> {
        SensorFilm::new(scene, sensor)?;
        let mode = mode(&Self::typed(values)?, scene)?;
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
        let photon = (size_of::<splat::Photon>() + size_of::<Option<buffers::Back>>() + 8) as u64;
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
        Ok(Box::new(Ready {
            settings: Self::typed(values)?,
        }))
    }
}

/// Caustic mapping with its settings: nothing outlives a frame.
struct Ready {
    settings: Settings,
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
        run::run(&self.settings, scene, sensor)
    }
}
