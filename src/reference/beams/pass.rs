//! Light of some path signatures and sources, each signature at one tolerance.

use std::cell::RefCell;
use std::sync::{Arc, Mutex};

use rayon::prelude::*;

use super::bars::bounded;
use super::facets::{FacetRefiner, by_events};
use super::film::BeamFilm;
use super::light::BeamLight;
use super::limit::Limit;
use super::refine::{Asked, Balance, LeftLight, MOST_LEFT, Refiner, Scratch};
use super::sums::Sums;
use super::tasks::{LightParts, Task, Towards, tasks};
use super::traced::{BatchSums, ChannelSums, SignatureDone, TaskDone};
use crate::geometry::TraversalCounters;
use crate::numeric::FixedPoint;
use crate::radiometry::Rgb;
use crate::reference::Target;
use crate::reference::shard::Shard;
use crate::run::{Error, Progress};
use crate::scene::Scene;
use crate::transport::clearance::Clearance;
use crate::transport::facets::path::FacetPaths;
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::SharedPlaces;
use crate::transport::fixed_signature::PathFollower;
use crate::transport::scatter::ShadingNormals;
use crate::transport::screen::Screen;
use crate::transport::signature::Signature;

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

impl Passes<'_> {
    /// Follows a part of some signatures' light, each signature at its tolerance. Those that begin with the
    /// same events share the polygons of flat facets. `None` if work was stopped before its end.
    ///
    /// # Errors
    ///
    /// If a texel's flux is not representable.
    pub fn trace(
        &self,
        lights: &[BeamLight],
        asked: &[Asked],
        shard: Shard,
    ) -> Result<Option<BatchSums>, Error> {
        let before = self.limit.rays();
        let sums = if self.target.is_achromatic(self.scene) {
            self.trace_in::<1>(lights, asked, shard)?
                .map(BatchSums::Grey)
        } else {
            self.trace_in::<3>(lights, asked, shard)?
                .map(BatchSums::Colours)
        };
        let work = self.limit.rays() - before;
        if self.limit.is_beyond_rays() {
            return Ok(Some(BatchSums::Beyond { work }));
        }
        let Some(mut sums) = sums else {
            return Ok(None);
        };
        // Last: what is stopped is of no use, whatever is in it.
        if sums.overflowed() {
            return Err(not_representable());
        }
        sums.set_work(work);
        Ok(Some(sums))
    }

    /// True if sums are on films like those that [`trace`](Self::trace) fills.
    ///
    /// # Errors
    ///
    /// If a texel's flux is not representable.
    pub fn has_films_like(&self, sums: &BatchSums) -> Result<bool, Error> {
        let is_grey = self.target.is_achromatic(self.scene);
        let scale = self.scale()?;
        Ok(match sums {
            BatchSums::Grey(sums) => is_grey && sums.have_scale(scale),
            BatchSums::Colours(sums) => !is_grey && sums.have_scale(scale),
            BatchSums::Beyond { .. } => true,
        })
    }

    /// The scale of its films. Uncertain flux may count the same flux in several texels, and the discovery is
    /// coarse.
    fn scale(&self) -> Result<FixedPoint, Error> {
        FixedPoint::for_total(64.0 * self.flux).map_err(|_| not_representable())
    }

    fn trace_in<const N: usize>(
        &self,
        lights: &[BeamLight],
        asked: &[Asked],
        shard: Shard,
    ) -> Result<Option<ChannelSums<N>>, Error> {
        let scale = self.scale()?;
        let sorted: Vec<Asked> = order(asked).into_iter().map(|index| asked[index]).collect();
        let film = |_| BeamFilm::<N>::new(self.target.size(), scale);
        let films: Vec<BeamFilm<N>> = sorted.iter().map(film).collect();
        let parts: Vec<LightParts> = lights
            .par_iter()
            .map(|light| LightParts::new(light, self.facets))
            .collect();
        let tasks = tasks(&parts, asked.len());
        let mine = tasks.iter().enumerate().filter(|(number, _)| {
            // There are far fewer than 2³².
            u32::try_from(*number).is_ok_and(|number| shard.holds(number))
        });
        let mine: Vec<(usize, &Task)> = mine.collect();
        let screen = self.target.screen();
        let crew = Crew {
            passes: self,
            screen: &screen,
            asked: &sorted,
            films: &films,
            idle: Mutex::default(),
        };
        let done: Vec<Option<TaskDone<N>>> = mine
            .into_par_iter()
            .map(|(number, task)| {
                let signatures = crew.follow(task)?;
                Some(TaskDone { number, signatures })
            })
            .collect();
        let done: Option<Vec<TaskDone<N>>> = done.into_iter().collect();
        Ok(done.map(|done| ChannelSums {
            films: films.into_iter().map(Arc::new).collect(),
            done,
            work: 0,
        }))
    }

    /// The paths of one source's light by way of flat facets.
    pub(super) fn paths<'p>(&'p self, light: &'p BeamLight) -> FacetPaths<'p> {
        FacetPaths {
            scene: self.scene,
            source: &light.source,
            facets: self.facets,
            shading_normals: self.shading_normals,
        }
    }

    /// A refiner of one source's light, for one signature.
    pub(super) fn refiner<'f, const N: usize>(
        &'f self,
        light: &'f BeamLight,
        screen: &'f Screen<'f>,
        asked: Asked,
        film: &'f BeamFilm<N>,
        limit: &'f Limit<'f>,
        scratch: &'f RefCell<Scratch<N>>,
    ) -> Refiner<'f, N> {
        let follower = PathFollower::new(
            self.scene,
            &light.source,
            screen,
            asked.0,
            self.shading_normals,
        );
        let (shared, clearance) = (self.shared, self.clearance);
        Refiner::new(follower, shared, film, clearance, limit, asked, scratch)
    }
}

