//! All methods together, as a method.

use super::{beams, path, photon_map, photons};
use crate::method::memory;
use crate::method::reference::{About, Job, Reference};
use crate::method::rows;
use crate::method::warnings;
use crate::reference::full::{self, FullReport, FullSettings, PartDetail, PartReport, Plan};
use crate::reference::photons::PhotonSettings;
use crate::run::format::relative;
use crate::run::{Cost, Error, Estimate, Refusal, Rendering};
use crate::scene::{Integrator, Scene, Sensor};
use crate::setting::{Setting, Values};
use crate::transport::path_class::{PathClass, PathClasses};

pub struct Full;

const LIMITS: &[Setting] = &[rows::ERROR, rows::TIME, rows::SPP, rows::PHOTONS];

pub(super) const SETTINGS: &[Setting] = &[
    rows::MAX_LEGS,
    rows::ADJOINT_NORMALS,
    rows::RR_DEPTH,
    rows::HIDE_EMITTERS,
    rows::LIGHT_SAMPLING,
    rows::SEED,
    rows::SAMPLES,
    rows::SPLIT_DEPTH,
    rows::MAP_PHOTONS,
    rows::RADIUS,
    REPLICATES,
];

/// Each method has its own default.
const REPLICATES: Setting = Setting {
    default: crate::setting::Preset::Rule("32 of photons and paths, 16 of photon maps"),
    ..rows::replicates(2, "")
};

pub(super) fn settings(values: &Values, integrator: Option<&Integrator>) -> FullSettings {
    FullSettings {
        path: path::settings(values, integrator),
        photons: photons::settings(values, PhotonSettings::default()),
        photon_map: photon_map::settings(values),
        beams: beams::settings(values),
        most_photons: values.whole("photons"),
    }
    .agreeing()
}

const ABOUT: About = About {
    name: "full",
    meaning: "All that a camera sees: caustics by beams, photons and photon maps, the rest by paths",
    limits: LIMITS,
    work_key: Some("spp"),
    settings: SETTINGS,
    is_of_cameras: true,
};

impl Reference for Full {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal> {
        if let Some(reason) = warnings::no_camera(sensor) {
            return Err(Refusal::new(reason));
        }
        let settings = settings(values, scene.integrator());
        Plan::new(scene, sensor, &settings.path)?;
        Ok(())
    }

    fn cost(&self, _scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        Cost {
            bytes: memory::film(sensor, memory::full()),
            work: [path::counted(sensor, values), photons::counted(values)].concat(),
        }
    }

    fn run(&self, job: &Job) -> Result<Rendering, Error> {
        let settings = settings(job.values, job.scene.integrator());
        let progress = &job.context.progress;
        let (estimate, report) = full::run(job.scene, job.sensor, settings, job.budget, progress)?;
        let mut warnings = report.notices.clone();
        for part in &report.parts {
            if part.incomplete {
                warnings.push(format!(
                    "the part of {} ({}) did not come to its end",
                    part.method.name(),
                    listed(part.classes)
                ));
            }
            if let PartDetail::Path(report) = &part.detail {
                warnings.extend(warnings::cut_off(report.cut_off));
            }
        }
        let summary = summary(&estimate, &report);
        Ok(Rendering {
            summary,
            warnings,
            unit: "paths",
            ..Rendering::new(estimate)
                .reporting("full", report)
                .reporting("seed", settings.path.seed)
                .reporting("settings", settings)
        })
    }
}

fn summary(estimate: &Estimate, report: &FullReport) -> Vec<String> {
    let mut lines: Vec<String> = report.parts.iter().map(part_line).collect();
    lines.push(format!(
        "relative standard error over lit pixels, of what is drawn at random: {}",
        relative(estimate.relative_error, !estimate.incomplete)
    ));
    lines
}

fn part_line(part: &PartReport) -> String {
    let work = match &part.detail {
        PartDetail::Path(report) => format!("{} samples a pixel", report.samples),
        PartDetail::Beams(report) => format!("{} passes", report.passes),
        PartDetail::PhotonMap(report) => format!(
            "{} photons, relative bias {}",
            part.paths,
            relative(report.relative_bias, false)
        ),
        PartDetail::Photons {} => format!("{} photons", part.paths),
    };
    format!(
        "{} by {}: {work}; relative error {}",
        listed(part.classes),
        part.method.name(),
        relative(part.relative_error, !part.incomplete)
    )
}

/// Classes of paths, by name.
fn listed(classes: PathClasses) -> String {
    let names: Vec<&str> = classes.iter().map(PathClass::name).collect();
    names.join(", ")
}
