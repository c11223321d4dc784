//! One method after the other, and their sum.

use std::time::{Duration, Instant};

use super::plan::{Finder, Plan};
use super::settings::FullSettings;
use super::shares::Shares;
use crate::radiometry::Rgb;
use crate::reference::beams::{self, BeamReport};
use crate::reference::path::{self, PathReport, PathSettings};
use crate::reference::photon_map::finish::CONFIDENCE;
use crate::reference::photon_map::{self, PhotonMapReport};
use crate::reference::photons;
use crate::run::{Budget, Error, Estimate, Layer, LayerName, Progress};
use crate::scene::{Emitter, Scene, Sensor};
use crate::transport::path_class::{PathClass, PathClasses};

/// The report of a run beside its image.
#[derive(Clone, Debug, serde::Serialize)]
pub struct FullReport {
    /// One entry for each method and its classes, in the order of their runs.
    pub parts: Vec<PartReport>,
    /// Notices of light that is left out, or found slowly, and why.
    pub notices: Vec<String>,
}

/// The part of one method.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PartReport {
    /// The method.
    pub method: Finder,
    /// The classes of paths that it measured.
    pub classes: PathClasses,
    /// Standard error over lit pixels of its own light (for beams the likely error), relative to their mean.
    pub relative_error: Option<f64>,
    /// Number of paths, of photons, or of pieces of light space (beams) that it started.
    pub paths: u64,
    /// True if it was stopped before its budget was used, or reached nothing.
    pub incomplete: bool,
    /// The method's own report.
    #[serde(flatten)]
    pub detail: PartDetail,
}

/// The report of a method on its part.
#[derive(Clone, Debug, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PartDetail {
    /// Paths.
    Path(PathReport),
    /// Beams.
    Beams(BeamReport),
    /// Photon maps.
    PhotonMap(PhotonMapReport),
    /// Photons, which report nothing more.
    #[serde(untagged)]
    Photons {},
}

/// A part measured: its light with bounds, a layer a class.
type Part = (Estimate, PartDetail);

/// The part of the share of beams after which photons take their place, if beams know nothing by then. Beams
/// that do know something keep what they have, and the rest of their time is the next parts'.
const OF_BEAMS: f64 = 0.6;

/// A run of all methods.
struct Run<'a> {
    scene: &'a Scene,
    sensor: &'a Sensor,
    settings: FullSettings,
    budget: &'a Budget,
    progress: &'a Progress,
}

/// Measures all that a camera sees.
///
/// The settings are made to [agree](FullSettings::agreeing) first. Methods run one after the other, paths
/// last. The estimate's layers are [classes](PathClass), all with bounds, and its total is their sum.
///
/// # Errors
///
/// As [`Plan::new`], and as the methods that it chose.
pub fn run(
    scene: &Scene,
    sensor: &Sensor,
    settings: FullSettings,
    budget: &Budget,
    progress: &Progress,
) -> Result<(Estimate, FullReport), Error> {
    let start = Instant::now();
    let settings = settings.agreeing();
    let plan = Plan::new(scene, sensor, &settings.path)?;
    let mut classes = plan.classes(Finder::Path);
    let of_paths = PathSettings {
        classes,
        ..settings.path
    };
    let paths = path::run::Setup::new(scene, sensor, of_paths, progress)?;
    let run = Run {
        scene,
        sensor,
        settings,
        budget,
        progress,
    };
    let light: Vec<(Finder, PathClass)> = [PathClass::Caustic, PathClass::SeenCaustic]
        .map(|class| (plan.finder(class), class))
        .into_iter()
        .filter(|(finder, _)| *finder != Finder::Path)
        .collect();
    let (replicates, _) = paths.division(budget.work.unwrap_or(u64::MAX));
    let shares = Shares::new(start, budget.time, replicates, |most| {
        if light.is_empty() {
            // Nobody else waits for time: there is nothing to set aside.
            None
        } else {
            paths.time_of_replicate(most)
        }
    });
    let mut report = FullReport {
        parts: Vec::new(),
        notices: plan.notices.clone(),
    };
    let mut followed = Vec::new();
    for (number, (mut finder, class)) in light.iter().copied().enumerate() {
        progress.begin_part();
        let time = shares.of_light((light.len() - number) as u32);
        let part = match finder {
            Finder::Beams => {
                let part = run.by_beams(class, time.map(|time| time.mul_f64(OF_BEAMS)))?;
                let gave_up = matches!(&part.1, PartDetail::Beams(beams) if beams.gave_up);
                let is_over = progress.is_stopped() || time.is_none() && !gave_up;
                if part.0.total.is_unknown() && !is_over {
                    finder = Finder::Photons;
                    run.by_photons(class, time.map(|time| time.mul_f64(1.0 - OF_BEAMS)))?
                } else {
                    part
                }
            }
            Finder::Photons => run.by_photons(class, time)?,
            Finder::PhotonMap => run.by_photon_maps(class, time)?,
            Finder::Path => continue,
        };
        if time.is_some() && part.0.total.is_unknown() && !progress.is_stopped() {
            report.notices.push(run.left_to_paths(class));
            classes = classes.with(class);
            continue;
        }
        if finder != plan.finder(class) && !part.0.total.is_unknown() {
            report.notices.push(beams_gave_way(class));
        }
        if let PartDetail::Beams(beams) = &part.1
            && beams.by_photons.is_some()
        {
            report.notices.push(beams_shared(class));
        }
        let of_part = PathClasses::NONE.with(class);
        followed.push(report.take(finder, of_part, part));
    }
    progress.begin_part();
    let part = run.by_paths(&paths.for_classes(classes), shares.of_paths())?;
    let mut estimate = report.take(Finder::Path, classes, part);
    for part in followed {
        estimate = estimate.and(part)?;
    }
    sort_by_class(&mut estimate.layers);
    if classes != plan.classes(Finder::Path) {
        estimate.incomplete = true;
        if run.has_delta_lights() {
            // Paths never find that light: nobody knows how much there is.
            let bounds = estimate.total.interval.iter_mut();
            bounds.for_each(|it| it.high.fill(Rgb::grey(f64::INFINITY)));
        }
    }
    Ok((estimate, report))
}

