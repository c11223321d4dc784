//! Passes with smaller and smaller tolerances, until the budget is used.

use std::time::Instant;

use super::discovery::{SignatureLight, discover};
use super::finish;
use super::finished_pass::FinishedPass;
use super::limit::Limit;
use super::pass::{BeamLight, PassLayer, Passes};
use super::refine::Limits;
use super::report::BeamReport;
use super::schedule::{DIVIDED_AGAIN, Tolerance};
use super::settings::{BeamSettings, target_error};
use super::sums::Sums;
use super::support::supports;
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::reference::Target;
use crate::run::{Budget, Error, Estimate, Progress};
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;
use crate::transport::clearance::Clearance;
use crate::transport::direct::{AREA_SAMPLES, Direct, direct};
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::{SharedPlaces, Source, patches};
use crate::transport::signature::{MAX_EVENTS, Signature};

/// Signatures are not followed if their share of all flux is below this part of the error asked for.
const LEAST_SHARE: f64 = 1e-3;

/// The largest part of a signature's light that a cell may misplace, however faint the signature is. Larger
/// cells hold nothing smooth from which bounds could be made.
const MOST_OF_SIGNATURE: f64 = 1.0 / 64.0;

/// Number of passes that may light nothing, each finer than the one before, until nothing is known.
const MOST_UNLIT: u32 = 3;

/// The part of the light landing beside a film that the film has room for, too: the discovery's estimate of a
/// small flux on it is no better.
const LEAST_OF_LANDED: f64 = 1e-3;

/// The largest number of signatures that are followed.
const MOST_SIGNATURES: usize = 256;

/// The ratio of a pass' error, as the next pass shows it, to its estimated error. Measured ratios are from a
/// quarter to two, and may be larger if a pass overlooked light that the next one found.
const CALIBRATION: std::ops::RangeInclusive<f64> = 0.2..=16.0;

/// The ratio that is assumed while none is known: a first pass can be judged by itself alone.
const UNCALIBRATED: f64 = 2.0;

/// The part of an uncalibrated error by which the next pass is planned.
const LIKELY: f64 = 0.3;

/// Margin of the measured ratio: the next pass, too, is a little off.
const CALIBRATION_MARGIN: f64 = 1.2;

/// The two-sided confidence of the bound on light that the discovery may have missed.
const CONFIDENCE: f64 = 0.999;

/// A run, set up.
pub struct Setup<'a> {
    scene: &'a Scene,
    settings: BeamSettings,
    target: Target,
    lights: Vec<BeamLight>,
    clearance: Clearance<'a>,
    shared: SharedPlaces<'a>,
    facets: Facets,
    /// The brightest first.
    signatures: Vec<(Signature, SignatureLight)>,
    /// Estimated flux \[W\] of all signatures on the film, or beside it if next to none is on it.
    flux: f64,
    /// Estimated flux \[W\] on the film and beside it.
    landed: f64,
    /// Flux that the discovery may have missed \[W\].
    unseen: Rgb,
    progress: &'a Progress,
}

