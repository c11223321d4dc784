//! A run, set up: the light that the discovery found, and how it is divided into layers.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use super::batch::most as most_together;
use super::by_photons::PhotonPart;
use super::coarse::coarse;
use super::discovery::{DiscoveryInputs, SignatureLight, discover};
use super::forecast::Forecast;
use super::inputs::BeamInputs;
use super::layers::{BeamLayer, lit};
use super::light::BeamLight;
use super::limit::Limit;
use super::pass::Passes;
use super::refine::{Asked, Limits};
use super::report::BeamReport;
use super::schedule::{self, Known};
use super::selection::{Found, bound, needed_for, reached};
use super::settings::{BeamSettings, Chaotic, target_error};
use super::source::Here;
use crate::radiometry::Rgb;
use crate::reference::target::LitTexels;
use crate::run::{Budget, Error, Estimate, Progress};
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;
use crate::transport::signature::Signature;

/// Error that light is left out for if no error is asked for.
const LEAST_TARGET: f64 = 1e-5;

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
    pub(super) layer: usize,
    /// The layer's tolerance.
    pub(super) tolerance: f64,
    pub(super) asked: Asked,
    /// Flux \[W\] that a texel may get of it, if its cells are too coarse to tell.
    pub(super) may_get: Option<Vec<f64>>,
}

/// A run, set up.
pub struct Setup<'a> {
    pub(in crate::reference) inputs: BeamInputs<'a>,
    pub(super) sensor: &'a Sensor,
    pub(super) settings: BeamSettings,
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
        let inputs = BeamInputs::new(scene, sensor, settings)?;
        let found = discover(&DiscoveryInputs {
            scene,
            lights: &inputs.lights,
            screen: &inputs.target.screen(),
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
            inputs,
            sensor,
            settings,
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

    /// Its settings.
    pub fn settings(&self) -> BeamSettings {
        self.settings
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
        let spent = self.spend(budget, &mut Here)?;
        self.finish(budget, spent)
    }

    /// The measure of a texel. Texels are about alike, but for those that no surface fills.
    pub(super) fn typical_measure(&self) -> f64 {
        let measures =
            (0..self.inputs.target.texels()).map(|texel| self.inputs.target.measure(texel));
        let measures: Vec<f64> = measures.filter(|measure| *measure > 0.0).collect();
        measures.iter().sum::<f64>() / measures.len() as f64
    }

    /// The layers that are followed to an error, and the signatures that are not.
    pub(super) fn layers(&mut self, target: Option<f64>) -> (Vec<BeamLayer>, Vec<Found>) {
        let film = self.inputs.target.size();
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

    /// The tolerance of the first pass over a layer, if that for all light is `first`; `None` if the layer
    /// need not be made for an error of `goal`.
    pub(super) fn first(&self, layer: &BeamLayer, first: f64, goal: f64) -> Option<f64> {
        let members = layer.members.iter();
        let part: f64 = members.clone().map(|(_, found)| self.part(found)).sum();
        let coarsest = members.map(|member| self.coarsest(member));
        let first = schedule::first_of_layer(first, part);
        (layer.needed_for > goal).then_some(first.min(coarsest.fold(0.0, f64::max)))
    }

    /// The texels that are lit, by light that is left out, too; `None` if no layer lights any.
    pub(super) fn lit(&self, layers: &[BeamLayer], others: &[Found]) -> Option<LitTexels> {
        let waiting = layers.iter().filter(|layer| layer.made.is_none());
        let waiting = waiting.flat_map(|layer| &layer.members);
        let by_others = reached(others.iter().chain(waiting), self.inputs.target.size());
        lit(layers, &by_others, &self.inputs.target)
    }

    /// True if the discovery found light on the film.
    pub(super) fn is_lit(&self) -> bool {
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
        let texels = self.inputs.target.texels() as f64;
        Limits {
            tolerance: self.own(member, tolerance) * self.flux / texels.sqrt(),
            flux: member.1.may_bring(),
            peak: member.1.peak,
        }
    }

    /// The inputs of passes.
    pub(super) fn passes<'p>(&'p self, limit: &'p Limit<'p>) -> Passes<'p> {
        self.inputs.passes(self.room(), limit, self.progress)
    }

    /// Flux \[W\], about, that a film must have room for.
    pub(super) fn room(&self) -> f64 {
        self.flux.max(LEAST_OF_LANDED * self.landed)
    }

    /// Flux \[W\] of a signature that a texel may get in any channel, by the discovery's paths.
    fn may_get(&self, found: &SignatureLight) -> Vec<f64> {
        // They tell a mean of channels: one of them may have all of it.
        let channels = f64::from(self.inputs.target.channels(self.inputs.scene));
        let bound = bound(&found.landings, self.inputs.target.size());
        bound.into_iter().map(|one| one * channels).collect()
    }

    /// The layers as the schedule sees them.
    pub(super) fn known(&self, layers: &[BeamLayer], lit: LitTexels) -> Vec<Known> {
        let made = layers.iter().filter_map(|layer| layer.made.as_ref());
        made.map(|made| made.known(lit, &self.inputs.target))
            .collect()
    }

    /// Most signatures that are followed together: flat facets' polygons have something to share.
    pub(super) fn most_together(&self) -> usize {
        let is_flat = |light: &BeamLight| !light.parts(&self.inputs.facets).0.is_empty();
        if self.inputs.lights.iter().any(is_flat) {
            most_together(self.inputs.film_bytes())
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

/// Likely work of a run to an error, the discovery left out.
///
/// # Errors
///
/// As [`Setup::new`].
pub fn forecast(
    scene: &Scene,
    sensor: &Sensor,
    settings: BeamSettings,
    error: f64,
) -> Result<Forecast, Error> {
    let progress = Progress::default();
    let mut setup = Setup::new(scene, sensor, settings, &progress)?;
    Ok(setup.forecast(&Budget::error(error)))
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
