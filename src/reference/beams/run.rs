//! Passes with smaller and smaller tolerances, until the budget is used.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::Ordering;
use std::time::Instant;

use rayon::prelude::*;

use super::bars::{BoundedFlux, bounded};
use super::facets::{FacetRefiner, part_roots};
use super::film::BeamFilm;
use super::refine::{Balance, Limits, Refiner, Scratch};
use super::settings::{BeamBudget, BeamSettings};
use super::survey::{Found, survey};
use crate::geometry::TraversalCounters;
use crate::numeric::FixedPoint;
use crate::radiometry::Rgb;
use crate::reference::{Estimate, Layer, LayerName, Progress};
use crate::scene::{Emitter, Scene, Sensor, is_achromatic};
use crate::transport::direct::{Direct, direct};
use crate::transport::facets::path::FacetPaths;
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::{Root, Source, roots};
use crate::transport::flux::Flux;
use crate::transport::guard::Guard;
use crate::transport::ledger::{Ledger, Row};
use crate::transport::prescribed::PathFollower;
use crate::transport::receiver::{Receiver, ReceiverError};
use crate::transport::screen::Screen;
use crate::transport::signature::{MAX_EVENTS, Signature};

/// Why beams cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum BeamError {
    /// The sensor cannot receive.
    #[error(transparent)]
    Receiver(#[from] ReceiverError),
    /// An emitter whose light arrives from more than one direction.
    #[error(
        "beams need light from a point or from infinity; emitter {index} ({plugin}) shines from a \
         surface: use photons"
    )]
    AreaLight {
        /// Which, in the file's order, from 0.
        index: usize,
        /// Mitsuba's name of its kind.
        plugin: &'static str,
    },
    /// A surface that light both passes and meets.
    #[error(
        "beams cannot tell light past the half open mask \"{id}\" from light by what it holds: use photons"
    )]
    Mask {
        /// The shape's id.
        id: String,
    },
    /// A setting outside its range.
    #[error("{name} is {value}; {allowed} are allowed")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: String,
        /// What it may be.
        allowed: String,
    },
    /// A deposit or a sum left its integer.
    #[error("a texel's flux is not representable: NaN, infinite, or far beyond the emitters' flux")]
    NotRepresentable,
}

/// What is to be known of a run beside its estimate.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct BeamReport {
    /// One entry a signature followed, the brightest first.
    pub signatures: Vec<SignatureReport>,
    /// Passes made; the last one is the result.
    pub passes: u32,
    /// Misplaced flux that a cell of the last pass may have, relative to the flux on the film.
    pub relative_tolerance: f64,
    /// Flux \[W\] of signatures too dim to be followed, by the survey; in no layer and no bar.
    pub not_followed: f64,
}

/// One signature's cells in the last pass.
#[derive(Clone, Debug, serde::Serialize)]
pub struct SignatureReport {
    /// Its name.
    pub name: String,
    /// Cells finished.
    pub cells: u64,
    /// ... crossed by a border between families.
    pub cut_cells: u64,
    /// ... with a part that no line divides.
    pub unresolved_cells: u64,
    /// Flux on the film \[W\].
    pub received: Rgb,
    /// Flux that borders may have misplaced \[W\].
    pub slack: Rgb,
    /// Light that set out \[W\], mean of channels, as this signature's cells sum it up: the same for all
    /// but for quadrature.
    pub emitted: f64,
    /// |received on the film − sum over its texels| / emitted: deposits lose nothing.
    pub balance_error: f64,
}

/// Signatures below this part of the error asked for, of all flux, are not followed.
const LEAST_SHARE: f64 = 1e-3;

/// At most this many signatures are followed.
const MOST_SIGNATURES: usize = 256;

/// What was found in some cells, and the work that took.
type Done<const N: usize> = (Balance<N>, TraversalCounters);

/// Roots of one task.
const TASK_ROOTS: usize = 16;

/// A run, set up.
pub struct Setup<'a> {
    scene: &'a Scene,
    settings: BeamSettings,
    receiver: Receiver,
    sources: Vec<Lit>,
    facets: Facets,
    /// The brightest first.
    signatures: Vec<(Signature, Found)>,
    guard: Guard<'a>,
    /// About the flux on the receiver's surface \[W\].
    flux: f64,
    not_followed: f64,
    progress: &'a Progress,
}

/// A source, and what its light meets first.
struct Lit {
    source: Source,
    /// Flat facets, by their numbers.
    facets: Vec<u32>,
    /// All other surfaces.
    roots: Vec<Root>,
}