impl<'a> Setup<'a> {
    /// Finds the first surfaces and the signatures.
    ///
    /// # Errors
    ///
    /// If the sensor cannot receive, or beams cannot follow an emitter or a material.
    pub fn new(
        scene: &'a Scene,
        sensor: &Sensor,
        settings: BeamSettings,
        progress: &'a Progress,
    ) -> Result<Self, Error> {
        supports(scene)?;
        if settings.max_depth as usize > MAX_EVENTS {
            let depth = settings.max_depth.to_string();
            let allowed = format!("0 to {MAX_EVENTS} specular events");
            return Err(SettingError::value("max-depth", &depth, allowed).into());
        }
        let target = Target::new(scene, sensor, settings.shading_normals)?;
        let lights: Vec<BeamLight> = Source::all(scene)
            .into_iter()
            .map(|source| BeamLight {
                patches: patches(scene, &source),
                source,
            })
            .collect();
        let found = discover(
            scene,
            &lights,
            &target.screen(),
            settings.max_depth,
            settings.shading_normals,
        );
        let landed = found.landed;
        let unseen = found.unseen(0.5 * (1.0 - CONFIDENCE));
        let flux: f64 = found.signatures.values().map(|one| one.flux).sum();
        let mut signatures: Vec<(Signature, SignatureLight)> =
            found.signatures.into_iter().collect();
        signatures.sort_by(|(a, x), (b, y)| y.flux.total_cmp(&x.flux).then(a.cmp(b)));
        Ok(Self {
            scene,
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

    /// Follows one signature only: for tests and measurements of it.
    pub fn only(&mut self, signature: Signature) {
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
        let limit = Limit::new(budget, self.progress);
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
        let target = target_error(budget);
        let least = LEAST_SHARE * target.unwrap_or(1e-5) * self.flux;
        let followed = self
            .signatures
            .iter()
            .take_while(|(_, found)| found.flux >= least)
            .count()
            .min(MOST_SIGNATURES);
        let (followed, dim) = self.signatures.split_at(followed);
        let mut report = BeamReport {
            not_followed: dim.iter().map(|(_, found)| found.flux).sum(),
            ..BeamReport::default()
        };
        let mut counters = direct
            .as_ref()
            .map(|direct| direct.counters)
            .unwrap_or_default();
        limit.spend(counters.rays);
        let is_lit = followed.iter().any(|(_, found)| found.on_film > 0.0);
        let limited = budget.time.is_some() || budget.work.is_some();
        let mut best: Option<FinishedPass> = None;
        let (mut said_before, mut calibration) = (0.0, None);
        let mut unlit = 0;
        let mut tolerance = Tolerance::first(target, limited);
        while !followed.is_empty() {
            let (began, rays_before) = (Instant::now(), limit.rays());
            let Some((mut pass, work)) = self.pass(followed, tolerance, &limit)? else {
                break;
            };
            counters += work;
            report.passes += 1;
            let said = pass.error.unwrap_or(0.0);
            if let Some(before) = &best
                && before.tolerance.0 >= DIVIDED_AGAIN * tolerance.0
                && said_before > 0.0
            {
                // The true error of the pass before, by its estimated error, calibrates this pass' estimate.
                let found = CALIBRATION_MARGIN * self.distance(before, &pass) / said_before;
                calibration = Some(found.clamp(*CALIBRATION.start(), *CALIBRATION.end()));
            }
            said_before = said;
            if let Some(error) = &mut pass.error {
                *error *= calibration.unwrap_or(UNCALIBRATED);
            }
            let error = pass.error;
            self.progress.set_relative_error(error);
            best = Some(pass);
            let affordable = limit.affordable(began.elapsed(), limit.rays() - rays_before);
            let next = match error {
                Some(error) => {
                    let hope = calibration.map_or(LIKELY, |_| 1.0);
                    tolerance.next(error, hope, target)
                }
                None if is_lit && unlit < MOST_UNLIT => {
                    unlit += 1;
                    tolerance.finer()
                }
                None => None,
            };
            let next = next.and_then(|next| tolerance.towards(next, affordable));
            let Some(next) = next else { break };
            tolerance = next;
        }
        // If the discovery found light on the film, a pass without any tells nothing.
        let best = best.filter(|pass| pass.error.is_some() || !is_lit);
        let stopped = self.progress.is_stopped();
        let reached = best.as_ref().and_then(|pass| pass.error);
        let unmet = match (target, reached) {
            (Some(target), Some(error)) => error > target,
            _ => false,
        };
        let incomplete = stopped || unmet && !limited || best.is_none() && !self.is_dark();
        if let Some(pass) = &best {
            report.relative_tolerance = pass.tolerance.0;
            report.signatures.clone_from(&pass.reports);
        }
        let outcome = finish::RunOutcome {
            scene: self.scene,
            target: &self.target,
            pass: best,
            unseen: self.unseen(),
            direct: direct.as_ref(),
            relative_error: reached,
            counters,
            incomplete,
        };
        Ok((outcome.estimate(), report))
    }

    /// All signatures at one tolerance; `None` if it was stopped.
    fn pass(
        &self,
        signatures: &[(Signature, SignatureLight)],
        tolerance: Tolerance,
        limit: &Limit,
    ) -> Result<Option<(FinishedPass, TraversalCounters)>, Error> {
        let mut counters = TraversalCounters::default();
        let passes = Passes {
            scene: self.scene,
            target: &self.target,
            clearance: &self.clearance,
            shared: &self.shared,
            facets: &self.facets,
            shading_normals: self.settings.shading_normals,
            flux: self.flux.max(LEAST_OF_LANDED * self.landed),
            limit,
            progress: self.progress,
        };
        let patches: usize = self.lights.iter().map(|light| light.patches.len()).sum();
        self.progress
            .begin_pass((patches * signatures.len()) as u64);

        let texels = self.target.texels();
        let named = self.settings.max_layers.min(signatures.len());
        let names = signatures[..named].iter().map(|(name, _)| Some(*name));
        let others = (named < signatures.len()).then_some(None);
        let mut layers: Vec<(Option<Signature>, Sums)> = names
            .chain(others)
            .map(|name| (name, Sums::dark(texels)))
            .collect();
        let mut total = Sums::dark(texels);
        let mut reports = Vec::with_capacity(signatures.len());
        for (rank, (signature, found)) in signatures.iter().enumerate() {
            let limits = Limits {
                tolerance: f64::min(tolerance.0 * self.flux, MOST_OF_SIGNATURE * found.flux),
                flux: found.flux,
                peak: found.peak,
            };
            let layer = passes.signature(&self.lights, *signature, limits, &mut counters)?;
            let Some(PassLayer { sums, report }) = layer else {
                return Ok(None);
            };
            total.add(&sums);
            layers[rank.min(named)].1.add(&sums);
            reports.push(report);
        }
        let pass = FinishedPass {
            error: self.error(&total),
            layers,
            total,
            reports,
            tolerance,
        };
        Ok(Some((pass, counters)))
    }

    /// Root mean square of the likely error over lit texels, relative to their mean.
    fn error(&self, total: &Sums) -> Option<f64> {
        let (mut lit, mut sum, mut squares) = (0_u64, 0.0, 0.0);
        for texel in 0..total.texels() {
            let (flux, measure) = (total.flux[texel].mean(), self.target.measure(texel));
            if flux > 0.0 && measure > 0.0 {
                lit += 1;
                sum += flux / measure;
                squares += (total.variance[texel].sqrt() / measure).powi(2);
            }
        }
        let lit = (lit > 0).then_some(lit as f64)?;
        let mean = sum / lit;
        Some((squares / lit).sqrt() / mean)
    }

    /// Root mean square difference of two passes over lit texels, relative to their mean.
    fn distance(&self, before: &FinishedPass, after: &FinishedPass) -> f64 {
        let (mut lit, mut sum, mut squares) = (0_u64, 0.0, 0.0);
        for texel in 0..after.total.texels() {
            let measure = self.target.measure(texel);
            let [a, b] = [before, after].map(|pass| pass.total.flux[texel].mean());
            if (a > 0.0 || b > 0.0) && measure > 0.0 {
                lit += 1;
                sum += b / measure;
                squares += ((a - b) / measure).powi(2);
            }
        }
        let lit = lit.max(1) as f64;
        (squares / lit).sqrt() / (sum / lit)
    }
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