/// The order of signatures by which those are neighbours that share polygons.
fn order(asked: &[Asked]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..asked.len()).collect();
    order.sort_by(|a, b| by_events(asked[*a].0, asked[*b].0));
    order
}

/// What threads share that do the tasks of a batch.
struct Crew<'a, const N: usize> {
    passes: &'a Passes<'a>,
    screen: &'a Screen<'a>,
    asked: &'a [Asked],
    films: &'a [BeamFilm<N>],
    /// Memory to work in, handed from task to task.
    idle: Mutex<Vec<Scratch<N>>>,
}

/// Light that is left, of a signature by its number.
type LeftOf<const N: usize> = (usize, LeftLight<N>);

impl<const N: usize> Crew<'_, N> {
    /// Does a task, with other threads if it is a long one; `None` if it was stopped before its end.
    fn follow(&self, task: &Task) -> Option<Vec<SignatureDone<N>>> {
        let (mut done, left) = self.with_scratch(|scratch| self.begin(task, scratch))?;
        // In the order in which it was left: floats are summed the same on any threads.
        for rest in self.follow_left(task.light, left)? {
            done[rest.signature - task.signatures.start].add(&rest);
        }
        let patches = match task.towards {
            Towards::Patches(patches) => patches.len(),
            Towards::Facets(facets) => facets.len(),
        };
        self.passes.progress.add((patches * done.len()) as u64);
        Some(done)
    }

    /// Does a task but for the light that is left, which is returned.
    fn begin(
        &self,
        task: &Task,
        scratch: &RefCell<Scratch<N>>,
    ) -> Option<(Vec<SignatureDone<N>>, Vec<LeftOf<N>>)> {
        if self.passes.limit.is_reached() {
            return None;
        }
        let most_left = MOST_LEFT / task.signatures.len().max(1);
        let refiner = |index: usize| self.refiner(task.light, index, scratch).leaving(most_left);
        let mut refiners: Vec<Refiner<'_, N>> = task.signatures.clone().map(refiner).collect();
        match task.towards {
            Towards::Patches(patches) => {
                for refiner in &mut refiners {
                    for patch in patches {
                        refiner.refine(patch);
                    }
                }
            }
            Towards::Facets(facets) => {
                let paths = self.passes.paths(task.light);
                let clearance = self.passes.clearance;
                let mut polygons = FacetRefiner::new(&paths, self.screen, clearance, &mut refiners);
                for facet in facets {
                    polygons.refine(*facet);
                }
            }
        }
        if refiners.iter().any(Refiner::was_stopped) {
            return None;
        }
        let mut left = Vec::new();
        let refiners = task.signatures.clone().zip(refiners);
        let done = refiners.map(|(signature, mut one)| {
            left.extend(one.take_left().into_iter().map(|light| (signature, light)));
            ended(signature, one)
        });
        Some((done.collect(), left))
    }

    /// Follows pieces of light that were left, each with what it leaves itself; `None` if it was stopped
    /// before its end.
    fn follow_left(
        &self,
        light: &BeamLight,
        left: Vec<LeftOf<N>>,
    ) -> Option<Vec<SignatureDone<N>>> {
        // One by one: rayon would give a thread up to a quarter of them.
        let followed = left.into_par_iter().with_max_len(1);
        let followed = followed.map(|(signature, one)| {
            let (mut done, left) = self.with_scratch(|scratch| {
                if self.passes.limit.is_reached() {
                    return None;
                }
                let mut refiner = self.refiner(light, signature, scratch).leaving(MOST_LEFT);
                refiner.refine_left(one);
                let left = refiner.take_left().into_iter();
                let left: Vec<LeftOf<N>> = left.map(|light| (signature, light)).collect();
                (!refiner.was_stopped()).then(|| (ended(signature, refiner), left))
            })?;
            for rest in self.follow_left(light, left)? {
                done.add(&rest);
            }
            Some(done)
        });
        followed.collect()
    }

    /// Lends memory that holds no paths. Nobody who waits for other threads keeps it.
    fn with_scratch<T>(&self, work: impl FnOnce(&RefCell<Scratch<N>>) -> T) -> T {
        let held = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        let events = self.asked.iter().map(|(signature, _)| signature.len());
        let mut scratch = held.unwrap_or_else(|| Scratch::new(events.max().unwrap_or(0)));
        scratch.forget();
        let scratch = RefCell::new(scratch);
        let done = work(&scratch);
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(scratch.into_inner());
        }
        done
    }

    /// A refiner of a source's light, for a signature by its number.
    fn refiner<'f>(
        &'f self,
        light: &'f BeamLight,
        signature: usize,
        scratch: &'f RefCell<Scratch<N>>,
    ) -> Refiner<'f, N> {
        let (asked, film) = (self.asked[signature], &self.films[signature]);
        let limit = self.passes.limit;
        self.passes
            .refiner(light, self.screen, asked, film, limit, scratch)
    }
}

