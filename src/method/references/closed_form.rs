//! Closed forms as a method.

use crate::method::memory;
use crate::method::reference::{About, Job, Reference};
use crate::method::rows::MOST_EVENTS;
use crate::method::warnings;
use crate::reference::closed_form::{self, ClosedFormSettings};
use crate::run::{Cost, Counter, Error, Refusal, Rendering};
use crate::scene::{Scene, Sensor};
use crate::setting::table::row;
use crate::setting::{Kind, Setting, Values};

pub struct ClosedForm;

pub(super) const SETTINGS: &[Setting] = &[
    row!("max-depth": Kind::Whole(0, ClosedFormSettings::MOST_EVENTS as u64), Value "16", "specular events", MOST_EVENTS),
];

pub(super) fn settings(values: &Values) -> ClosedFormSettings {
    let default = ClosedFormSettings::default();
    ClosedFormSettings {
        max_depth: values.whole("max-depth").unwrap_or(default.max_depth),
    }
}

const ABOUT: About = About {
    name: "closed-form",
    meaning: "Formulas, for scenes that they solve: a ball on the axis, a mirror cup, a pane, a convex solid, light alone",
    limits: &[],
    work_key: None,
    settings: SETTINGS,
    is_of_cameras: false,
};

impl Reference for ClosedForm {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn supports(&self, scene: &Scene, sensor: &Sensor, _values: &Values) -> Result<(), Refusal> {
        closed_form::supports(scene, sensor)
    }

    fn cost(&self, _scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        let layers = u64::from(settings(values).max_depth) + 2;
        Cost {
            bytes: memory::with_files(
                memory::film(sensor, memory::bounded_layers(layers)),
                sensor,
                layers + 1,
                memory::BOUNDS,
            ),
            work: vec![Counter::new("integrals", layers * memory::texels(sensor))],
        }
    }

    fn run(&self, job: &Job) -> Result<Rendering, Error> {
        let estimate = closed_form::solve(
            job.scene,
            job.sensor,
            settings(job.values),
            &job.context.progress,
        )?;
        let accuracy = estimate.relative_error.unwrap_or(0.0);
        Ok(Rendering {
            summary: vec![format!(
                "by formula: the bars are its quadrature and rounding, {accuracy:.1e} of the light by mirrors and glass"
            )],
            unit: "integrals",
            warnings: if estimate.incomplete {
                vec![warnings::NOT_ALL_LAYERS.to_owned()]
            } else {
                Vec::new()
            },
            ..Rendering::new(estimate)
        })
    }
}
