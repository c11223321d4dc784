//! Photons as a method.

use std::collections::{BTreeMap, BTreeSet};

use crate::method::memory::{self, Layers, channels};
use crate::method::reference::{About, Divisible, InParts, Job, Reference};
use crate::method::rows;
use crate::method::warnings;
use crate::reference::photons::run::Setup;
use crate::reference::photons::{DEFAULT_PHOTONS, PhotonSettings};
use crate::run::format::relative;
use crate::run::{Cost, Counter, Error, Estimate, Progress, Refusal, Rendering};
use crate::scene::{Scene, Sensor, is_grey};
use crate::setting::{Setting, Values};
use crate::spectrum::VISIBLE_NM;
use crate::transport::chain::ChainSettings;
use crate::transport::domain::LightSpace;

pub struct Photons;

const LIMITS: &[Setting] = &[rows::ERROR, rows::TIME, rows::PHOTONS];

pub(super) const SETTINGS: &[Setting] = &[
    rows::MAX_DEPTH,
    rows::SHADING_NORMALS,
    rows::LAYERS,
    rows::replicates(1, "32"),
    rows::SEED,
    rows::SAMPLES,
    rows::SPLIT_DEPTH,
    rows::DIRECT_SAMPLES,
];

/// The settings of photons from checked values, `default` for those without a value.
pub(crate) fn settings(values: &Values, default: PhotonSettings) -> PhotonSettings {
    let chains = default.chains;
    PhotonSettings {
        stream: values.word("samples").unwrap_or(default.stream),
        seed: values.whole("seed").unwrap_or(default.seed),
        replicates: values.whole("replicates").unwrap_or(default.replicates),
        chains: ChainSettings {
            max_depth: values.whole("max-depth").unwrap_or(chains.max_depth),
            split_depth: values.whole("split-depth").unwrap_or(chains.split_depth),
            shading_normals: values
                .word("shading-normals")
                .unwrap_or(chains.shading_normals),
            followed: chains.followed,
        },
        max_layers: values.whole("layers").unwrap_or(default.max_layers),
        direct_samples: values
            .whole("direct-samples")
            .unwrap_or(default.direct_samples),
    }
}

/// Photons that a run without limits on time and error starts.
pub(super) fn counted(values: &Values) -> Vec<Counter> {
    let is_open = values.given().contains_key("time") || values.given().contains_key("error");
    let photons = values.whole("photons").unwrap_or(DEFAULT_PHOTONS);
    if is_open {
        Vec::new()
    } else {
        vec![Counter::new("photons", photons)]
    }
}

/// Memory \[bytes\] of photons with these layers, with `LD` on a receiver.
fn bytes(scene: &Scene, sensor: &Sensor, layers: Layers) -> u64 {
    let run = memory::film(sensor, memory::photons(channels(scene, sensor), layers));
    memory::with_files(run, sensor, layers.count() + 2, memory::BOTH)
}

/// The line of a summary on a random method's own error.
pub(super) fn error_line(estimate: &Estimate) -> String {
    format!(
        "relative standard error of the specular layers' sum over lit texels: {}",
        relative(estimate.relative_error, estimate.is_without_caustics())
    )
}

const ABOUT: About = About {
    name: "photons",
    meaning: "Photons binned into texels, or connected to a camera: unbiased, on any scene",
    limits: LIMITS,
    work_key: Some("photons"),
    settings: SETTINGS,
    is_of_cameras: false,
};

impl Reference for Photons {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn follows_dispersion(&self) -> bool {
        true
    }

    fn supports(&self, scene: &Scene, _sensor: &Sensor, _values: &Values) -> Result<(), Refusal> {
        Ok(LightSpace::check(scene)?)
    }

    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        let layers = settings(values, PhotonSettings::default()).max_layers as u64;
        let layers = Layers::most(layers);
        Cost {
            bytes: bytes(scene, sensor, layers),
            work: counted(values),
        }
    }

    fn pilot(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<u64, Error> {
        let settings = settings(values, PhotonSettings::default());
        let progress = Progress::default();
        let setup = Setup::new(scene, sensor, settings, &progress)?;
        let layers = Layers::found(setup.signatures(), settings.max_layers);
        Ok(bytes(scene, sensor, layers))
    }

    fn run(&self, job: &Job) -> Result<Rendering, Error> {
        let setup = self.setup(job)?;
        let estimate = setup.run(job.budget)?;
        Ok(self.rendering(job, &setup, estimate))
    }

    fn in_parts(&self) -> Option<&dyn InParts> {
        Some(self)
    }
}

impl Divisible for Photons {
    type Setup<'a> = Setup<'a>;

    fn setup<'a>(&self, job: &Job<'a>) -> Result<Setup<'a>, Error> {
        let settings = settings(job.values, PhotonSettings::default());
        Setup::new(job.scene, job.sensor, settings, &job.context.progress)
    }

    fn rendering(&self, job: &Job, setup: &Setup, mut estimate: Estimate) -> Rendering {
        let (scene, settings) = (job.scene, settings(job.values, PhotonSettings::default()));
        let is_dark = setup.light().is_empty();
        let mut warnings = warnings::of_photons(scene, is_dark);
        if estimate.paths == 0 && !is_dark {
            estimate.incomplete = true;
            warnings.push(warnings::ended_before("replicate", "caustic"));
        }
        warnings.extend(warnings::unknown_direct(&estimate));
        warnings.extend(warnings::of_camera(scene, &estimate, "photons", false));
        let paths = estimate.paths;
        let mut summary = vec![error_line(&estimate)];
        summary.extend(spectral_line(scene));
        let counts = estimate.counts.iter().map(|count| *count as f64);
        Rendering {
            scalars: vec![("count.Y".to_owned(), counts.collect())],
            replicates: Some(settings.replicates),
            summary,
            warnings,
            unit: "photons",
            ..reporting_dispersion(scene, Rendering::new(estimate))
                .reporting("photons", paths)
                .reporting("seed", settings.seed)
                .reporting("settings", settings)
        }
    }
}

/// The line of a summary on wavelengths, if light had any.
fn spectral_line(scene: &Scene) -> Option<String> {
    let first = scene.dispersion().first()?;
    let [low, high] = VISIBLE_NM;
    let ids: BTreeSet<&str> = scene.dispersion().iter().map(|one| &*one.id).collect();
    let others = match ids.len() - 1 {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let coloured = if is_grey(scene) {
        ""
    } else {
        "; light or things have colours: single wavelengths may have power below zero"
    };
    Some(format!(
        "dispersion: {} is {}{others}; wavelengths from {low} to {high} nm, colours by CIE 1931, white is D65{coloured}",
        first.id, first.glass
    ))
}

/// A rendering that says which dispersion was on, if any was.
fn reporting_dispersion(scene: &Scene, rendering: Rendering) -> Rendering {
    let all = scene.dispersion();
    if all.is_empty() {
        return rendering;
    }
    let glasses: BTreeMap<&str, &str> =
        all.iter().map(|one| (&*one.id, one.glass.name())).collect();
    let wavelengths = serde_json::json!({
        "first-nm": VISIBLE_NM[0],
        "last-nm": VISIBLE_NM[1],
        "observer": "CIE 1931, 2 degrees",
        "white": "D65",
    });
    rendering
        .reporting("dispersion", glasses)
        .reporting("wavelengths", wavelengths)
}
