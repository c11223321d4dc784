//! Light of some path signatures and sources, each signature at one tolerance.

use std::ops::Range;
use std::sync::Mutex;

use rayon::prelude::*;

use super::bars::bounded;
use super::facets::{FacetRefiner, Followed, by_events, part_patches};
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
use crate::transport::screen::Screen;
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
    /// The work that its cells took, and the polygons that it shares with others behind it.
    pub counters: TraversalCounters,
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

/// A signature to be followed, and the limits of its division.
pub type Asked = (Signature, Limits);

/// What a task did for one of the signatures.
struct Done<const N: usize> {
    /// Its number.
    signature: usize,
    balance: Balance<N>,
    counters: TraversalCounters,
}

/// What a task did; `None` if it was stopped.
type TaskResult<const N: usize> = Option<Vec<Done<N>>>;

impl Passes<'_> {
    /// Some signatures, each at its tolerance; `None` if work was stopped. Those that begin with the same
    /// events share the polygons of flat facets.
    ///
    /// # Errors
    ///
    /// If a texel's flux is not representable.
    pub fn signatures(
        &self,
        lights: &[BeamLight],
        asked: &[Asked],
    ) -> Result<Option<Vec<PassLayer>>, Error> {
        if self.target.is_achromatic(self.scene) {
            self.in_channels::<1>(lights, asked)
        } else {
            self.in_channels::<3>(lights, asked)
        }
    }

    fn in_channels<const N: usize>(
        &self,
        lights: &[BeamLight],
        asked: &[Asked],
    ) -> Result<Option<Vec<PassLayer>>, Error> {
        // Uncertain flux may count the same flux in several texels, and the discovery is coarse.
        let scale = FixedPoint::for_total(64.0 * self.flux).map_err(|_| not_representable())?;
        let mut order: Vec<usize> = (0..asked.len()).collect();
        order.sort_by(|a, b| by_events(asked[*a].0, asked[*b].0));
        let sorted: Vec<Asked> = order.iter().map(|index| asked[*index]).collect();
        let film = |_| BeamFilm::<N>::new(self.target.size(), scale);
        let films: Vec<BeamFilm<N>> = sorted.iter().map(film).collect();
        let done: Vec<Vec<TaskResult<N>>> = lights
            .par_iter()
            .map(|light| self.light(light, &sorted, &films))
            .collect();
        let mut totals = vec![(Balance::<N>::default(), TraversalCounters::default()); asked.len()];
        // In the order of the patches: floats are summed the same on any threads.
        for task in done.into_iter().flatten() {
            let Some(task) = task else {
                return Ok(None);
            };
            for done in task {
                let (balance, counters) = &mut totals[done.signature];
                *balance += done.balance;
                *counters += done.counters;
            }
        }
        let mut layers: Vec<(usize, PassLayer)> = Vec::new();
        for (((index, film), (signature, _)), (balance, counters)) in
            order.into_iter().zip(films).zip(sorted).zip(totals)
        {
            layers.push((index, layer(signature, &film, &balance, counters)?));
        }
        layers.sort_by_key(|(index, _)| *index);
        Ok(Some(layers.into_iter().map(|(_, layer)| layer).collect()))
    }

    /// The paths of one source's light by way of flat facets.
    pub(super) fn paths<'p>(&'p self, light: &'p BeamLight) -> FacetPaths<'p> {
        FacetPaths::new(self.scene, &light.source, self.facets, self.shading_normals)
    }

    /// A refiner of one source's light, for one signature.
    pub(super) fn followed<'f, const N: usize>(
        &'f self,
        light: &'f BeamLight,
        screen: &'f Screen<'f>,
        (signature, limits): Asked,
        film: &'f BeamFilm<N>,
        limit: &'f Limit<'f>,
        scratch: &'f mut Scratch<N>,
    ) -> Followed<'f, N> {
        let follower = PathFollower::new(
            self.scene,
            &light.source,
            screen,
            signature,
            self.shading_normals,
        );
        Followed {
            signature,
            tolerance: limits.tolerance,
            cells: Refiner::new(
                follower,
                self.shared,
                film,
                self.clearance,
                limit,
                limits,
                scratch,
            ),
        }
    }

    /// One source's light, in tasks of some patches.
    fn light<const N: usize>(
        &self,
        light: &BeamLight,
        asked: &[Asked],
        films: &[BeamFilm<N>],
    ) -> Vec<TaskResult<N>> {
        // Memory of each signature to work in, handed from task to task.
        let idle: Vec<Mutex<Vec<Scratch<N>>>> = asked.iter().map(|_| Mutex::default()).collect();
        let screen = self.target.screen();
        let paths = self.paths(light);
        let refined =
            |signatures: Range<usize>, patches: usize, work: &dyn Fn(&mut [Followed<'_, N>])| {
                if self.limit.is_reached() {
                    return None;
                }
                let held = |index: usize| {
                    let held = idle[index].lock().ok().and_then(|mut idle| idle.pop());
                    held.unwrap_or_else(|| Scratch::new(asked[index].0.len()))
                };
                let mut scratch: Vec<Scratch<N>> = signatures.clone().map(held).collect();
                let mut followed: Vec<Followed<'_, N>> = signatures
                    .clone()
                    .zip(&mut scratch)
                    .map(|(index, scratch)| {
                        let film = &films[index];
                        self.followed(light, &screen, asked[index], film, self.limit, scratch)
                    })
                    .collect();
                work(&mut followed);
                if followed.iter().any(|one| one.cells.was_stopped()) {
                    return None;
                }
                let done = |(signature, one): (usize, Followed<'_, N>)| {
                    let counters = one.cells.counters();
                    self.limit.spend(counters.rays - one.cells.spent());
                    Done {
                        signature,
                        balance: one.cells.balance,
                        counters,
                    }
                };
                let done: Vec<Done<N>> = signatures.clone().zip(followed).map(done).collect();
                self.progress.add((patches * signatures.len()) as u64);
                for (index, scratch) in signatures.zip(scratch) {
                    if let Ok(mut idle) = idle[index].lock() {
                        idle.push(scratch);
                    }
                }
                Some(done)
            };
        let (flat, patches) = light.parts(self.facets);
        let task = |patches: usize, least: usize| (patches / TASKS).clamp(least, MOST_OF_TASK);
        let by_cells = (0..asked.len()).into_par_iter().flat_map(|signature| {
            patches
                .par_chunks(task(patches.len(), LEAST_OF_TASK))
                .map(move |patches| (signature, patches))
        });
        let by_cells = by_cells.map(|(signature, patches)| {
            refined(signature..signature + 1, patches.len(), &|followed| {
                for patch in patches {
                    followed[0].cells.refine(patch);
                }
            })
        });
        let by_facets = flat.par_chunks(task(flat.len(), 1)).map(|facets| {
            refined(0..asked.len(), facets.len(), &|followed| {
                let mut polygons = FacetRefiner::new(&paths, &screen, self.clearance, followed);
                for facet in facets {
                    polygons.refine(*facet);
                }
            })
        });
        by_cells.chain(by_facets).collect()
    }
}

/// A signature's layer from its film.
fn layer<const N: usize>(
    signature: Signature,
    film: &BeamFilm<N>,
    balance: &Balance<N>,
    counters: TraversalCounters,
) -> Result<PassLayer, Error> {
    if film.overflowed() {
        return Err(not_representable());
    }
    let bounded = bounded(film);
    let on_film = bounded
        .flux
        .iter()
        .fold(Flux::BLACK, |sum, flux| sum + *flux);
    let emitted = balance.emitted.max(f64::MIN_POSITIVE);
    let report = SignatureReport {
        name: signature.to_string(),
        cells: balance.cells,
        cut_cells: balance.cut_cells,
        unresolved_cells: balance.unresolved_cells,
        received: balance.received.rgb(),
        uncertain: balance.uncertain.rgb(),
        emitted: balance.emitted,
        balance_error: (on_film - balance.received).max_magnitude() / emitted,
    };
    Ok(PassLayer {
        sums: Sums::of(&bounded),
        report,
        counters,
    })
}

fn not_representable() -> Error {
    let reason =
        "a texel's flux is not representable: NaN, infinite, or far beyond the emitters' flux";
    Error::NotRepresentable(reason.to_owned())
}
