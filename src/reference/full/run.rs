//! One method after the other, and their sum.

use std::time::{Duration, Instant};

use super::plan::{Finder, Plan};
use super::settings::FullSettings;
use crate::radiometry::Rgb;
use crate::reference::beams::{self, BeamReport};
use crate::reference::path::{self, PathReport, PathSettings};
use crate::reference::photon_map::finish::CONFIDENCE;
use crate::reference::photon_map::{self, PhotonMapReport, PhotonMapSettings};
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

/// The share of a part's time after which its second way begins, if the first knows nothing by then. A first
/// way that does know something keeps what it has, and the rest of its time is the next parts'.
const FIRST_WAY: f64 = 0.6;

/// The part of the whole time that paths have at least, even if those before them took longer than their
/// shares: without any replicate of paths nothing is known of the image.
const LEAST_OF_PATHS: f64 = 0.1;

/// Photons of a map in the second way. It takes the fewest replicates that have a scatter worth its name.
const SMALL_MAP: u64 = 1 << 10;
const FEW_REPLICATES: u32 = 4;

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
    let mut report = FullReport {
        parts: Vec::new(),
        notices: plan.notices.clone(),
    };
    // The time left, divided by the number of methods that wait for it.
    let share = |waiting: usize| {
        let time = budget.time?;
        Some(time.saturating_sub(start.elapsed()) / waiting as u32)
    };
    let (mut followed, mut classes) = (Vec::new(), plan.classes(Finder::Path));
    for (number, (finder, class)) in light.iter().copied().enumerate() {
        progress.begin_part();
        let time = share(light.len() + 1 - number);
        let first = time.map(|time| time.mul_f64(FIRST_WAY));
        let part = match finder {
            Finder::Beams => run.by_beams(class, first)?,
            Finder::Photons => run.by_photons(class, time)?,
            Finder::PhotonMap => run.by_photon_maps(run.settings.map_of(class), class, first)?,
            Finder::Path => continue,
        };
        let (finder, part) = match time {
            Some(time) if run.gives_way(finder, &part) => {
                let (notice, second, part) =
                    run.second_way(finder, class, time.mul_f64(1.0 - FIRST_WAY))?;
                if !part.0.total.is_unknown() {
                    report.notices.push(notice);
                }
                (second, part)
            }
            _ => (finder, part),
        };
        if time.is_some() && part.0.total.is_unknown() && !progress.is_stopped() {
            report.notices.push(run.left_to_paths(class));
            classes = classes.with(class);
            continue;
        }
        let of_part = PathClasses::NONE.with(class);
        followed.push(report.take(finder, of_part, part));
    }
    progress.begin_part();
    let least = budget.time.map(|time| time.mul_f64(LEAST_OF_PATHS));
    let part = run.by_paths(classes, share(1).max(least))?;
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
    fn by_paths(&self, classes: PathClasses, time: Option<Duration>) -> Result<Part, Error> {
        let settings = PathSettings {
            classes,
            ..self.settings.path
        };
        let budget = FullSettings::budget_of_paths(self.budget, time);
        let (estimate, report) =
            path::run(self.scene, self.sensor, settings, &budget, self.progress)?;
        let replicates = u64::from(settings.replicates).min(report.samples) as u32;
        let estimate = estimate.with_bounds(CONFIDENCE, replicates, self.least());
        Ok((estimate, PartDetail::Path(report)))
    }

    /// The least light that a pixel can have.
    fn least(&self) -> f64 {
        self.sensor.film.filter.least_light()
    }

    /// True if a part knows nothing, and there is another way. Photons are the last.
    fn gives_way(&self, finder: Finder, (estimate, _): &Part) -> bool {
        finder != Finder::Photons && estimate.total.is_unknown() && !self.progress.is_stopped()
    }

    /// The way that ends sooner, and knows less, with a notice.
    fn second_way(
        &self,
        first: Finder,
        class: PathClass,
        time: Duration,
    ) -> Result<(String, Finder, Part), Error> {
        let (second, part, how) = if first == Finder::PhotonMap {
            let mut settings = self.settings.map_of(class);
            settings.map_photons = settings.map_photons.min(SMALL_MAP);
            settings.photons.replicates = settings.photons.replicates.min(FEW_REPLICATES);
            let part = self.by_photon_maps(settings, class, Some(time))?;
            (
                first,
                part,
                format!("by maps of {} photons", settings.map_photons),
            )
        } else {
            let part = self.by_photons(class, Some(time))?;
            (Finder::Photons, part, "by photons".to_owned())
        };
        let notice = format!(
            "{class}: {} ended nothing in its share of the time: it is measured {how}, with a larger error",
            first.name()
        );
        Ok((notice, second, part))
    }

    /// True if there are lights that are a point or a direction, whose caustics paths never find.
    fn has_delta_lights(&self) -> bool {
        self.scene.emitters().iter().any(Emitter::is_delta)
    }

    /// The notice of a class that no other way ended anything of: an image without it has more than none.
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

    fn by_photon_maps(
        &self,
        settings: PhotonMapSettings,
        class: PathClass,
        time: Option<Duration>,
    ) -> Result<Part, Error> {
        let budget = self.settings.budget_of_photons(self.budget, time);
        let (estimate, report) =
            photon_map::run(self.scene, self.sensor, settings, &budget, self.progress)?;
        Ok((as_class(estimate, class), PartDetail::PhotonMap(report)))
    }
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