/// What a refiner did that is done.
fn ended<const N: usize>(signature: usize, mut refiner: Refiner<'_, N>) -> SignatureDone<N> {
    refiner.tell_limit();
    SignatureDone {
        signature,
        balance: refiner.balance,
        counters: refiner.counters(),
    }
}

/// The layers of signatures whose tasks are all done, given to `take` one by one in their order. There are
/// none of a batch that ended before.
pub(super) fn layers(sums: BatchSums, asked: &[Asked], take: impl FnMut(usize, PassLayer)) {
    match sums {
        BatchSums::Grey(sums) => layers_in(sums, asked, take),
        BatchSums::Colours(sums) => layers_in(sums, asked, take),
        BatchSums::Beyond { .. } => {}
    }
}

fn layers_in<const N: usize>(
    sums: ChannelSums<N>,
    asked: &[Asked],
    mut take: impl FnMut(usize, PassLayer),
) {
    let mut totals = vec![(Balance::<N>::default(), TraversalCounters::default()); asked.len()];
    // In the order of the tasks: floats are summed the same on any threads.
    for done in sums.done.into_iter().flat_map(|task| task.signatures) {
        let (balance, counters) = &mut totals[done.signature];
        *balance += done.balance;
        *counters += done.counters;
    }
    let done = sums.films.into_iter().zip(totals);
    let mut done: Vec<_> = order(asked).into_iter().zip(done).collect();
    done.sort_by_key(|(index, _)| *index);
    // Each film goes as its layer comes.
    for (index, (film, (balance, counters))) in done {
        take(index, layer(asked[index].0, &film, &balance, counters));
    }
}

/// A signature's layer from its film.
fn layer<const N: usize>(
    signature: Signature,
    film: &BeamFilm<N>,
    balance: &Balance<N>,
    counters: TraversalCounters,
) -> PassLayer {
    let sums = bounded(film);
    let on_film: Rgb = sums.flux.iter().copied().sum();
    let received = balance.received.rgb();
    let emitted = balance.emitted.max(f64::MIN_POSITIVE);
    let report = SignatureReport {
        name: signature.to_string(),
        cells: balance.cells,
        cut_cells: balance.cut_cells,
        unresolved_cells: balance.unresolved_cells,
        received,
        uncertain: balance.uncertain.rgb(),
        emitted: balance.emitted,
        balance_error: (on_film - received).map(f64::abs).max_channel() / emitted,
    };
    PassLayer {
        sums,
        report,
        counters,
    }
}