impl FullReport {
    /// Notes a part, and passes its estimate on.
    fn take(&mut self, method: Finder, classes: PathClasses, part: Part) -> Estimate {
        let (estimate, detail) = part;
        self.parts.push(PartReport {
            method,
            classes,
            relative_error: estimate.relative_error,
            paths: estimate.paths,
            incomplete: estimate.incomplete,
            detail,
        });
        estimate
    }
}

impl Run<'_> {
    fn by_paths(&self, paths: &path::run::Setup, time: Option<Duration>) -> Result<Part, Error> {
        let budget = FullSettings::budget_of_paths(self.budget, time);
        let (estimate, report) = paths.run(&budget)?;
        let replicates = u64::from(self.settings.path.replicates).min(report.samples) as u32;
        let estimate = estimate.with_bounds(CONFIDENCE, replicates, self.least());
        Ok((estimate, PartDetail::Path(report)))
    }

    /// The least light that a pixel can have.
    fn least(&self) -> f64 {
        self.sensor.film.filter.least_light()
    }

    /// True if there are lights that are a point or a direction, whose caustics paths never find.
    fn has_delta_lights(&self) -> bool {
        self.scene.emitters().iter().any(Emitter::is_delta)
    }

    /// The notice of a class that no method ended anything of: an image without it has more than none.
    fn left_to_paths(&self, class: PathClass) -> String {
        let never = if self.has_delta_lights() {
            ", and that of lights that are a point or a direction never"
        } else {
            ""
        };
        format!(
            "{class}: nothing ended in its share of the time: it is left to paths, which find it by chance{never}"
        )
    }

    fn by_beams(&self, class: PathClass, time: Option<Duration>) -> Result<Part, Error> {
        let budget = FullSettings::budget_of_beams(self.budget, time);
        let settings = self.settings.beams;
        let (estimate, report) =
            beams::run(self.scene, self.sensor, settings, &budget, self.progress)?;
        Ok((as_class(estimate, class), PartDetail::Beams(report)))
    }

    fn by_photons(&self, class: PathClass, time: Option<Duration>) -> Result<Part, Error> {
        let budget = self.settings.budget_of_photons(self.budget, time);
        let settings = self.settings.photons;
        let estimate = photons::run(self.scene, self.sensor, settings, &budget, self.progress)?;
        let replicates = u64::from(settings.replicates).min(estimate.paths) as u32;
        let estimate = as_class(estimate, class).with_bounds(CONFIDENCE, replicates, self.least());
        Ok((estimate, PartDetail::Photons {}))
    }

    fn by_photon_maps(&self, class: PathClass, time: Option<Duration>) -> Result<Part, Error> {
        let budget = self.settings.budget_of_photons(self.budget, time);
        let settings = self.settings.map_of(class);
        let (estimate, report) =
            photon_map::run(self.scene, self.sensor, settings, &budget, self.progress)?;
        Ok((as_class(estimate, class), PartDetail::PhotonMap(report)))
    }
}

/// The notice of a class that photons measure in the place of beams.
fn beams_gave_way(class: PathClass) -> String {
    format!(
        "{class}: {} ended nothing in its share of the time, or gave up: it is measured by photons, with a larger error",
        Finder::Beams.name()
    )
}

/// The notice of a class of which photons measure a part.
fn beams_shared(class: PathClass) -> String {
    format!(
        "{class}: light that {} would have taken long for is measured by photons",
        Finder::Beams.name()
    )
}

/// All light of an estimate as one layer: a method that follows light measures one class.
fn as_class(mut estimate: Estimate, class: PathClass) -> Estimate {
    estimate.layers = vec![Layer {
        name: LayerName::Class(class),
        ..estimate.total.clone()
    }];
    estimate
}

fn sort_by_class(layers: &mut [Layer]) {
    layers.sort_by_key(|layer| match layer.name {
        LayerName::Class(class) => class.index(),
        _ => PathClass::ALL.len(),
    });
}