/// A finished pass.
struct Pass {
    layers: Vec<PassLayer>,
    /// The likely error, relative.
    relative_error: Option<f64>,
    relative_tolerance: f64,
    /// All signatures together, mean of channels, by texel [W/m²].
    irradiance: Vec<f64>,
}

/// How far the error of a pass may turn out to be from what its own differences say, seen from the
/// next pass: errors have been seen from a sixth of it to all.
const CALIBRATION: std::ops::RangeInclusive<f64> = 0.17..=1.0;

/// Passes are compared where their tolerances are at least this far apart: misplaced flux falls
/// like the fourth power of a cell's size, so that every cell has been divided once more.
const CALIBRATION_STEP: f64 = 64.0;

/// The next pass, too, is a little off.
const CALIBRATION_MARGIN: f64 = 1.5;

struct PassLayer {
    signature: Signature,
    flux: Vec<Rgb>,
    bar: Vec<Rgb>,
    likely: Vec<f64>,
    report: SignatureReport,
}

impl<'a> Setup<'a> {
    /// Finds the first surfaces and the signatures.
    ///
    /// # Errors
    ///
    /// Where the sensor cannot receive, or emitters or materials are none that beams can follow.
    pub fn new(
        scene: &'a Scene,
        sensor: &Sensor,
        settings: BeamSettings,
        progress: &'a Progress,
    ) -> Result<Self, BeamError> {
        supports(scene)?;
        if settings.max_depth as usize > MAX_EVENTS {
            return Err(BeamError::Setting {
                name: "the depth",
                value: settings.max_depth.to_string(),
                allowed: format!("0 to {MAX_EVENTS} specular events"),
            });
        }
        let receiver = Receiver::new(scene, sensor)?;
        let sources: Vec<(Source, Vec<Root>)> = Source::all(scene)
            .into_iter()
            .map(|source| {
                let roots = roots(scene, &source);
                (source, roots)
            })
            .collect();
        let screen = Screen::Receiver(&receiver);
        let found = survey(
            scene,
            &sources,
            &screen,
            settings.max_depth,
            settings.shading_normals,
        );
        let facets = Facets::new(scene);
        let sources = sources
            .into_iter()
            .map(|(source, roots)| {
                let (flat, roots) = part_roots(&facets, &roots);
                Lit {
                    source,
                    facets: flat,
                    roots,
                }
            })
            .collect();
        let flux: f64 = found.signatures.values().map(|one| one.flux).sum();
        let mut signatures: Vec<(Signature, Found)> = found.signatures.into_iter().collect();
        signatures.sort_by(|(a, x), (b, y)| y.flux.total_cmp(&x.flux).then(a.cmp(b)));
        Ok(Self {
            scene,
            settings,
            receiver,
            sources,
            facets,
            signatures,
            guard: Guard::new(scene),
            flux,
            not_followed: 0.0,
            progress,
        })
    }

    /// Whether no light can meet a specular surface and get to the sensor.
    pub fn is_dark(&self) -> bool {
        self.signatures.is_empty()
    }

    /// Follows one signature only: for tests and measurements of it.
    pub fn only(&mut self, signature: Signature) {
        self.signatures.retain(|(one, _)| *one == signature);
        self.flux = self.signatures.iter().map(|(_, found)| found.flux).sum();
    }

