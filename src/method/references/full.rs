//! All methods together, as a method.

use super::{beams, path, photon_map, photons};
use crate::method::memory::{self, Part};
use crate::method::reference::{About, Job, Reference};
use crate::method::rows;
use crate::method::warnings;
use crate::reference::beams::DEFAULT_ERROR;
use crate::reference::beams::run::Setup;
use crate::reference::full::{
    self, Finder, FullReport, FullSettings, PartDetail, PartReport, Plan,
};
use crate::reference::path::PathSettings;
use crate::reference::photons::PhotonSettings;
use crate::run::format::relative;
use crate::run::{Budget, Cost, Error, Estimate, Progress, Refusal, Rendering};
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
    default: crate::setting::Preset::Rule("8 of paths, 32 of photons, 16 of photon maps"),
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

/// What memory depends on beside the film.
struct Found {
    /// Classes that paths light.
    classes: u64,
    /// Surfaces on which a photon of a map is kept.
    kept: f64,
    /// Events of the longest signature that beams follow, and the most signatures that they follow at once.
    events: u64,
    together: u64,
}

/// Memory \[bytes\] of a plan; without one, of the largest.
fn bytes(
    plan: Option<&Plan>,
    sensor: &Sensor,
    values: &Values,
    settings: &FullSettings,
    found: &Found,
) -> u64 {
    let of_paths = found.classes;
    let part = |class: PathClass| match plan?.finder(class) {
        Finder::Path => None,
        Finder::Beams => Some(Part::Beams),
        Finder::Photons => Some(Part::Photons),
        Finder::PhotonMap => Some(Part::PhotonMap),
    };
    let followed: Vec<Part> = match plan {
        Some(_) => [PathClass::Caustic, PathClass::SeenCaustic]
            .into_iter()
            .filter_map(part)
            .collect(),
        None => vec![Part::PhotonMap; 2],
    };
    let is_in_one = path::is_in_one(values);
    let film = memory::film(
        sensor,
        memory::full(
            &followed,
            found.together,
            of_paths,
            is_in_one,
            memory::texels(sensor),
        ),
    );
    let mut beside = memory::path_tiles(of_paths, memory::texels(sensor));
    // Methods run one after the other, but what the threads of one have freed stays with them.
    if followed.contains(&Part::PhotonMap) {
        beside += photon_map::photons_bytes(&settings.photon_map, found.kept);
    }
    if followed.contains(&Part::Beams) {
        beside += memory::beam_scratch(3, found.events);
    }
    let layers = of_paths + followed.len() as u64 + 1;
    memory::with_files(film.saturating_add(beside), sensor, layers, memory::BOTH)
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

    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        let settings = settings(values, scene.integrator());
        let all = PathClass::ALL.len() as u64;
        // Of a scene that is refused nothing is known.
        let plan = Plan::new(scene, sensor, &settings.path).ok();
        let of_paths = plan
            .as_ref()
            .map_or(all, |plan| plan.classes(Finder::Path).iter().count() as u64);
        let most = Found {
            classes: of_paths,
            kept: photon_map::MOST_KEPT,
            events: u64::from(settings.beams.max_depth),
            // What is shared by flat facets is not known before a pilot.
            together: 1,
        };
        Cost {
            bytes: bytes(plan.as_ref(), sensor, values, &settings, &most),
            work: [path::counted(sensor, values), photons::counted(values)].concat(),
        }
    }

    fn pilot(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<u64, Error> {
        let settings = settings(values, scene.integrator());
        let plan = Plan::new(scene, sensor, &settings.path)?;
        let of_paths = PathSettings {
            classes: plan.classes(Finder::Path),
            ..settings.path
        };
        let is_by = |finder: Finder| {
            let classes = [PathClass::Caustic, PathClass::SeenCaustic];
            classes
                .into_iter()
                .any(|class| plan.finder(class) == finder)
        };
        let kept = if is_by(Finder::PhotonMap) {
            photon_map::Found::of(scene, sensor, settings.photon_map)?.kept
        } else {
            0.0
        };
        let (events, together) = if is_by(Finder::Beams) {
            let progress = Progress::default();
            let error = values.fraction("error").unwrap_or(DEFAULT_ERROR);
            let mut setup = Setup::new(scene, sensor, settings.beams, &progress)?;
            let divided = setup.divided(&Budget::error(error));
            (divided.events as u64, divided.together as u64)
        } else {
            (0, 1)
        };
        let found = Found {
            classes: path::lit_classes(scene, sensor, of_paths)?,
            kept,
            events,
            together,
        };
        Ok(bytes(Some(&plan), sensor, values, &settings, &found))
    }

    fn run(&self, job: &Job) -> Result<Rendering, Error> {
        let settings = settings(job.values, job.scene.integrator());
        let progress = &job.context.progress;
        let (estimate, report) = full::run(job.scene, job.sensor, settings, job.budget, progress)?;
        let mut warnings = report.notices.clone();
        warnings.extend(warnings::no_emitter(job.scene));
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
