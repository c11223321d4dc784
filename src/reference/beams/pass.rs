//! One path signature's light of some sources, at one tolerance.

use std::sync::Mutex;

use rayon::prelude::*;

use super::bars::bounded;
use super::facets::{FacetRefiner, part_patches};
use super::film::BeamFilm;
use super::limit::Limit;
use super::refine::{Balance, Limits, Refiner, Scratch};
use super::sums::Sums;
use crate::geometry::TraversalCounters;
use crate::numeric::FixedPoint;
use crate::radiometry::Rgb;
use crate::reference::Target;
use crate::run::{Error, Progress};
use crate::scene::Scene;
use crate::transport::clearance::Clearance;
use crate::transport::facets::path::FacetPaths;
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::{Cone, SharedPlaces, Source, SurfacePatch};
use crate::transport::fixed_signature::PathFollower;
use crate::transport::flux::Flux;
use crate::transport::scatter::ShadingNormals;
use crate::transport::signature::Signature;

/// Least number of patches of one task: of a surface with few patches it makes some hundred tasks. Polygons
/// of facets share no paths: of these, one is enough.
const LEAST_OF_TASK: usize = 16;
/// Most patches of one task: it is so large that most neighbours, which share paths, are in one task.
const MOST_OF_TASK: usize = 512;
/// Number of tasks between the two.
const TASKS: usize = 128;

/// A source and the light space over its first surfaces.
#[derive(Clone, Debug)]
pub struct BeamLight {
    /// The origin of the light.
    pub source: Source,
    /// The patches that its light may reach.
    pub patches: Vec<SurfacePatch>,
}

impl BeamLight {
    /// The facets that its light is followed by as polygons, and the patches that are divided into cells.
    pub fn parts(&self, facets: &Facets) -> (Vec<u32>, Vec<SurfacePatch>) {
        match Cone::of(&self.source) {
            // Its patches are parts of facets only, and the cone's border is none of the facets' edges.
            Some(_) => (Vec::new(), self.patches.clone()),
            None => part_patches(facets, &self.patches),
        }
    }
}

/// The inputs that all passes of a run share.
pub struct Passes<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The sensor.
    pub target: &'a Target,
    /// The clearance test of the scene.
    pub clearance: &'a Clearance<'a>,
    /// Places that faces of smooth meshes share.
    pub shared: &'a SharedPlaces<'a>,
    /// Flat faces.
    pub facets: &'a Facets,
    /// Effect of interpolated normals on flux.
    pub shading_normals: ShadingNormals,
    /// Flux \[W\], about, that a film must have room for.
    pub flux: f64,
    /// Limits that end a pass.
    pub limit: &'a Limit<'a>,
    /// Progress, which counts finished patches.
    pub progress: &'a Progress,
}

/// The results of a pass.
pub struct PassLayer {
    /// Sums on the film.
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
    /// Cells that a border between topologies crosses.
    pub cut_cells: u64,
    /// Cells with a part that no line divides.
    pub unresolved_cells: u64,
    /// Flux \[W\] on the film. For a camera it is that of its radiance with the étendue of a typical pixel.
    pub received: Rgb,
    /// Uncertain flux \[W\] that borders may have misplaced, in the same unit.
    #[serde(rename = "slack")]
    pub uncertain: Rgb,
    /// Light \[W\] that set out, mean of channels, as this signature's cells sum it up. It is the same for
    /// all signatures but for quadrature.
    pub emitted: f64,
    /// |received on the film − sum over its texels| / emitted: deposits lose nothing.
    pub balance_error: f64,
}

/// The balance of some patches, and the work that they took.
type TaskWork<const N: usize> = (Balance<N>, TraversalCounters);

/// The work of some patches; `None` if it was stopped.
type TaskResult<const N: usize> = Option<TaskWork<N>>;

impl Passes<'_> {
    /// One signature at one tolerance; `None` if it was stopped.
    ///
    /// # Errors
    ///
    /// If a texel's flux is not representable.
    pub fn signature(
        &self,
        lights: &[BeamLight],
        signature: Signature,
        limits: Limits,
        counters: &mut TraversalCounters,
    ) -> Result<Option<PassLayer>, Error> {
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
    ) -> Result<Option<PassLayer>, Error> {
        // Uncertain flux may count the same flux in several texels, and the discovery is coarse.
        let scale = FixedPoint::for_total(64.0 * self.flux).map_err(|_| not_representable())?;
        let film = BeamFilm::<N>::new(self.target.size(), scale);
        let done: Vec<Vec<TaskResult<N>>> = lights
            .par_iter()
            .map(|light| self.light(light, signature, limits, &film))
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
            return Err(not_representable());
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

    /// The paths of one source's light by way of flat facets.
    pub(super) fn paths<'p>(
        &'p self,
        light: &'p BeamLight,
        signature: Signature,
    ) -> FacetPaths<'p> {
        FacetPaths::new(
            self.scene,
            &light.source,
            self.facets,
            signature,
            self.shading_normals,
        )
    }

    /// One source's light, in tasks of some patches.
    fn light<const N: usize>(
        &self,
        light: &BeamLight,
        signature: Signature,
        limits: Limits,
        film: &BeamFilm<N>,
    ) -> Vec<TaskResult<N>> {
        // Memory to work in, handed from task to task.
        let idle: Mutex<Vec<Scratch<N>>> = Mutex::new(Vec::new());
        let screen = self.target.screen();
        let paths = self.paths(light, signature);
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
            self.progress.add(count as u64);
            if let Ok(mut idle) = idle.lock() {
                idle.push(scratch);
            }
            Some((balance, counters))
        };
        let (flat, patches) = light.parts(self.facets);
        let task = |patches: usize, least: usize| (patches / TASKS).clamp(least, MOST_OF_TASK);
        let by_cells = patches
            .par_chunks(task(patches.len(), LEAST_OF_TASK))
            .map(|patches| {
                refined(patches.len(), &|refiner| {
                    for patch in patches {
                        refiner.refine(patch);
                    }
                    TaskWork::default()
                })
            });
        let by_facets = flat.par_chunks(task(flat.len(), 1)).map(|facets| {
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

fn not_representable() -> Error {
    let reason =
        "a texel's flux is not representable: NaN, infinite, or far beyond the emitters' flux";
    Error::NotRepresentable(reason.to_owned())
}
