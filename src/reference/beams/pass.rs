//! One path signature's light of some sources, at one tolerance.

use std::borrow::Cow;
use std::sync::Mutex;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::average::Sums;
use super::bars::bounded;
use super::error::BeamError;
use super::facets::{FacetRefiner, part_patches};
use super::film::BeamFilm;
use super::limit::Limit;
use super::refine::{Balance, Limits, Refiner, Scratch};
use crate::geometry::TraversalCounters;
use crate::numeric::FixedPoint;
use crate::radiometry::Rgb;
use crate::reference::{Progress, Target};
use crate::scene::Scene;
use crate::transport::clearance::Clearance;
use crate::transport::facets::path::FacetPaths;
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::{Cone, SharedPlaces, Source, SurfacePatch, patches};
use crate::transport::fixed_signature::PathFollower;
use crate::transport::flux::Flux;
use crate::transport::scatter::ShadingNormals;
use crate::transport::signature::Signature;

/// Patches of one task: few enough for some hundred tasks, but of many patches so many that neighbours, which
/// share paths, are mostly of one task.
const TASK_PATCHES: std::ops::RangeInclusive<usize> = 16..=512;
/// See [`TASK_PATCHES`].
const TASKS: usize = 128;

/// Where there are at least as many sources as this, they make tasks enough.
const MANY_SOURCES: usize = 16;

/// A source and the light space over its first surfaces.
#[derive(Clone, Debug)]
pub struct BeamLight {
    /// Where the light comes from.
    pub source: Source,
    /// Where it may go; of a source that is one of thousands, found when needed.
    pub patches: Option<Vec<SurfacePatch>>,
}

impl BeamLight {
    /// The light space.
    pub fn patches(&self, scene: &Scene) -> Cow<'_, [SurfacePatch]> {
        self.patches.as_ref().map_or_else(
            || Cow::Owned(patches(scene, &self.source)),
            |patches| Cow::Borrowed(&**patches),
        )
    }

    /// The same with its light divided by `divisor`.
    #[must_use]
    pub fn dimmed(mut self, divisor: f64) -> Self {
        self.source = self.source.dimmed(divisor);
        self
    }
}

/// What is the same for all passes of a run.
pub struct Passes<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The sensor.
    pub target: &'a Target,
    /// What may be in the way of light.
    pub clearance: &'a Clearance<'a>,
    /// Places that faces of smooth meshes share.
    pub shared: &'a SharedPlaces<'a>,
    /// Flat faces.
    pub facets: &'a Facets,
    /// What interpolated normals do to flux.
    pub shading_normals: ShadingNormals,
    /// About the flux that a film must have room for \[W\].
    pub flux: f64,
    /// Ends a pass.
    pub limit: &'a Limit<'a>,
    /// Told of finished patches.
    pub progress: &'a Progress,
}

/// What a pass found.
pub struct PassLayer {
    /// What is on the film.
    pub sums: Sums,
    /// Sums over all cells.
    pub report: SignatureReport,
}

/// One signature's cells in the last pass.
#[derive(Clone, Debug, serde::Serialize)]
pub struct SignatureReport {
    /// Its name.
    pub name: String,
    /// Cells finished.
    pub cells: u64,
    /// ... crossed by a border between topologies.
    pub cut_cells: u64,
    /// ... with a part that no line divides.
    pub unresolved_cells: u64,
    /// Flux on the film \[W\]; of a camera, what its radiance is with the étendue of a typical pixel.
    pub received: Rgb,
    /// Flux that borders may have misplaced \[W\], in the same unit.
    #[serde(rename = "slack")]
    pub uncertain: Rgb,
    /// Light that set out \[W\], mean of channels, as this signature's cells sum it up: the same for all
    /// but for quadrature.
    pub emitted: f64,
    /// |received on the film − sum over its texels| / emitted: deposits lose nothing.
    pub balance_error: f64,
}

impl SignatureReport {
    /// The same with its light times `weight`.
    #[must_use]
    pub fn weighted(mut self, weight: f64) -> Self {
        self.received *= weight;
        self.uncertain *= weight;
        self.emitted *= weight;
        self
    }

    /// Adds the cells of other light of the same signature.
    pub fn add(&mut self, other: &Self) {
        self.cells += other.cells;
        self.cut_cells += other.cut_cells;
        self.unresolved_cells += other.unresolved_cells;
        self.received += other.received;
        self.uncertain += other.uncertain;
        self.emitted += other.emitted;
        self.balance_error = self.balance_error.max(other.balance_error);
    }
}

/// What some patches came to, and the work that took.
type TaskWork<const N: usize> = (Balance<N>, TraversalCounters);

/// The work of some patches; `None` where it was stopped.
type TaskResult<const N: usize> = Option<TaskWork<N>>;

