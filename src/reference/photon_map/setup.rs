//! A run, set up: light space, layers, and the surfaces that photons are kept on.

use std::collections::BTreeMap;

use glam::DVec2;

use super::map::scattering_shapes;
use super::pilot::Pilot;
use super::settings::{MAX_MAP_PHOTONS, PhotonMapSettings, Seen};
use crate::geometry::TraversalCounters;
use crate::numeric::Stream;
use crate::reference::Target;
use crate::reference::photons::layers::LayerMap;
use crate::reference::photons::pilot::PILOT_PHOTONS;
use crate::reference::photons::replicate::Job;
use crate::reference::photons::run::{check, check_flux};
use crate::run::{Error, Progress, Refusal};
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;
use crate::transport::bsdf::check_colors;
use crate::transport::camera::Camera;
use crate::transport::domain::LightSpace;
use crate::transport::path_end::next_hit;

/// A run, set up.
pub struct Setup<'a> {
    pub(in crate::reference) scene: &'a Scene,
    pub(in crate::reference) settings: PhotonMapSettings,
    pub(in crate::reference) target: Target,
    pub(super) light: LightSpace,
    pub(super) map: LayerMap,
    /// True for shapes that scatter, by shape.
    pub(super) scatters: Vec<bool>,
    /// Surfaces on which a photon is kept, in the mean.
    kept: f64,
    pub(in crate::reference) progress: &'a Progress,
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
        let target = Target::new(scene, sensor, normals, |scene, it| {
            Camera::of_sensor(it)?.within(scene, it)
        })?;
        check_colors(scene)?;
        let light = LightSpace::aimed(scene, settings.photons.chains.followed)?;
        check_flux(&light)?;
        let mut setup = Self {
            scene,
            settings,
            target,
            light,
            map: LayerMap::new(Vec::new()),
            scatters: scattering_shapes(scene),
            kept: 0.0,
            progress,
        };
        (setup.map, setup.kept) = setup.pilot();
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
    pub fn layers(&self) -> usize {
        self.kinds() * self.map.len()
    }

    /// Number of these that are likely to have light: where signatures are fewer than they may be, nothing is
    /// left over for those without a layer of their own.
    pub fn lit_layers(&self) -> usize {
        let named = self.map.signatures().len();
        let others = usize::from(named >= self.settings.photons.max_layers);
        self.kinds() * (named + others)
    }

    /// The part of the film, by stretches of pixels that share a page of memory, in which some pixel sees by
    /// way of mirrors or glass; 1 if caustics that are seen directly are measured, too.
    pub fn seen_part(&self) -> f64 {
        /// The camera is asked this many times along each side of its film.
        const PLACES: usize = 64;
        /// Pixels whose exact squares, of three channels, are in a page of 4096 bytes.
        const PAGE: usize = 4096 / (3 * 16);
        let Some(camera) = self
            .camera()
            .filter(|_| self.settings.seen == Seen::BySpecular)
        else {
            return 1.0;
        };
        let film = DVec2::new(camera.width() as f64, camera.height() as f64);
        let is_seen = |place: [usize; 2]| {
            let at = DVec2::from(place.map(|at| (at as f64 + 0.5) / PLACES as f64)) * film;
            let view = camera.pixel_ray(at);
            let found = next_hit(self.scene, view.ray, &mut TraversalCounters::default());
            found.is_some_and(|(_, hit)| {
                let material = self.scene.material_of(hit.shape);
                material.has_delta(self.scene.materials())
            })
        };
        // Pages lie along rows.
        let stretch = (PAGE * PLACES / camera.width().max(1)).clamp(1, PLACES);
        let touched = |row: usize| {
            let seen: Vec<bool> = (0..PLACES).map(|column| is_seen([column, row])).collect();
            let stretches = seen.chunks(stretch);
            let lit = stretches.filter(|stretch| stretch.contains(&true));
            lit.map(<[bool]>::len).sum::<usize>()
        };
        let all: usize = (0..PLACES).map(touched).sum();
        all as f64 / (PLACES * PLACES) as f64
    }

    /// The scene if light of rough interfaces does not count on others.
    pub(super) fn without(&self) -> Option<&Scene> {
        (!self.settings.gloss_on_rough).then_some(self.scene)
    }

    /// Surfaces on which a photon is kept, in the mean, as the pilot found.
    pub fn kept(&self) -> f64 {
        self.kept
    }

    /// Ways in which caustics are seen, that have layers of their own.
    fn kinds(&self) -> usize {
        if self.settings.seen == Seen::Anyhow {
            2
        } else {
            1
        }
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

    /// Layers for the signatures that bring most flux to scattering surfaces, and the number of these on
    /// which a photon is kept, in the mean.
    fn pilot(&self) -> (LayerMap, f64) {
        let stop = || self.progress.is_stopped();
        let job = self.job(self.stream(PILOT), &stop);
        let scale = job.scale(1.0);
        let found = job.trace(PILOT_PHOTONS, || Pilot {
            scatters: &self.scatters,
            scale,
            received: BTreeMap::new(),
            kept: 0,
        });
        let mut received = BTreeMap::new();
        let mut kept = 0;
        for task in found {
            kept += task.recipient.kept;
            for (signature, flux) in task.recipient.received {
                *received.entry(signature).or_insert(0_i128) += flux;
            }
        }
        let map = LayerMap::of_brightest(received, self.settings.photons.max_layers);
        (map, kept as f64 / PILOT_PHOTONS as f64)
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
