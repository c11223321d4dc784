//! Paths from a camera as a method.

use crate::method::memory;
use crate::method::reference::{About, Divisible, InParts, Job, Reference};
use crate::method::rows;
use crate::method::warnings;
use crate::reference::path::run::Setup;
use crate::reference::path::{self, DEFAULT_SAMPLES, PathReport, PathSettings};
use crate::run::format::relative;
use crate::run::{Budget, Cost, Counter, Error, Estimate, Progress, Refusal, Rendering};
use crate::scene::{Integrator, Scene, Sensor};
use crate::setting::table::row;
use crate::setting::{Kind, Setting, Values};
use crate::transport::bsdf::check_colors;
use crate::transport::camera::Camera;
use crate::transport::path_class::{PathClass, PathClasses};

pub struct Path;

const LIMITS: &[Setting] = &[rows::ERROR, rows::TIME, rows::SPP];

pub(super) const SETTINGS: &[Setting] = &[
    rows::MAX_LEGS,
    rows::ADJOINT_NORMALS,
    rows::RR_DEPTH,
    rows::HIDE_EMITTERS,
    rows::LIGHT_SAMPLING,
    row!("without-caustics": Kind::Flag, Value "false", "",
        "Leave out light that meets mirrors or glass first: what photons and beams measure"),
    rows::replicates(1, "8"),
    rows::SEED,
    rows::SAMPLES,
];

/// The settings of paths from checked values, in a scene whose file has this integrator.
pub(super) fn settings(values: &Values, integrator: Option<&Integrator>) -> PathSettings {
    let default = PathSettings::default().of_integrator(integrator);
    let classes = if values.flag("without-caustics") == Some(true) {
        default.classes.without(PathClasses::CAUSTICS)
    } else {
        default.classes
    };
    PathSettings {
        stream: values.word("samples").unwrap_or(default.stream),
        seed: values.whole("seed").unwrap_or(default.seed),
        replicates: values.whole("replicates").unwrap_or(default.replicates),
        max_depth: values.whole("max-depth").or(default.max_depth),
        rr_depth: values.whole("rr-depth").unwrap_or(default.rr_depth),
        hide_emitters: values
            .flag("hide-emitters")
            .unwrap_or(default.hide_emitters),
        light_sampling: values
            .word("light-sampling")
            .unwrap_or(default.light_sampling),
        classes,
    }
}

/// True if a run is one round: it has no limit but that on its samples.
pub(super) fn is_in_one(values: &Values) -> bool {
    !["time", "error"]
        .iter()
        .any(|key| values.given().contains_key(*key))
}

/// Memory \[bytes\] of paths of which so many classes are lit.
fn bytes(sensor: &Sensor, values: &Values, classes: u64) -> u64 {
    let film = memory::film(sensor, memory::path(classes, is_in_one(values)));
    let run = film.saturating_add(memory::path_tiles(classes, memory::texels(sensor)));
    memory::with_files(run, sensor, classes + 1, memory::ERRORS)
}

/// The number of classes that a few samples of a small image light.
pub(super) fn lit_classes(
    scene: &Scene,
    sensor: &Sensor,
    settings: PathSettings,
) -> Result<u64, Error> {
    /// Pixels along the longer side, and samples of each.
    const SIDE: u32 = 48;
    const SAMPLES: u64 = 16;
    let small = sensor.shrunk_to(SIDE);
    let budget = Budget::work(SAMPLES);
    let (estimate, _) = path::run(scene, &small, settings, &budget, &Progress::default())?;
    Ok(estimate.layers.len() as u64)
}

/// Camera paths that a run without limits on time and error starts.
pub(super) fn counted(sensor: &Sensor, values: &Values) -> Vec<Counter> {
    let samples = values.whole("spp").unwrap_or(DEFAULT_SAMPLES);
    if is_in_one(values) {
        let paths = memory::texels(sensor).saturating_mul(samples);
        vec![Counter::new("paths", paths)]
    } else {
        Vec::new()
    }
}

const ABOUT: About = About {
    name: "path",
    meaning: "Paths from a camera: all that it sees, but caustics of small area lights slowly, of point lights never",
    limits: LIMITS,
    work_key: Some("spp"),
    settings: SETTINGS,
    is_of_cameras: true,
};

impl Reference for Path {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn supports(&self, scene: &Scene, sensor: &Sensor, _values: &Values) -> Result<(), Refusal> {
        if let Some(reason) = warnings::no_camera(sensor) {
            return Err(Refusal::new(reason));
        }
        Camera::of_sensor(sensor)?.within(scene, sensor)?;
        check_colors(scene)?;
        Ok(())
    }

    fn cost(&self, _scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        Cost {
            bytes: bytes(sensor, values, PathClass::ALL.len() as u64),
            work: counted(sensor, values),
        }
    }

    fn pilot(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<u64, Error> {
        let settings = settings(values, scene.integrator());
        Ok(bytes(sensor, values, lit_classes(scene, sensor, settings)?))
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

impl Divisible for Path {
    type Setup<'a> = Setup<'a>;

    fn setup<'a>(&self, job: &Job<'a>) -> Result<Setup<'a>, Error> {
        let settings = settings(job.values, job.scene.integrator());
        Setup::new(job.scene, job.sensor, settings, &job.context.progress)
    }

    fn rendering(
        &self,
        job: &Job,
        _: &Setup,
        (estimate, report): (Estimate, PathReport),
    ) -> Rendering {
        let settings = settings(job.values, job.scene.integrator());
        let mut warnings: Vec<String> = warnings::cut_off(report.cut_off).into_iter().collect();
        warnings.extend(warnings::no_emitter(job.scene));
        if report.samples == 0 {
            warnings.push(warnings::ended_before("replicate", "image"));
        }
        if settings.classes.contains(PathClass::Caustic) {
            warnings.extend(warnings::out_of_reach(job.scene));
        }
        let summary = vec![
            format!("{} samples a pixel", report.samples),
            format!(
                "relative standard error over lit pixels: {}",
                relative(estimate.relative_error, !estimate.incomplete)
            ),
        ];
        Rendering {
            replicates: Some(settings.replicates),
            summary,
            warnings,
            unit: "paths",
            ..Rendering::new(estimate)
                .reporting("path", report)
                .reporting("seed", settings.seed)
                .reporting("settings", settings)
        }
    }
}
