//! Photon maps as a method.

use super::photons::{self, counted, error_line};
use crate::method::memory;
use crate::method::reference::{About, Divisible, InParts, Job, Reference};
use crate::method::rows;
use crate::method::warnings;
use crate::reference::photon_map::setup::{Setup, check_camera};
use crate::reference::photon_map::{PHOTON_BYTES, PhotonMapReport, PhotonMapSettings, Seen};
use crate::run::format::relative;
use crate::run::{Cost, Error, Estimate, Progress, Refusal, Rendering};
use crate::scene::{Scene, Sensor};
use crate::setting::table::row;
use crate::setting::{Kind, Setting, Values, words_of};
use crate::transport::domain::LightSpace;

pub struct PhotonMap;

const LIMITS: &[Setting] = &[rows::ERROR, rows::TIME, rows::PHOTONS];

pub(super) const SETTINGS: &[Setting] = &[
    rows::MAP_PHOTONS,
    rows::RADIUS,
    row!("seen": Kind::Choice(words_of::<Seen>), Value "by-specular", "",
        "Caustics that are measured, by the way in which the camera sees them"),
    rows::MAX_DEPTH,
    rows::SHADING_NORMALS,
    rows::LAYERS,
    rows::replicates(1, "16"),
    rows::SEED,
    rows::SAMPLES,
    rows::SPLIT_DEPTH,
    rows::DIRECT_SAMPLES,
];

/// The settings of photon maps from checked values.
pub(super) fn settings(values: &Values) -> PhotonMapSettings {
    let default = PhotonMapSettings::default();
    PhotonMapSettings {
        photons: photons::settings(values, default.photons),
        map_photons: values.whole("map-photons").unwrap_or(default.map_photons),
        radius: values.number("radius").unwrap_or(default.radius),
        seen: values.word("seen").unwrap_or(default.seen),
        ..default
    }
}

/// Photons that a photon of a map leaves, before a pilot tells: most meet two surfaces that scatter. In
/// closed scenes, or if more events split, a photon may leave more.
pub(super) const MOST_KEPT: f64 = 2.0;

/// Memory \[bytes\] of the photons of a map, each of which is kept on so many surfaces.
pub(super) fn photons_bytes(settings: &PhotonMapSettings, kept: f64) -> u64 {
    let photons = settings.map_photons as f64 * kept;
    (photons * PHOTON_BYTES as f64).ceil() as u64
}

/// What a pilot says of the memory of photon maps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Layers, and those of them that are lit.
    layers: [u64; 2],
    /// The part of the pixels that may be lit.
    pub part: f64,
    /// Surfaces on which a photon is kept.
    pub kept: f64,
}

impl Found {
    /// By a pilot.
    ///
    /// # Errors
    ///
    /// As [`Setup::new`].
    pub fn of(scene: &Scene, sensor: &Sensor, settings: PhotonMapSettings) -> Result<Self, Error> {
        let progress = Progress::default();
        let setup = Setup::new(scene, sensor, settings, &progress)?;
        Ok(Self {
            layers: [setup.layers() as u64, setup.lit_layers() as u64],
            part: setup.seen_part(),
            kept: setup.kept(),
        })
    }

    /// The most that there can be.
    fn most(settings: &PhotonMapSettings) -> Self {
        let kinds = if settings.seen == Seen::Anyhow { 2 } else { 1 };
        Self {
            layers: [kinds * (settings.photons.max_layers as u64 + 1); 2],
            part: 1.0,
            kept: MOST_KEPT,
        }
    }
}

/// Memory \[bytes\] of photon maps.
fn bytes(sensor: &Sensor, settings: &PhotonMapSettings, found: &Found) -> u64 {
    let [layers, lit] = found.layers;
    let film = memory::film(sensor, memory::photon_maps(layers, lit, found.part));
    let run = film.saturating_add(photons_bytes(settings, found.kept));
    // The bias, too.
    memory::with_files(run, sensor, lit + 2, memory::BOTH)
}

const ABOUT: About = About {
    name: "photon-map",
    meaning: "Photon maps: caustics that a camera sees by way of mirrors or glass, with their bias",
    limits: LIMITS,
    work_key: Some("photons"),
    settings: SETTINGS,
    is_of_cameras: true,
};

impl Reference for PhotonMap {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn supports(&self, scene: &Scene, sensor: &Sensor, _values: &Values) -> Result<(), Refusal> {
        check_camera(sensor)?;
        LightSpace::check(scene)?;
        Ok(())
    }

    fn cost(&self, _scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        let settings = settings(values);
        Cost {
            bytes: bytes(sensor, &settings, &Found::most(&settings)),
            work: counted(values),
        }
    }

    fn pilot(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<u64, Error> {
        let settings = settings(values);
        let found = Found::of(scene, sensor, settings)?;
        Ok(bytes(sensor, &settings, &found))
    }

    fn run(&self, job: &Job) -> Result<Rendering, Error> {
        let setup = self.setup(job)?;
        let found = setup.run(job.budget)?;
        Ok(self.rendering(job, &setup, found))
    }

    fn in_parts(&self) -> Option<&dyn InParts> {
        Some(self)
    }
}

impl Divisible for PhotonMap {
    type Setup<'a> = Setup<'a>;

    fn setup<'a>(&self, job: &Job<'a>) -> Result<Setup<'a>, Error> {
        let settings = settings(job.values);
        Setup::new(job.scene, job.sensor, settings, &job.context.progress)
    }

    fn rendering(
        &self,
        job: &Job,
        setup: &Setup,
        (estimate, report): (Estimate, PhotonMapReport),
    ) -> Rendering {
        let settings = settings(job.values);
        let mut warnings = warnings::of_photons(job.scene, setup.light().is_empty());
        if report.passes == 0 {
            warnings.push(warnings::ended_before("pass", "caustic"));
        }
        warnings.extend(warnings::of_camera(
            job.scene,
            &estimate,
            "photon maps",
            true,
        ));
        let [first, last] = report.radius;
        let summary = vec![
            error_line(&estimate),
            format!(
                "{} maps a replicate, radius {first:.3} to {last:.3} pixels; relative bias of their blur: {}",
                report.passes,
                relative(report.relative_bias, false)
            ),
        ];
        let paths = estimate.paths;
        let maps = vec![
            ("bias".to_owned(), report.bias.clone()),
            ("bias.stderr".to_owned(), report.bias_standard_error.clone()),
        ];
        Rendering {
            replicates: Some(settings.photons.replicates),
            summary,
            warnings,
            maps,
            unit: "photons",
            ..Rendering::new(estimate)
                .reporting("photon-map", report)
                .reporting("photons", paths)
                .reporting("seed", settings.photons.seed)
                .reporting("settings", settings)
        }
    }
}
