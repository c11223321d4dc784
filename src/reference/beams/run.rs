//! Layers made with smaller and smaller tolerances, until the budget is used.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use super::batch::{batches, most as most_together};
use super::by_photons::{OF_BEAMS, PhotonPart};
use super::coarse::coarse;
use super::discovery::{DiscoveryInputs, SignatureLight, discover};
use super::film::BeamFilm;
use super::finish;
use super::forecast::Forecast;
use super::layers::{BeamLayer, Made, lit};
use super::limit::Limit;
use super::pass::{BeamLight, Passes};
use super::refine::{Asked, Limits};
use super::report::BeamReport;
use super::schedule::{self, Known};
use super::selection::{Found, LeftOut, MARGIN, bound, left, needed_for, reached};
use super::settings::{BeamSettings, Chaotic, target_error};
use super::support::supports;
use crate::geometry::TraversalCounters;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::reference::target::{LitTexels, Target};
use crate::run::{Budget, Error, Estimate, Progress};
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;
use crate::transport::camera::Camera;
use crate::transport::clearance::Clearance;
use crate::transport::direct::{AREA_SAMPLES, Direct, direct};
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::SharedPlaces;
use crate::transport::signature::{MAX_EVENTS, Signature};

/// Error that light is left out for if no error is asked for.
const LEAST_TARGET: f64 = 1e-5;

/// Part of the error that is left of it after the next pass if no error is asked for.
const WITHOUT_TARGET: f64 = 0.25;

/// Number of passes that may light nothing, each finer than the one before, until nothing is known.
const MOST_UNLIT: u32 = 3;

/// Factor of the tolerance after a pass whose cells were too large to light any texel.
const UNLIT: f64 = 1.0 / 256.0;

/// The part of the light landing beside a film that the film has room for, too: the discovery's estimate of a
/// small flux on it is no better.
const LEAST_OF_LANDED: f64 = 1e-3;

/// The two-sided confidence of the bound on light that the discovery may have missed.
const CONFIDENCE: f64 = 0.999;

/// The layers that are followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Divided {
    /// Those of one signature.
    pub named: usize,
    /// True if all others have one together.
    pub has_others: bool,
    /// Most signatures whose films are filled together.
    pub together: usize,
    /// Events of the longest signature.
    pub events: usize,
    /// True if photons measure some of the light, or may.
    pub by_photons: bool,
}

/// A signature of a layer that is made.
pub(super) struct Member {
    /// The number of the layer.
    layer: usize,
    /// The layer's tolerance.
    tolerance: f64,
    pub(super) asked: Asked,
    /// Flux \[W\] that a texel may get of it, if its cells are too coarse to tell.
    may_get: Option<Vec<f64>>,
}

/// A run, set up.
pub struct Setup<'a> {
    pub(super) scene: &'a Scene,
    pub(super) sensor: &'a Sensor,
    pub(super) settings: BeamSettings,
    pub(super) target: Target,
    pub(super) lights: Vec<BeamLight>,
    clearance: Clearance<'a>,
    shared: SharedPlaces<'a>,
    facets: Facets,
    /// The brightest first.
    pub(super) signatures: Vec<(Signature, SignatureLight)>,
    /// Estimated flux \[W\] of all signatures on the film, or beside it if next to none is on it.
    flux: f64,
    /// Estimated flux \[W\] on the film and beside it.
    landed: f64,
    /// Flux that the discovery may have missed \[W\].
    unseen: Rgb,
    /// The signatures that may have coarse cells.
    coarse: BTreeSet<Signature>,
    /// Photons that measure some of the light, if they are to.
    pub(super) photon_part: Option<PhotonPart<'a>>,
    /// Errors asked for of single layers, relative to their own means.
    pub(super) asked: BTreeMap<Signature, f64>,
    /// Limits of time count from here: the discovery takes its part.
    pub(super) began: Instant,
    pub(super) progress: &'a Progress,
}