impl Passes<'_> {
    /// One signature at one tolerance; `None` where it was stopped.
    ///
    /// # Errors
    ///
    /// Where a texel's flux is not representable.
    pub fn signature(
        &self,
        lights: &[BeamLight],
        signature: Signature,
        limits: Limits,
        counters: &mut TraversalCounters,
    ) -> Result<Option<PassLayer>, BeamError> {
        if self.target.is_achromatic(self.scene) {
            self.in_channels::<1>(lights, signature, limits, counters)
        } else {
            self.in_channels::<3>(lights, signature, limits, counters)
        }
    }

    fn in_channels<const N: usize>(
        &self,
        lights: &[BeamLight],
        signature: Signature,
        limits: Limits,
        counters: &mut TraversalCounters,
    ) -> Result<Option<PassLayer>, BeamError> {
        // Uncertain flux may count the same flux in several texels, and the discovery is coarse.
        let scale =
            FixedPoint::for_total(64.0 * self.flux).map_err(|_| BeamError::NotRepresentable)?;
        let film = BeamFilm::<N>::new(self.target.size(), scale);
        let tasks = if lights.len() < MANY_SOURCES {
            TASKS
        } else {
            1
        };
        let done: Vec<Vec<TaskResult<N>>> = lights
            .par_iter()
            .map(|light| self.light(light, signature, limits, tasks, &film))
            .collect();
        let mut total = Balance::<N>::default();
        // In the order of the patches: floats are summed the same on any threads.
        for one in done.into_iter().flatten() {
            let Some((balance, work)) = one else {
                return Ok(None);
            };
            total += balance;
            *counters += work;
        }
        if film.overflowed() {
            return Err(BeamError::NotRepresentable);
        }
        let bounded = bounded(&film);
        let on_film = bounded
            .flux
            .iter()
            .fold(Flux::BLACK, |sum, flux| sum + *flux);
        let emitted = total.emitted.max(f64::MIN_POSITIVE);
        let report = SignatureReport {
            name: signature.to_string(),
            cells: total.cells,
            cut_cells: total.cut_cells,
            unresolved_cells: total.unresolved_cells,
            received: total.received.rgb(),
            uncertain: total.uncertain.rgb(),
            emitted: total.emitted,
            balance_error: (on_film - total.received).max_magnitude() / emitted,
        };
        Ok(Some(PassLayer {
            sums: Sums::of(&bounded),
            report,
        }))
    }

    /// One source's light, in about so many tasks of some patches.
    fn light<const N: usize>(
        &self,
        light: &BeamLight,
        signature: Signature,
        limits: Limits,
        tasks: usize,
        film: &BeamFilm<N>,
    ) -> Vec<TaskResult<N>> {
        // Memory to work in, handed from task to task.
        let idle: Mutex<Vec<Scratch<N>>> = Mutex::new(Vec::new());
        let screen = self.target.screen();
        let paths = FacetPaths::new(
            self.scene,
            &light.source,
            self.facets,
            signature,
            self.shading_normals,
        );
        let refined = |count: usize, work: &dyn Fn(&mut Refiner<'_, '_, N>) -> TaskWork<N>| {
            if self.limit.is_reached() {
                return None;
            }
            let held = idle.lock().ok().and_then(|mut idle| idle.pop());
            let mut scratch = held.unwrap_or_else(|| Scratch::new(signature.len()));
            let follower = PathFollower::new(
                self.scene,
                &light.source,
                &screen,
                signature,
                self.shading_normals,
            );
            let mut refiner = Refiner::new(
                follower,
                self.shared,
                film,
                self.clearance,
                self.limit,
                limits,
                &mut scratch,
            );
            let (mut balance, mut counters) = work(&mut refiner);
            if refiner.was_stopped() {
                return None;
            }
            balance += refiner.balance;
            counters += refiner.counters();
            self.limit.spend(counters.rays - refiner.spent());
            self.progress
                .paths
                .fetch_add(count as u64, Ordering::Relaxed);
            if let Ok(mut idle) = idle.lock() {
                idle.push(scratch);
            }
            Some((balance, counters))
        };
        let patches = light.patches(self.scene);
        let (flat, patches) = match Cone::of(&light.source) {
            // Its patches are parts of facets only, and the cone's border is none of the facets' edges.
            Some(_) => (Vec::new(), patches.into_owned()),
            None => part_patches(self.facets, &patches),
        };
        let task =
            |patches: usize| (patches / tasks).clamp(*TASK_PATCHES.start(), *TASK_PATCHES.end());
        let by_cells = patches.par_chunks(task(patches.len())).map(|patches| {
            refined(patches.len(), &|refiner| {
                for patch in patches {
                    refiner.refine(patch);
                }
                TaskWork::default()
            })
        });
        let by_facets = flat.par_chunks(task(flat.len())).map(|facets| {
            refined(facets.len(), &|refiner| {
                let tolerance = limits.tolerance;
                let mut polygons =
                    FacetRefiner::new(&paths, &screen, self.clearance, film, tolerance);
                for facet in facets {
                    polygons.refine(*facet, refiner);
                }
                (polygons.balance, polygons.counters)
            })
        });
        by_cells.chain(by_facets).collect()
    }
}