    /// Spends the budget and delivers the estimate.
    ///
    /// # Errors
    ///
    /// Where a texel's flux is not representable.
    pub fn run(&mut self, budget: &BeamBudget) -> Result<(Estimate, BeamReport), BeamError> {
        let start = Instant::now();
        let deadline = budget.time.map(|time| start + time);
        let stop = || {
            self.progress.is_stopped() || deadline.is_some_and(|deadline| Instant::now() > deadline)
        };
        let direct = direct(self.scene, &self.receiver, 0, &stop)
            .unwrap_or_else(|| Direct::unknown(self.receiver.texels()));
        let target = budget.target();
        let least = LEAST_SHARE * target.unwrap_or(1e-5) * self.flux;
        let followed = self
            .signatures
            .iter()
            .take_while(|(_, found)| found.flux >= least)
            .count()
            .min(MOST_SIGNATURES);
        self.not_followed = self.signatures[followed..]
            .iter()
            .map(|(_, found)| found.flux)
            .sum();
        self.signatures.truncate(followed);

        let mut counters = direct.counters;
        let mut report = BeamReport::default();
        let mut best: Option<(Pass, f64)> = None;
        let mut said_before: Option<f64> = None;
        let mut calibration = 1.0;
        // From experience, errors follow tolerances like their power 2/3.
        let mut tolerance = 6e-3 * (16.0 * target.unwrap_or(1e-2)).min(0.1).powf(1.5);
        while !self.signatures.is_empty() {
            let began = Instant::now();
            let rays_before = counters.rays;
            let Some(pass) = self.pass(tolerance, &stop, &mut counters)? else {
                break;
            };
            report.passes += 1;
            let mut pass = pass;
            let own_error = pass.relative_error;
            if let (Some((before, coarse)), Some(said)) = (&best, said_before)
                && coarse >= &(CALIBRATION_STEP * tolerance)
            {
                // What the pass before was really off by, against what it said, tells what this
                // one's word is worth.
                calibration = (CALIBRATION_MARGIN * distance(before, &pass) / said)
                    .clamp(*CALIBRATION.start(), *CALIBRATION.end());
            }
            said_before = own_error;
            pass.relative_error = own_error.map(|error| error * calibration);
            let error = pass.relative_error;
            self.progress.set_relative_error(error);
            best = Some((pass, tolerance));
            let Some(error) = error.filter(|error| *error > 0.0) else {
                break;
            };
            let next = match target {
                Some(target) if error <= target => break,
                // A little more than needed, so that one step is enough; never too large a step.
                Some(target) => tolerance * (0.8 * target / error).powf(1.5).clamp(1e-3, 0.5),
                None => tolerance / 8.0,
            };
            // Cells, and with them the work, grow like the tolerance's power -1/2 or faster.
            let growth = (tolerance / next).powf(0.55);
            let too_long = deadline.is_some_and(|deadline| {
                Instant::now() + began.elapsed().mul_f64(growth) > deadline
            });
            let rays = (counters.rays - rays_before) as f64 * growth;
            let too_much = budget
                .rays
                .is_some_and(|most| counters.rays as f64 + rays > most as f64);
            if too_long || too_much || next < 1e-14 {
                break;
            }
            tolerance = next;
        }
        let stopped = self.progress.is_stopped();
        let unmet = match (
            target,
            best.as_ref().and_then(|(pass, _)| pass.relative_error),
        ) {
            (Some(target), Some(error)) => error > target,
            _ => false,
        };
        let incomplete = stopped
            || unmet && budget.time.is_none() && budget.rays.is_none()
            || best.is_none() && !self.is_dark();
        let estimate = self.estimate(
            best.map(|(pass, _)| pass),
            &direct,
            counters,
            incomplete,
            &mut report,
        );
        Ok((estimate, report))
    }

    /// All signatures at one tolerance; `None` where it was stopped.
    fn pass(
        &self,
        relative_tolerance: f64,
        stop: &(dyn Fn() -> bool + Sync),
        counters: &mut TraversalCounters,
    ) -> Result<Option<Pass>, BeamError> {
        let tolerance = relative_tolerance * self.flux;
        let mut layers = Vec::with_capacity(self.signatures.len());
        let tasks: usize = self
            .sources
            .iter()
            .map(|lit| lit.roots.len() + lit.facets.len())
            .sum();
        self.progress.paths.store(0, Ordering::Relaxed);
        self.progress
            .expected_paths
            .store((tasks * self.signatures.len()) as u64, Ordering::Relaxed);
        for (signature, found) in &self.signatures {
            let limits = Limits {
                tolerance,
                peak: found.peak,
            };
            let layer = if is_achromatic(self.scene) {
                self.signature::<1>(*signature, limits, stop, counters)?
            } else {
                self.signature::<3>(*signature, limits, stop, counters)?
            };
            let Some(layer) = layer else { return Ok(None) };
            layers.push(layer);
        }
        let texels = self.receiver.texels();
        let (mut lit, mut sum, mut squares) = (0_u64, 0.0, 0.0);
        let mut irradiance = vec![0.0; texels];
        for texel in 0..texels {
            let area = self.receiver.texel_area(texel);
            let flux: f64 = layers.iter().map(|layer| layer.flux[texel].mean()).sum();
            // The errors of different signatures know nothing of each other.
            let variance: f64 = layers.iter().map(|layer| layer.likely[texel].powi(2)).sum();
            if flux > 0.0 && area > 0.0 {
                irradiance[texel] = flux / area;
                lit += 1;
                sum += flux / area;
                squares += variance / (area * area);
            }
        }
        let relative_error = (lit > 0).then(|| (squares / lit as f64).sqrt() / (sum / lit as f64));
        Ok(Some(Pass {
            layers,
            relative_error,
            relative_tolerance,
            irradiance,
        }))
    }