impl<'a> Setup<'a> {
    /// Finds the first surfaces and the signatures.
    ///
    /// # Errors
    ///
    /// If the sensor cannot receive, or beams cannot follow an emitter or a material.
    pub fn new(
        scene: &'a Scene,
        sensor: &'a Sensor,
        settings: BeamSettings,
        progress: &'a Progress,
    ) -> Result<Self, Error> {
        let began = Instant::now();
        supports(scene)?;
        if settings.max_depth as usize > MAX_EVENTS {
            let depth = settings.max_depth.to_string();
            let allowed = format!("0 to {MAX_EVENTS} specular events");
            return Err(SettingError::value("max-depth", &depth, allowed).into());
        }
        let target = Target::new(scene, sensor, settings.shading_normals, Camera::new)?;
        let lights = BeamLight::all(scene);
        let found = discover(&DiscoveryInputs {
            scene,
            lights: &lights,
            screen: &target.screen(),
            max_depth: settings.max_depth,
            shading_normals: settings.shading_normals,
        });
        let landed = found.landed;
        let unseen = found.unseen(0.5 * (1.0 - CONFIDENCE));
        let flux: f64 = found.signatures.values().map(|one| one.flux).sum();
        let mut signatures: Vec<(Signature, SignatureLight)> =
            found.signatures.into_iter().collect();
        signatures.sort_by(|(a, x), (b, y)| y.flux.total_cmp(&x.flux).then(a.cmp(b)));
        Ok(Self {
            scene,
            sensor,
            settings,
            target,
            lights,
            clearance: Clearance::new(scene),
            shared: SharedPlaces::new(scene, settings.shading_normals),
            facets: Facets::new(scene),
            signatures,
            flux,
            landed,
            unseen,
            coarse: BTreeSet::new(),
            photon_part: None,
            asked: BTreeMap::new(),
            began,
            progress,
        })
    }

    /// True if no light was found that meets a specular surface and gets to the sensor.
    pub fn is_dark(&self) -> bool {
        self.signatures.is_empty()
    }

    /// Flux \[W\] that the discovery may have missed, with the risk of bounds for each shape; `None` if it
    /// found light.
    pub fn unseen(&self) -> Option<Rgb> {
        self.is_dark().then_some(self.unseen)
    }