fn not_representable() -> Error {
    let reason =
        "a texel's flux is not representable: NaN, infinite, or far beyond the emitters' flux";
    Error::NotRepresentable(reason.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::beams::refine::Limits;
    use crate::run::Budget;
    use crate::transport::camera::Camera;

    /// A lamp above a cube.
    const LAMP: &str =
        r#"<emitter type="point"><point name="position" x="0.4" y="0.3" z="2.5"/></emitter>"#;

    /// What passes over a shipped scene are good for. The light is the scene's, or another one.
    fn with_passes<T>(
        scene: &str,
        lamp: Option<&str>,
        work: impl FnOnce(&Passes, &[BeamLight]) -> T,
    ) -> T {
        let size = [("size".to_owned(), "32".to_owned())];
        let path = std::path::absolute(format!("scenes/{scene}.xml")).unwrap();
        let mut text = std::fs::read_to_string(&path).unwrap();
        if let Some(lamp) = lamp {
            let begin = text.find("<emitter").unwrap();
            let end = text.find("</emitter>").unwrap() + "</emitter>".len();
            text.replace_range(begin..end, lamp);
        }
        let held = [(path.clone(), text.into_bytes())];
        let (scene, _) = crate::mitsuba::load_held(&path, &size, &held, false).unwrap();
        let shading_normals = ShadingNormals::default();
        let sensor = &scene.sensors()[0];
        let target = Target::new(&scene, sensor, shading_normals, Camera::new).unwrap();
        let lights = BeamLight::all(&scene);
        let progress = Progress::default();
        let passes = Passes {
            scene: &scene,
            target: &target,
            clearance: &Clearance::new(&scene),
            shared: &SharedPlaces::new(&scene, shading_normals),
            facets: &Facets::new(&scene),
            shading_normals,
            flux: 1e3,
            limit: &Limit::new(&Budget::default(), &progress, std::time::Instant::now()),
            progress: &progress,
        };
        work(&passes, &lights)
    }

    /// A signature by its name, with its tolerance \[W\].
    fn asked(name: &str, tolerance: f64) -> Asked {
        let limits = Limits {
            tolerance,
            flux: 1e3,
            peak: 1.0,
        };
        (name.parse().unwrap(), limits)
    }

    /// Layers of some signatures of a shipped scene, each with its tolerance \[W\]: all together, or each
    /// alone. The light is the scene's, or another one.
    fn layers(
        scene: &str,
        lamp: Option<&str>,
        names: &[(&str, f64)],
        together: bool,
    ) -> Vec<PassLayer> {
        let all: Vec<Asked> = names.iter().map(|(name, at)| asked(name, *at)).collect();
        with_passes(scene, lamp, |passes, lights| {
            let mut layers = Vec::new();
            for batch in all.chunks(if together { all.len() } else { 1 }) {
                let sums = passes.trace(lights, batch, Shard::WHOLE).unwrap().unwrap();
                let take = |index, layer| {
                    assert_eq!(index, layers.len() % batch.len());
                    layers.push(layer);
                };
                super::layers(sums, batch, take);
            }
            layers
        })
    }

    /// A film and the sums of what refiners put on it: one that may leave so many pieces of light, and others
    /// that go on with them. With the number of pieces.
    fn followed(
        passes: &Passes,
        light: &BeamLight,
        asked: Asked,
        most_left: usize,
    ) -> (Vec<i64>, Balance<1>, usize) {
        let scale = FixedPoint::for_total(64e3).unwrap();
        let (screen, film) = (
            passes.target.screen(),
            BeamFilm::new(passes.target.size(), scale),
        );
        let scratch = RefCell::new(Scratch::new(asked.0.len()));
        let refiner = || {
            let limit = passes.limit;
            let refiner = passes.refiner(light, &screen, asked, &film, limit, &scratch);
            refiner.leaving(most_left)
        };
        let mut first = [refiner()];
        let paths = passes.paths(light);
        let (facets, patches) = light.parts(passes.facets);
        let clearance = passes.clearance;
        let mut polygons = FacetRefiner::new(&paths, &screen, clearance, &mut first);
        for facet in &facets {
            polygons.refine(*facet);
        }
        let [mut first] = first;
        for patch in patches.iter().take(4) {
            first.refine(patch);
        }
        let (mut left, mut pieces) = (first.take_left(), 0);
        let mut balance = first.balance;
        while let Some(piece) = left.pop() {
            pieces += 1;
            let mut next = refiner();
            next.refine_left(piece);
            left.extend(next.take_left());
            balance += next.balance;
        }
        (film.quanta().collect(), balance, pieces)
    }

    #[test]
    fn light_that_is_left_to_others_is_followed_once() {
        // Hills below a prism, whose polygons are given to cells: all of a facet's light may be left, or the
        // first pieces of it. And four patches of a ball, of more than 4,096 cells each.
        for (scene, name, tolerance, most_left) in [
            ("turntable-terrain", "LTTD", 1e-5, MOST_LEFT),
            ("turntable-terrain", "LTTD", 1e-5, 2),
            ("glass-ball", "LTTD", 1e-8, MOST_LEFT),
        ] {
            with_passes(scene, None, |passes, lights| {
                let asked = asked(name, tolerance);
                let alone = followed(passes, &lights[0], asked, 0);
                let together = followed(passes, &lights[0], asked, most_left);
                println!("{scene}: {} cells, {} pieces", alone.1.cells, together.2);
                assert_eq!(alone.2, 0);
                assert!(together.2 > 1, "{scene}: {} pieces", together.2);
                assert!(alone.0 == together.0, "{scene}");
                let counts = |of: &Balance<1>| [of.cells, of.cut_cells, of.unresolved_cells];
                assert_eq!(counts(&alone.1), counts(&together.1), "{scene}");
                // Sums of some 10⁵ numbers in another order: 2⁻⁵³ of all for each, at worst.
                let off = (alone.1.emitted - together.1.emitted).abs();
                assert!(off <= 1e-10 * alone.1.emitted, "{scene}: {off}");
            });
        }
    }

    fn assert_same(a: &PassLayer, b: &PassLayer) {
        assert_eq!(a.report.name, b.report.name);
        assert_eq!(a.sums.flux, b.sums.flux, "{}", a.report.name);
        assert_eq!(a.sums.bar, b.sums.bar, "{}", a.report.name);
        assert_eq!(a.report.cells, b.report.cells, "{}", a.report.name);
        assert!(a.report.cells > 0);
    }

    fn rays(layers: &[PassLayer]) -> u64 {
        layers.iter().map(|layer| layer.counters.rays).sum()
    }

    #[test]
    fn signatures_that_share_polygons_bring_the_light_that_each_brings_alone() {
        // The last one shares its first event only; the order is none of events.
        let asked = ["LTRRTD", "LTTD", "LRD", "LTRRRTD", "LTRTD", "LTTRD"].map(|name| (name, 0.1));
        for scene in ["diamond", "lens"] {
            let [together, alone] =
                [true, false].map(|together| layers(scene, None, &asked, together));
            for (a, b) in together.iter().zip(&alone) {
                assert_same(a, b);
            }
        }
    }

    #[test]
    fn shared_polygons_are_followed_once() {
        // Each has polygons of its own on the leg after its last event. `LTRⁿTD` for n of 0 to 4 have 1 to 5
        // legs in glass before that one, all but the last shared: of 15, 5 are left. Later legs have more
        // polygons than earlier ones, so that the ratio is less far from one.
        let names = ["LTTD", "LTRTD", "LTRRTD", "LTRRRTD", "LTRRRRTD"];
        let [together, alone] = [true, false].map(|together| {
            rays(&layers(
                "diamond",
                None,
                &names.map(|name| (name, 0.1)),
                together,
            ))
        });
        assert!(together < alone * 2 / 3, "{together} of {alone} rays");
    }

    #[test]
    fn shared_polygons_are_as_fine_as_the_finest_signature_asks_for() {
        let asked = [("LTTD", 10.0), ("LTRTD", 1e-5)];
        let [together, alone] =
            [true, false].map(|together| layers("cube", Some(LAMP), &asked, together));
        assert_same(&together[1], &alone[1]);
        assert!(together[0].report.cells >= alone[0].report.cells);
    }
}