    /// One signature at one tolerance.
    fn signature<const N: usize>(
        &self,
        signature: Signature,
        limits: Limits,
        stop: &(dyn Fn() -> bool + Sync),
        counters: &mut TraversalCounters,
    ) -> Result<Option<PassLayer>, BeamError> {
        let screen = Screen::Receiver(&self.receiver);
        // Slack may count the same flux in several texels, and the survey is coarse.
        let scale =
            FixedPoint::for_total(64.0 * self.flux).map_err(|_| BeamError::NotRepresentable)?;
        let film = BeamFilm::<N>::new(screen.size(), scale);
        let idle: Mutex<Vec<Scratch<N>>> = Mutex::new(Vec::new());
        let mut total = Balance::<N>::default();
        for lit in &self.sources {
            let paths = FacetPaths::new(
                self.scene,
                &lit.source,
                &self.facets,
                signature,
                self.settings.shading_normals,
            );
            let refined = |count: usize, work: &dyn Fn(&mut Refiner<'_, '_, N>) -> Done<N>| {
                if stop() {
                    return None;
                }
                let held = idle.lock().ok().and_then(|mut idle| idle.pop());
                let mut scratch = held.unwrap_or_default();
                let follower = PathFollower::new(
                    self.scene,
                    &lit.source,
                    &screen,
                    signature,
                    self.settings.shading_normals,
                );
                let mut refiner = Refiner::new(follower, &film, &self.guard, limits, &mut scratch);
                let (mut balance, mut work) = work(&mut refiner);
                balance += refiner.balance;
                work += refiner.counters();
                self.progress
                    .paths
                    .fetch_add(count as u64, Ordering::Relaxed);
                if let Ok(mut idle) = idle.lock() {
                    idle.push(scratch);
                }
                Some((balance, work))
            };
            let by_cells = lit.roots.par_chunks(TASK_ROOTS).map(|roots| {
                refined(roots.len(), &|refiner| {
                    for root in roots {
                        refiner.refine(root);
                    }
                    Done::default()
                })
            });
            let by_facets = lit.facets.par_chunks(TASK_ROOTS).map(|facets| {
                refined(facets.len(), &|refiner| {
                    let mut polygons = FacetRefiner::new(&paths, &screen, &film, limits.tolerance);
                    for facet in facets {
                        polygons.refine(*facet, refiner);
                    }
                    (polygons.balance, polygons.counters)
                })
            });
            let done: Vec<Option<Done<N>>> = by_cells.chain(by_facets).collect();
            // In the order of the roots: floats are summed the same on any threads.
            for one in done {
                let Some((balance, work)) = one else {
                    return Ok(None);
                };
                total += balance;
                *counters += work;
            }
        }
        if film.overflowed() {
            return Err(BeamError::NotRepresentable);
        }
        let BoundedFlux { flux, bar, likely } = bounded(&film);
        let on_film = flux.iter().fold(Flux::BLACK, |sum, flux| sum + *flux);
        let emitted = total.emitted.max(f64::MIN_POSITIVE);
        let report = SignatureReport {
            name: signature.to_string(),
            cells: total.cells,
            cut_cells: total.cut_cells,
            unresolved_cells: total.unresolved_cells,
            received: total.received.rgb(),
            slack: total.slack.rgb(),
            emitted: total.emitted,
            balance_error: (on_film - total.received).max_magnitude() / emitted,
        };
        Ok(Some(PassLayer {
            signature,
            flux: flux.into_iter().map(Flux::rgb).collect(),
            bar: bar.into_iter().map(Flux::rgb).collect(),
            likely,
            report,
        }))
    }