    /// The signatures of light on the sensor that the discovery found, the brightest first.
    pub fn signatures(&self) -> impl Iterator<Item = Signature> + '_ {
        self.signatures.iter().map(|(signature, _)| *signature)
    }

    /// Asks for errors of single layers, relative to their own means. They are followed however faint they
    /// are.
    ///
    /// # Errors
    ///
    /// If a name is none of a signature that the discovery found on the film.
    pub fn ask(&mut self, errors: &[(&str, f64)]) -> Result<(), SettingError> {
        let found: Vec<String> = self.signatures().map(|one| one.to_string()).collect();
        for (name, error) in errors {
            let signature = self.signatures().find(|one| one.to_string() == *name);
            let there = found.iter().map(String::as_str);
            let signature = signature.ok_or_else(|| {
                SettingError::unknown("specular layer of this light", name, there)
            })?;
            self.asked.insert(signature, *error);
        }
        Ok(())
    }

    /// Follows one signature only, by beams: for tests and measurements of it.
    pub fn only(&mut self, signature: Signature) {
        self.settings.chaotic = Chaotic::Beams;
        self.signatures.retain(|(one, _)| *one == signature);
        let flux: f64 = self.signatures.iter().map(|(_, found)| found.flux).sum();
        self.landed *= flux / self.flux.max(f64::MIN_POSITIVE);
        self.flux = flux;
    }

    /// Spends the budget and delivers the estimate.
    ///
    /// # Errors
    ///
    /// If a texel's flux is not representable.
    pub fn run(&mut self, budget: &Budget) -> Result<(Estimate, BeamReport), Error> {
        let limit = Limit::new(budget, self.progress, self.began);
        let direct = match &self.target {
            Target::Receiver(receiver) => Some(
                // No area light shines: seed and samples have no effect.
                direct(self.scene, receiver, 0, AREA_SAMPLES, &|| {
                    limit.is_reached()
                })
                .unwrap_or_else(|| Direct::unknown(receiver.texels())),
            ),
            Target::Camera { .. } => None,
        };
        let mut counters = direct
            .as_ref()
            .map(|direct| direct.counters)
            .unwrap_or_default();
        limit.spend(counters.rays);
        let target = target_error(budget);
        let film = self.target.size();
        if !limit.is_set() {
            let forecast = self.forecast(budget);
            self.progress.set_forecast(Some(forecast.time));
        }
        let limit = limit.early(self.early(budget)).guarded(self.guard());
        let (mut layers, others) = self.layers(target);
        let passes = self.spend(&mut layers, &others, target, &limit, &mut counters)?;
        let lit = self.lit(&layers, &others);
        // If the discovery found light on the film, layers without any tell nothing.
        let is_dark = lit.is_none() && self.is_lit();
        let (made, waiting): (Vec<BeamLayer>, Vec<BeamLayer>) = layers
            .into_iter()
            .partition(|layer| layer.made.is_some() && !is_dark);
        // A limit may end a run before it knows light that is too bright to be left out.
        let coarse = target.unwrap_or(schedule::COARSE_ERROR);
        let is_due = |layer: &&BeamLayer| layer.needed_for > coarse;
        let missing = waiting.iter().filter(is_due).flat_map(|one| &one.members);
        let missing = missing.fold(0.0, |sum, (_, found)| sum + found.on_film);
        let is_asked = waiting.iter().any(|layer| layer.asked.is_some());
        let waiting = waiting.into_iter().flat_map(|one| one.members);
        let others: Vec<Found> = others.into_iter().chain(waiting).collect();
        let of_beams = lit.map(|lit| schedule::error(&self.known(&made, lit)));
        let rest = if missing > 0.0 || self.photon_part.is_some() {
            self.by_photons(&made, &others, lit, budget)?
        } else {
            None
        };
        let (missing, left_out) = match &rest {
            Some(_) => (0.0, LeftOut::default()),
            None => (
                missing,
                LeftOut::of(others.iter(), film).and_everywhere(MARGIN * missing, film),
            ),
        };
        let reached = match (&rest, lit, of_beams) {
            (Some((rest, _)), ..) => rest.relative_error,
            (None, Some(lit), Some(error)) => {
                let left_out = lit.relative_error(left_out.squares) / self.typical_measure();
                Some(math::hypot(error, left_out))
            }
            _ => None,
        };
        let limited = budget.time.is_some() || budget.work.is_some();
        let is_unmet = match (target, reached) {
            (Some(target), Some(error)) => error > target,
            (Some(_), None) => rest.is_some(),
            (None, _) => false,
        } || made.iter().any(|layer| layer.is_unmet(&self.target));
        let incomplete = self.progress.is_stopped()
            || is_unmet && !limited
            || missing > 0.0
            || is_asked
            || rest.as_ref().is_some_and(|(rest, _)| rest.incomplete)
            || made.is_empty() && rest.is_none() && !self.is_dark();
        let reports = made.iter().filter_map(|layer| layer.made.as_ref());
        let report = BeamReport {
            passes,
            not_followed: left_out.flux,
            relative_tolerance: reports
                .clone()
                .map(|made| made.tolerance)
                .reduce(f64::min)
                .unwrap_or(0.0),
            signatures: reports.flat_map(|made| made.reports.clone()).collect(),
            by_photons: rest.as_ref().map(|(_, report)| report.clone()),
        };
        let outcome = finish::RunOutcome {
            scene: self.scene,
            target: &self.target,
            layers: made,
            left_out,
            rest: rest.map(|(rest, _)| rest),
            unseen: self.unseen(),
            direct: direct.as_ref(),
            relative_error: reached,
            counters,
            incomplete,
        };
        Ok((outcome.estimate(), report))
    }

    /// The measure of a texel. Texels are about alike, but for those that no surface fills.
    pub(super) fn typical_measure(&self) -> f64 {
        let measures = (0..self.target.texels()).map(|texel| self.target.measure(texel));
        let measures: Vec<f64> = measures.filter(|measure| *measure > 0.0).collect();
        measures.iter().sum::<f64>() / measures.len() as f64
    }

    /// The layers that are followed to an error, and the signatures that are not.
    pub(super) fn layers(&mut self, target: Option<f64>) -> (Vec<BeamLayer>, Vec<Found>) {
        let film = self.target.size();
        let least = target.unwrap_or(LEAST_TARGET);
        let needed = needed_for(&self.signatures, film);
        let found = self.signatures.iter().cloned().zip(needed);
        let (mut followed, others): (Vec<_>, Vec<_>) = found
            .map(|(found, needed)| {
                let is_asked = self.asked.contains_key(&found.0);
                (found, if is_asked { f64::INFINITY } else { needed })
            })
            .partition(|((signature, _), needed)| {
                *needed > least && !self.is_for_photons(signature)
            });
        // Light on the film comes first, and has names first.
        followed.sort_by_key(|((_, light), _)| light.is_beside());
        let unasked = followed.iter().map(|(found, _)| found);
        let unasked = unasked.filter(|(signature, _)| !self.asked.contains_key(signature));
        let found = self.signatures.iter();
        let on_film: f64 = found.map(|(_, light)| light.on_film).sum();
        self.coarse = coarse(unasked, film, least * on_film);
        let followed = followed.into_iter();
        let layers = BeamLayer::divide(followed, self.settings.max_layers, &self.asked);
        (layers, others.into_iter().map(|(found, _)| found).collect())
    }

    /// The layers that a budget's error asks for.
    pub fn divided(&mut self, budget: &Budget) -> Divided {
        if budget.time.is_none() && self.is_shared(budget) {
            self.forecast(budget);
        }
        let (layers, _) = self.layers(target_error(budget));
        let members = layers.iter().flat_map(|layer| &layer.members);
        let events = members.clone().map(|(signature, _)| signature.len()).max();
        Divided {
            together: self.most_together().min(members.count()).max(1),
            named: layers.iter().filter(|layer| layer.name.is_some()).count(),
            has_others: layers.iter().any(|layer| layer.name.is_none()),
            events: events.unwrap_or(0),
            by_photons: self.early(budget).is_some() || self.photon_part.is_some(),
        }
    }

    /// The tolerance of the first pass over a layer, if that over others is `first`; `None` if the layer need
    /// not be made for an error of `goal`.
    pub(super) fn first(&self, layer: &BeamLayer, first: f64, goal: f64) -> Option<f64> {
        let members = layer.members.iter();
        let coarsest = members.map(|member| self.coarsest(member));
        (layer.needed_for > goal).then_some(first.min(coarsest.fold(0.0, f64::max)))
    }

    /// Makes the layers until their error is reached, or no budget is left. Returns the number of passes.
    fn spend(
        &self,
        layers: &mut [BeamLayer],
        others: &[Found],
        target: Option<f64>,
        limit: &Limit,
        counters: &mut TraversalCounters,
    ) -> Result<u32, Error> {
        let first = schedule::first(target, limit.is_set());
        let goal = target.unwrap_or(schedule::COARSE_ERROR);
        let tolerances = layers.iter().map(|layer| self.first(layer, first, goal));
        let mut tolerances: Vec<Option<f64>> = tolerances.collect();
        let mut passes = 0;
        let mut unlit = 0;
        while tolerances.iter().any(Option::is_some) {
            let (began, rays) = (Instant::now(), limit.rays());
            let work = self.pass(layers, &tolerances, limit, counters)?;
            passes += u32::from(work > 0.0);
            if limit.is_reached() {
                break;
            }
            let Some(mut lit) = self.lit(layers, others) else {
                if !self.is_lit() || unlit == MOST_UNLIT {
                    break;
                }
                unlit += 1;
                for tolerance in tolerances.iter_mut().flatten() {
                    *tolerance *= UNLIT;
                }
                continue;
            };
            if self.photon_part.is_some() {
                lit = self.with_others(lit, others);
            }
            let known = self.known(layers, lit);
            let error = schedule::error(&known);
            self.progress.set_relative_error(Some(error));
            if !layers
                .iter()
                .any(|layer| layer.made.is_none() && layer.needed_for > goal)
            {
                limit.extend();
            }
            let goal = target.unwrap_or(WITHOUT_TARGET * error);
            let affordable = work * limit.affordable(began.elapsed(), limit.rays() - rays);
            let goal = if self.photon_part.is_none() {
                left(goal)
            } else {
                OF_BEAMS * goal
            };
            let finer = schedule::affordable(&known, goal, affordable);
            let mut finer = finer.into_iter();
            let again = |layer: &BeamLayer| {
                layer.made.as_ref()?;
                let both = [finer.next().flatten(), layer.own_tolerance(&self.target)];
                both.into_iter().flatten().reduce(f64::min)
            };
            tolerances = layers.iter().map(again).collect();
            if tolerances.iter().all(Option::is_none) {
                break;
            }
            for (layer, tolerance) in layers.iter().zip(&mut tolerances) {
                if layer.made.is_none() {
                    *tolerance = self.first(layer, first, goal);
                }
            }
        }
        Ok(passes)
    }

    /// The texels that are lit, by light that is left out, too; `None` if no layer lights any.
    fn lit(&self, layers: &[BeamLayer], others: &[Found]) -> Option<LitTexels> {
        let waiting = layers.iter().filter(|layer| layer.made.is_none());
        let waiting = waiting.flat_map(|layer| &layer.members);
        let by_others = reached(others.iter().chain(waiting), self.target.size());
        lit(layers, &by_others, &self.target)
    }

    /// True if the discovery found light on the film.
    fn is_lit(&self) -> bool {
        self.signatures.iter().any(|(_, found)| found.on_film > 0.0)
    }

    /// The part of all flux that a signature may bring.
    fn part(&self, found: &SignatureLight) -> f64 {
        found.may_bring() / self.flux
    }

    /// The largest tolerance that makes sense for a signature.
    fn coarsest(&self, (signature, found): &Found) -> f64 {
        if self.coarse.contains(signature) {
            schedule::coarse(self.part(found))
        } else {
            schedule::fine(self.part(found))
        }
    }

    /// The tolerance of a signature in a layer of another.
    fn own(&self, member: &Found, tolerance: f64) -> f64 {
        f64::min(tolerance, self.coarsest(member))
    }

    /// The limits of its division.
    fn limits(&self, member: &Found, tolerance: f64) -> Limits {
        let texels = self.target.texels() as f64;
        Limits {
            tolerance: self.own(member, tolerance) * self.flux / texels.sqrt(),
            flux: member.1.may_bring(),
            peak: member.1.peak,
        }
    }

    /// The inputs of passes.
    pub(super) fn passes<'p>(&'p self, limit: &'p Limit<'p>) -> Passes<'p> {
        Passes {
            scene: self.scene,
            target: &self.target,
            clearance: &self.clearance,
            shared: &self.shared,
            facets: &self.facets,
            shading_normals: self.settings.shading_normals,
            flux: self.flux.max(LEAST_OF_LANDED * self.landed),
            limit,
            progress: self.progress,
        }
    }

    /// Flux \[W\] of a signature that a texel may get in any channel, by the discovery's paths.
    fn may_get(&self, found: &SignatureLight) -> Vec<f64> {
        // They tell a mean of channels: one of them may have all of it.
        let channels = f64::from(self.target.channels(self.scene));
        let bound = bound(&found.landings, self.target.size());
        bound.into_iter().map(|one| one * channels).collect()
    }

    /// The layers as the schedule sees them.
    pub(super) fn known(&self, layers: &[BeamLayer], lit: LitTexels) -> Vec<Known> {
        let made = layers.iter().filter_map(|layer| layer.made.as_ref());
        made.map(|made| made.known(lit, &self.target)).collect()
    }

    /// Makes some layers anew, each at its relative tolerance, as far as the limit allows. Returns the work
    /// that they took.
    fn pass(
        &self,
        layers: &mut [BeamLayer],
        tolerances: &[Option<f64>],
        limit: &Limit,
        counters: &mut TraversalCounters,
    ) -> Result<f64, Error> {
        let passes = self.passes(limit);
        let patches: usize = self.lights.iter().map(|light| light.patches.len()).sum();
        let asked = || {
            layers
                .iter()
                .zip(tolerances)
                .filter(|(_, asked)| asked.is_some())
        };
        let signatures: usize = asked().map(|(layer, _)| layer.members.len()).sum();
        self.progress.begin_pass((patches * signatures) as u64);
        let members = self.members(layers, tolerances);
        let mut waiting: Vec<(Made, usize)> = layers
            .iter()
            .map(|layer| (Made::default(), layer.members.len()))
            .collect();
        let mut all = 0.0;
        let may_end = limit.is_set() || self.photon_part.is_some();
        for batch in batches(members.len(), self.most_together(), may_end) {
            let batch = &members[batch];
            let asked: Vec<Asked> = batch.iter().map(|one| one.asked).collect();
            let is_done = passes.signatures(&self.lights, &asked, |index, mut one| {
                let member = &batch[index];
                *counters += one.counters;
                if let Some(bound) = &member.may_get {
                    one.sums.widen(bound);
                }
                let (made, left) = &mut waiting[member.layer];
                made.add(one);
                *left -= 1;
                if *left == 0
                    && let Some(made) = std::mem::take(made).layer(member.tolerance)
                {
                    all += made.work;
                    layers[member.layer].take(made, &self.target);
                }
            })?;
            if !is_done {
                break;
            }
        }
        Ok(all)
    }

    /// Most signatures that are followed together: flat facets' polygons have something to share.
    pub(super) fn most_together(&self) -> usize {
        let is_flat = |light: &BeamLight| !light.parts(&self.facets).0.is_empty();
        if self.lights.iter().any(is_flat) {
            let size = self.target.size();
            most_together(match self.target.channels(self.scene) {
                1 => BeamFilm::<1>::bytes(size),
                _ => BeamFilm::<3>::bytes(size),
            })
        } else {
            1
        }
    }

    /// The signatures of layers that are made at these tolerances, in the order of layers.
    pub(super) fn members(&self, layers: &[BeamLayer], tolerances: &[Option<f64>]) -> Vec<Member> {
        let mut members = Vec::new();
        for (layer, (one, tolerance)) in layers.iter().zip(tolerances).enumerate() {
            let Some(tolerance) = *tolerance else {
                continue;
            };
            for found in &one.members {
                let is_fine = self.own(found, tolerance) <= schedule::fine(self.part(&found.1));
                members.push(Member {
                    layer,
                    tolerance,
                    asked: (found.0, self.limits(found, tolerance)),
                    may_get: (!is_fine).then(|| self.may_get(&found.1)),
                });
            }
        }
        members
    }
}

/// Likely work of a run with default settings to its default error, the discovery left out.
///
/// # Errors
///
/// As [`Setup::new`].
pub fn forecast(scene: &Scene, sensor: &Sensor) -> Result<Forecast, Error> {
    let progress = Progress::default();
    let mut setup = Setup::new(scene, sensor, BeamSettings::default(), &progress)?;
    Ok(setup.forecast(&Budget::default()))
}

/// Measures what falls on a sensor.
///
/// # Errors
///
/// As [`Setup::new`] and [`Setup::run`].
pub fn run(
    scene: &Scene,
    sensor: &Sensor,
    settings: BeamSettings,
    budget: &Budget,
    progress: &Progress,
) -> Result<(Estimate, BeamReport), Error> {
    Setup::new(scene, sensor, settings, progress)?.run(budget)
}
