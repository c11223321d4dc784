//! Photon maps as a method.

use super::photons::{self, counted, error_line};
use crate::method::memory;
use crate::method::reference::{About, Job, Reference};
use crate::method::rows;
use crate::method::warnings;
use crate::reference::photon_map::setup::{Setup, check_camera};
use crate::reference::photon_map::{PhotonMapSettings, Seen};
use crate::run::format::relative;
use crate::run::{Cost, Error, Refusal, Rendering};
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
        LightSpace::new(scene)?;
        Ok(())
    }

    fn cost(&self, _scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        /// A photon with its place in the tree, and its ends: most meet two surfaces that scatter.
        const PHOTON: u64 = 2 * 128;
        let settings = settings(values);
        let film = memory::photon_maps(settings.photons.max_layers as u64);
        Cost {
            bytes: memory::film(sensor, film) + PHOTON * settings.map_photons,
            work: counted(values),
        }
    }

    fn run(&self, job: &Job) -> Result<Rendering, Error> {
        let settings = settings(job.values);
        let setup = Setup::new(job.scene, job.sensor, settings, &job.context.progress)?;
        let mut warnings = warnings::of_chains(job.scene, setup.light().is_empty());
        let (estimate, report) = setup.run(job.budget)?;
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
        Ok(Rendering {
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
        })
    }
}
