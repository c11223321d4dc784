//! The part of a run that photons measure.
//!
//! Before the first pass, a [forecast](Setup::forecast) divides the light between beams and photons
//! ([`by_photons`](super::by_photons)). After the last, photons measure their part, and what time or a wrong
//! forecast left of beams'. If they have no part, a run that gives up has no photons either: the forecast of
//! its memory knows of none.

use std::ops::Range;
use std::time::{Duration, Instant};

use super::batch::batches;
use super::by_photons::{ByPhotons, LEAST_WORK, OF_BEAMS, PhotonPart, most_alone};
use super::forecast::{Forecast, Sample, WorkBySignature};
use super::layers::BeamLayer;
use super::limit::Limit;
use super::refine::{Asked, Sounding};
use super::report::PhotonReport;
use super::run::Setup;
use super::schedule;
use super::selection::{Found, most_part, reached};
use super::settings::{Chaotic, target_error};
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::reference::target::{LitTexels, Target};
use crate::run::{Budget, Error, Estimate, LayerName};
use crate::scene::Scene;
use crate::transport::signature::Signature;

impl<'a> Setup<'a> {
    /// Likely work to the error that a budget asks for, the discovery left out: rays and time.
    ///
    /// The first pass is sounded. Mostly it is the last, unless a finer error is asked for than it aims at.
    /// If photons had better measure some of the light, the run will leave it to them.
    pub fn forecast(&mut self, budget: &Budget) -> Forecast {
        let began = Instant::now();
        let target = target_error(budget);
        self.photon_part = None;
        let (layers, _) = self.layers(target);
        let work = self.sounded(&layers, target);
        let all = work
            .values()
            .fold(Sounding::default(), |all, one| all + *one);
        let (mut rays, mut seconds) = (all.rays, all.seconds);
        self.photon_part = self.divided_by(&work, budget);
        let mut most_work = most_alone(all.work());
        if let Some(PhotonPart { division, .. }) = &self.photon_part {
            // Rays of both take about as long.
            rays = division.work;
            seconds *= division.work / all.work();
            most_work = division.most_of_beams;
        }
        let threads = rayon::current_num_threads() as f64;
        let seconds = (seconds / threads).min(Duration::MAX.as_secs_f64() * 0.5);
        Forecast {
            rays,
            time: began.elapsed() + Duration::from_secs_f64(seconds),
            by_photons: self.photon_part.is_some(),
            most_work: self.is_shared(budget).then_some(most_work),
        }
    }

    /// Likely work on each signature.
    fn sounded(&self, layers: &[BeamLayer], target: Option<f64>) -> WorkBySignature {
        let first = schedule::first(target, false);
        let goal = target.unwrap_or(schedule::COARSE_ERROR);
        let tolerances = layers.iter().map(|layer| self.first(layer, first, goal));
        let members = self.members(layers, &tolerances.collect::<Vec<_>>());
        let batches = batches(members.len(), self.most_together(), false).into_iter();
        let asked = |batch: Range<usize>| members[batch].iter().map(|one| one.asked).collect();
        let mut all = self.sounded_batches(batches.map(asked));
        for work in all.values_mut() {
            *work = *work * schedule::after_first(target);
        }
        all
    }

    /// Likely work on each signature of some batches.
    pub(in crate::reference) fn sounded_batches(
        &self,
        batches: impl IntoIterator<Item = Vec<Asked>>,
    ) -> WorkBySignature {
        let limit = Limit::new(&Budget::default(), self.progress, self.began);
        let passes = self.passes(&limit);
        let sample = |(index, light)| (light, Sample::of(&passes, light, index));
        let lights: Vec<_> = self.inputs.lights.iter().enumerate().map(sample).collect();
        let batches = batches.into_iter();
        batches
            .flat_map(|asked| passes.sound(&lights, &asked))
            .collect()
    }

