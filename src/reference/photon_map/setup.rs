//! A run, set up: light space, layers, and the surfaces that photons are kept on.

use std::collections::BTreeMap;

use super::map::scattering_shapes;
use super::pilot::Pilot;
use super::settings::{MAX_MAP_PHOTONS, PhotonMapSettings, Seen};
use crate::numeric::Stream;
use crate::reference::Target;
use crate::reference::photons::layers::{LayerMap, PILOT_PHOTONS};
use crate::reference::photons::replicate::Job;
use crate::reference::photons::run::{check, check_flux};
use crate::run::{Error, Progress, Refusal};
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;
use crate::transport::bsdf::check_colors;
use crate::transport::camera::Camera;
use crate::transport::domain::LightSpace;

/// A run, set up.
pub struct Setup<'a> {
    pub(super) scene: &'a Scene,
    pub(super) settings: PhotonMapSettings,
    pub(super) target: Target,
    pub(super) light: LightSpace,
    pub(super) map: LayerMap,
    /// True for shapes that scatter, by shape.
    pub(super) scatters: Vec<bool>,
    pub(super) progress: &'a Progress,
}

/// Numbers that keep streams of different use apart.
const PILOT: u64 = 1;
pub(super) const PHOTONS: u64 = 2;
const PIXELS: u64 = 3;

/// Refuses sensors that are no cameras.
///
/// # Errors
///
/// Of an irradiancemeter: with the method for it.
pub fn check_camera(sensor: &Sensor) -> Result<(), Refusal> {
    if sensor.is_camera() {
        return Ok(());
    }
    Err(Refusal::new(format!(
        "sensor \"{}\" is an irradiancemeter: photon maps are for cameras; on a receiver photons are counted in \
         texels, without bias",
        sensor.id
    )))
}

impl<'a> Setup<'a> {
    /// Checks the settings, finds where light can meet specular geometry, and which path signatures are
    /// bright enough for a layer of their own: of all light that they bring to scattering surfaces, seen or
    /// not.
    ///
    /// # Errors
    ///
    /// If a setting is out of range, the sensor is no camera or an emitter is not modelled.
    pub fn new(
        scene: &'a Scene,
        sensor: &Sensor,
        settings: PhotonMapSettings,
        progress: &'a Progress,
    ) -> Result<Self, Error> {
        check(&settings.photons)?;
        let limits = [
            ("radius", settings.radius, 1e-6..=1e6),
            ("alpha", settings.alpha, 1e-3..=1.0),
        ];
        for (name, value, range) in limits {
            if !range.contains(&value) {
                let allowed = format!("{} to {}", range.start(), range.end());
                return Err(SettingError::value(name, &value.to_string(), allowed).into());
            }
        }
        if !(1..=MAX_MAP_PHOTONS).contains(&settings.map_photons) {
            let photons = settings.map_photons.to_string();
            let allowed = format!("1 to {MAX_MAP_PHOTONS}");
            return Err(SettingError::value("map-photons", &photons, allowed).into());
        }
        check_camera(sensor)?;
        let normals = settings.photons.chains.shading_normals;
        let target = Target::new(scene, sensor, normals, |_, it| Camera::of_sensor(it))?;
        check_colors(scene)?;
        let light = LightSpace::new(scene)?;
        check_flux(&light)?;
        let mut setup = Self {
            scene,
            settings,
            target,
            light,
            map: LayerMap::new(Vec::new()),
            scatters: scattering_shapes(scene),
            progress,
        };
        setup.map = setup.pilot();
        Ok(setup)
    }

    /// The light space in which photons start.
    pub fn light(&self) -> &LightSpace {
        &self.light
    }

    /// The camera.
    pub(super) fn camera(&self) -> Option<&Camera> {
        match &self.target {
            Target::Camera { camera, .. } => Some(camera),
            Target::Receiver(_) => None,
        }
    }

    /// Number of layers that are measured.
    pub(super) fn layers(&self) -> usize {
        let kinds = if self.settings.seen == Seen::Anyhow {
            2
        } else {
            1
        };
        kinds * self.map.len()
    }

    /// The first layer of caustics that are seen directly, or by way of mirrors and glass.
    #[inline]
    pub(super) fn first_layer(&self, by_specular: bool) -> usize {
        if by_specular && self.settings.seen == Seen::Anyhow {
            self.map.len()
        } else {
            0
        }
    }

    /// Layers for the signatures that bring most flux to scattering surfaces.
    fn pilot(&self) -> LayerMap {
        let stop = || self.progress.is_stopped();
        let job = self.job(self.stream(PILOT), &stop);
        let scale = job.scale(1.0);
        let found = job.trace(PILOT_PHOTONS, || Pilot {
            scatters: &self.scatters,
            scale,
            received: BTreeMap::new(),
        });
        let mut received = BTreeMap::new();
        for task in found {
            for (signature, flux) in task.recipient.received {
                *received.entry(signature).or_insert(0_i128) += flux;
            }
        }
        LayerMap::of_brightest(received, self.settings.photons.max_layers)
    }

    pub(super) fn stream(&self, purpose: u64) -> Stream {
        let photons = &self.settings.photons;
        Stream::new(photons.stream, photons.seed).split(purpose)
    }

    pub(super) fn pixel_stream(&self) -> Stream {
        self.stream(PIXELS)
    }

    pub(super) fn job<'b>(
        &'b self,
        stream: Stream,
        stop: &'b (dyn Fn() -> bool + Sync),
    ) -> Job<'b> {
        Job {
            scene: self.scene,
            light: &self.light,
            chains: self.settings.photons.chains,
            stream,
            stop,
            finished: &|_| (),
        }
    }
}