    fn estimate(
        &self,
        pass: Option<Pass>,
        direct: &Direct,
        counters: TraversalCounters,
        incomplete: bool,
        report: &mut BeamReport,
    ) -> Estimate {
        let texels = self.receiver.texels();
        let unknown = pass.is_none() && !self.is_dark();
        let relative_error = pass.as_ref().and_then(|pass| pass.relative_error);
        let mut layers = vec![direct_layer(direct)];
        let mut other = Layer::bounded(LayerName::Other, texels);
        let mut ledger = Ledger::default();
        let mut rows = BTreeMap::new();
        if let Some(pass) = pass {
            report.relative_tolerance = pass.relative_tolerance;
            let mut has_other = false;
            for (rank, layer) in pass.layers.into_iter().enumerate() {
                rows.insert(
                    layer.signature,
                    Row {
                        received: layer.report.received,
                        ..Row::default()
                    },
                );
                ledger.emitted.0 = ledger
                    .emitted
                    .0
                    .map(|emitted| emitted.max(layer.report.emitted));
                let named = rank < self.settings.max_layers;
                let filled = self.layer(&layer);
                if named {
                    layers.push(filled);
                } else {
                    other.add(&filled);
                    has_other = true;
                }
                report.signatures.push(layer.report);
            }
            layers[1..].sort_by_key(|layer| match layer.name {
                LayerName::Path(signature) => signature.code(),
                _ => u32::MAX,
            });
            if has_other {
                layers.push(other);
            }
        }
        report.not_followed = self.not_followed;
        let received: Rgb = rows.values().map(|row| row.received).sum();
        ledger.rows = rows;
        // By difference: the cells of each signature see their own light only.
        ledger.other.escaped = ledger.emitted - received;
        let mut total = Layer::bounded(LayerName::Total, texels);
        for layer in &layers {
            total.add(layer);
        }
        if unknown {
            total.make_unknown();
        }
        Estimate {
            width: self.receiver.width(),
            height: self.receiver.height(),
            total,
            layers,
            counts: vec![0; texels],
            ledger,
            paths: report.signatures.iter().map(|one| one.cells).sum(),
            counters,
            relative_error,
            incomplete,
        }
    }

    /// Irradiance and bounds of a signature.
    fn layer(&self, layer: &PassLayer) -> Layer {
        let texels = self.receiver.texels();
        // A texel without any surface gets no light.
        let per_area = |texel: usize| match self.receiver.texel_area(texel) {
            0.0 => 0.0,
            area => 1.0 / area,
        };
        let mut result = Layer::bounded(LayerName::Path(layer.signature), texels);
        let interval = result.interval.get_or_insert_default();
        for texel in 0..texels {
            let value = layer.flux[texel] * per_area(texel);
            let bar = layer.bar[texel] * per_area(texel);
            result.irradiance[texel] = value;
            // No light is less than none.
            interval.low[texel] = (value - bar).map(|low| low.max(0.0));
            interval.high[texel] = (value + bar).map(|high| high.max(0.0));
        }
        result
    }
}

/// Root mean square difference of two passes over lit texels, relative to their mean.
fn distance(before: &Pass, after: &Pass) -> f64 {
    let (mut lit, mut sum, mut squares) = (0_u64, 0.0, 0.0);
    for (a, b) in before.irradiance.iter().zip(&after.irradiance) {
        if *a > 0.0 || *b > 0.0 {
            lit += 1;
            sum += b;
            squares += (a - b) * (a - b);
        }
    }
    let lit = lit.max(1) as f64;
    (squares / lit).sqrt() / (sum / lit)
}

/// `LD`, whose error is a bound for delta emitters.
fn direct_layer(direct: &Direct) -> Layer {
    let texels = direct.texels.len();
    let mut layer = Layer::bounded(LayerName::Path(Signature::DIRECT), texels);
    let interval = layer.interval.get_or_insert_default();
    for (texel, known) in direct.texels.iter().enumerate() {
        layer.irradiance[texel] = known.irradiance;
        interval.low[texel] = (known.irradiance - known.error).map(|low| low.max(0.0));
        interval.high[texel] = known.irradiance + known.error;
    }
    layer
}

/// Whether beams can follow all light of a scene.
///
/// # Errors
///
/// Names what they cannot follow.
pub fn supports(scene: &Scene) -> Result<(), BeamError> {
    for (index, emitter) in scene.emitters().iter().enumerate() {
        if matches!(emitter, Emitter::Area { .. }) && !emitter.strength().is_black() {
            return Err(BeamError::AreaLight {
                index,
                plugin: emitter.plugin(),
            });
        }
    }
    for (index, object) in scene.objects().iter().enumerate() {
        if scene
            .material_of(index as u32)
            .is_partly_passed(scene.materials())
        {
            return Err(BeamError::Mask {
                id: object.id.clone(),
            });
        }
    }
    Ok(())
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
    budget: &BeamBudget,
    progress: &Progress,
) -> Result<(Estimate, BeamReport), BeamError> {
    Setup::new(scene, sensor, settings, progress)?.run(budget)
}