    /// Photons with their part of the light, given beams' work; `None` if beams keep all of it.
    fn divided_by(&self, work: &WorkBySignature, budget: &Budget) -> Option<PhotonPart<'a>> {
        let target = target_error(budget)?;
        let all: f64 = work.values().map(Sounding::work).sum();
        if all < LEAST_WORK {
            return None;
        }
        let reached = reached(self.signatures.iter(), self.inputs.target.size());
        let lit = match reached.iter().filter(|reached| **reached).count() {
            0 => self.inputs.target.texels(),
            lit => lit,
        };
        let photons = self.photons(budget)?;
        let is_asked = |signature: &Signature| self.asked.contains_key(signature);
        let division = photons.division(work, is_asked, lit as f64, target)?;
        Some(PhotonPart { photons, division })
    }

    /// True if photons measure the light of a signature.
    pub(super) fn is_for_photons(&self, signature: &Signature) -> bool {
        let part = self.photon_part.as_ref();
        part.is_some_and(|part| part.division.to_photons.contains(signature))
    }

    /// True if photons may measure some of the light. A limit on rays is one of beams.
    pub(super) fn is_shared(&self, budget: &Budget) -> bool {
        self.settings.chaotic == Chaotic::Photons && budget.work.is_none()
    }

    /// The time after which beams leave all that they do not know to photons; `None` if they do not.
    pub(super) fn early(&self, budget: &Budget) -> Option<Duration> {
        let time = budget.time.filter(|_| self.is_shared(budget))?;
        let elapsed = self.began.elapsed();
        Some(elapsed + time.saturating_sub(elapsed) / 2)
    }

    /// Photons that may measure some of the light; `None` if they must not, or cannot.
    fn photons(&self, budget: &Budget) -> Option<ByPhotons<'a>> {
        self.is_shared(budget)
            .then(|| ByPhotons::new(self.inputs.scene, self.sensor, self.settings, self.progress))
            .flatten()
    }

    /// Lit texels, with the light of signatures that beams do not follow.
    pub(super) fn with_others(&self, lit: LitTexels, others: &[Found]) -> LitTexels {
        let light = others.iter().fold(0.0, |sum, (_, one)| sum + one.on_film);
        lit.and(light / self.typical_measure())
    }

    /// Measures by photons all light but that of the layers that are `made`, `others` as far as the discovery
    /// found it. The error of the estimate is that of all light, and relative to it. `None` if photons
    /// cannot, or if nothing became known.
    pub(super) fn by_photons(
        &mut self,
        made: &[BeamLayer],
        others: &[Found],
        lit: Option<LitTexels>,
        budget: &Budget,
    ) -> Result<Option<(Estimate, PhotonReport)>, Error> {
        let left = |began: Instant| {
            let time = budget.time?;
            Some(time.saturating_sub(began.elapsed()))
        };
        if left(self.began) == Some(Duration::ZERO) {
            return Ok(None);
        }
        let photons = self.photon_part.take().map(|part| part.photons);
        let Some(photons) = photons.or_else(|| self.photons(budget)) else {
            return Ok(None);
        };
        let lit = lit.map(|lit| self.with_others(lit, others));
        let of_beams = lit.map_or(0.0, |lit| schedule::error(&self.known(made, lit)));
        // What beams left of the error; if they left little, at least what was meant for photons.
        let error = target_error(budget).map(|target| {
            let left = target * target - of_beams * of_beams;
            left.max(target * target * (1.0 - OF_BEAMS * OF_BEAMS))
                .sqrt()
        });
        let budget = Budget {
            relative_error: error,
            time: left(self.began),
            work: None,
        };
        let made_by_name = made.iter().filter(|layer| layer.name.is_some()).count();
        let layers = self.settings.max_layers.saturating_sub(made_by_name);
        let followed = made.iter().flat_map(|layer| &layer.members);
        let followed = followed.map(|(signature, _)| *signature).collect();
        self.progress.begin_part();
        let measured = photons.measure(followed, layers, lit, &budget)?;
        Ok(measured.map(|(mut estimate, missed)| {
            may_have_missed(
                &mut estimate,
                missed,
                others,
                (self.inputs.scene, &self.inputs.target),
            );
            let names = others.iter().map(|(signature, _)| signature.to_string());
            let report = PhotonReport {
                photons: estimate.paths,
                signatures: names.collect(),
                relative_error: estimate.relative_error,
            };
            let error = &mut estimate.relative_error;
            *error = error.map(|error| math::hypot(of_beams, error));
            (estimate, report)
        }))
    }
}

/// Widens bounds of light by photons by a flux \[W\] of it that they may have missed.
///
/// Photons mostly start where a pilot saw that light begin. Where it saw none they are few and large. What
/// they bring is in no texel's scatter if none of them came. It is taken to be of any one signature, and no
/// denser than the densest bins of the discovery's paths tell.
fn may_have_missed(
    estimate: &mut Estimate,
    missed: Rgb,
    others: &[Found],
    (scene, target): (&Scene, &Target),
) {
    let named: Vec<LayerName> = estimate.layers.iter().map(|layer| layer.name).collect();
    let gains: Vec<Rgb> = (0..target.texels())
        .map(|texel| missed * target.gain(scene, texel))
        .collect();
    for layer in estimate.layers.iter_mut().chain([&mut estimate.total]) {
        let Some(interval) = &mut layer.interval else {
            continue;
        };
        let is_own = |signature: &Signature| {
            let name = LayerName::Path(*signature);
            match layer.name {
                LayerName::Path(_) => name == layer.name,
                LayerName::Other => !named.contains(&name),
                _ => true,
            }
        };
        let own = others.iter().filter(|(name, _)| is_own(name));
        let own = own.map(|(_, light)| &light.landings[..]);
        let parts = most_part(&own, target.size());
        for ((high, part), gain) in interval.high.iter_mut().zip(parts).zip(&gains) {
            *high += *gain * part;
        }
    }
}
