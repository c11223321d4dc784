//! The work of a pass before it begins.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::facets::{FacetRefiner, by_events, facet_of};
use super::film::BeamFilm;
use super::light::BeamLight;
use super::limit::Limit;
use super::pass::Passes;
use super::refine::{Asked, Refiner, Scratch, Sounding};
use crate::numeric::{FixedPoint, Stream, StreamKind};
use crate::run::Budget;
use crate::transport::first_surface::SurfacePatch;
use crate::transport::signature::Signature;

/// Ways down that are taken for each signature and source. Their work differs by a few times their mean: so
/// many tell the mean to some ten percent.
const WAYS: usize = 128;

/// Part of the facets that are followed, and range of their number: polygons have no ways down.
const OF_FACETS: usize = 16;
const FACETS: std::ops::RangeInclusive<usize> = 4..=64;

/// Most work of one facet or way \[rays\]: a facet may have no end.
const MOST_WORK: u64 = 1 << 15;

/// Key of the stream of the ways.
const SEED: u64 = 0x464f_5245_4341;

/// The work of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forecast {
    /// Rays, about: the same on any machine.
    pub rays: f64,
    /// Time, about, of all threads of this one.
    pub time: Duration,
    /// True if photons measure some of the light.
    pub by_photons: bool,
    /// Work \[rays\], that of cells included, after which beams give up before their first pass is done.
    /// `None` if they are not to: photons must measure none of the light.
    pub most_work: Option<u64>,
}

/// Work found on signatures.
type FoundWork = Vec<(Signature, Sounding)>;

/// Likely work of each signature.
pub type WorkBySignature = BTreeMap<Signature, Sounding>;

/// The patches and facets of a light that stand for all of them, each with the number of those.
pub struct Sample {
    patches: Vec<(SurfacePatch, f64)>,
    facets: Vec<(u32, f64)>,
}

impl Sample {
    /// Those of one light, the same on any machine.
    pub fn of(passes: &Passes, light: &BeamLight, index: usize) -> Self {
        let stream = Stream::new(StreamKind::Random, SEED).split(index as u64);
        let (flat, patches) = light.parts(passes.facets);
        let emitted = |patch: &SurfacePatch| emitted(passes, light, patch);
        let of_patches: Vec<f64> = patches.par_iter().map(emitted).collect();
        let mut by_facet = vec![0.0; passes.facets.len()];
        if !flat.is_empty() {
            for patch in &light.patches {
                if let Some(facet) = facet_of(passes.facets, patch) {
                    by_facet[facet as usize] += emitted(patch);
                }
            }
        }
        let of_facets: Vec<f64> = flat.iter().map(|one| by_facet[*one as usize]).collect();
        let few = (flat.len() / OF_FACETS).clamp(*FACETS.start(), *FACETS.end());
        let drawn_patches = drawn(&of_patches, WAYS, stream.split(0));
        let drawn_facets = drawn(&of_facets, few, stream.split(1));
        let patch = |(at, stands_for)| (patches[at], stands_for);
        let facet = |(at, stands_for): (usize, f64)| (flat[at], stands_for);
        Self {
            patches: drawn_patches.into_iter().map(patch).collect(),
            facets: drawn_facets.into_iter().map(facet).collect(),
        }
    }
}

/// Some `count` of all that light sets out to, each with the number of those that it stands for.
///
/// Half of them are drawn by number and half by light: a few large ones may take most of the work.
fn drawn(emitted: &[f64], count: usize, stream: Stream) -> Vec<(usize, f64)> {
    let all: f64 = emitted.iter().sum();
    let even = 1.0 / emitted.len().max(1) as f64;
    let mut sample = Vec::new();
    let (mut end, mut done) = (0.0, 0);
    for (index, emitted) in emitted.iter().enumerate() {
        let probability = if all > 0.0 {
            0.5 * (even + emitted / all)
        } else {
            even
        };
        end += probability;
        // One in each of as many equal parts of the probability.
        while done < count && done as f64 + stream.extra(done as u64, 0) < end * count as f64 {
            sample.push((index, 1.0 / (probability * count as f64)));
            done += 1;
        }
    }
    sample
}

/// Flux \[W\] that sets out to a patch, about, for a strength of 1.
fn emitted(passes: &Passes, light: &BeamLight, patch: &SurfacePatch) -> f64 {
    let [a, b, c] = patch.corners;
    let (world, middle) = (passes.scene.world(), (a + b + c) / 3.0);
    let emitted = patch.chart.emitted(world, &light.source, middle);
    emitted.unwrap_or(0.0) * patch.area()
}

impl Passes<'_> {
    /// Likely work of some signatures that are followed together, from a sample of each light.
    pub fn sound(&self, lights: &[(&BeamLight, Sample)], asked: &[Asked]) -> WorkBySignature {
        if self.target.is_achromatic(self.scene) {
            self.sound_in::<1>(lights, asked)
        } else {
            self.sound_in::<3>(lights, asked)
        }
    }

    fn sound_in<const N: usize>(
        &self,
        lights: &[(&BeamLight, Sample)],
        asked: &[Asked],
    ) -> WorkBySignature {
        let mut all = WorkBySignature::new();
        // What is put on it is of no use, so that it need not be right.
        let Ok(scale) = FixedPoint::for_total(64.0 * self.flux) else {
            return all;
        };
        let mut asked = asked.to_vec();
        asked.sort_by(|a, b| by_events(a.0, b.0));
        let film = BeamFilm::<N>::new(self.target.size(), scale);
        let screen = self.target.screen();
        for (light, sample) in lights {
            let paths = self.paths(light);
            let sound = |asked: &[Asked], work: &dyn Fn(&mut [Refiner<'_, N>]) -> FoundWork| {
                let limit = Limit::new(&Budget::default(), self.progress, Instant::now())
                    .guarded(Some(MOST_WORK));
                let events = asked.iter().map(|(signature, _)| signature.len()).max();
                let scratch = RefCell::new(Scratch::new(events.unwrap_or(0)));
                let mut refiners: Vec<Refiner<'_, N>> = asked
                    .iter()
                    .map(|one| self.refiner(light, &screen, *one, &film, &limit, &scratch))
                    .collect();
                work(&mut refiners)
            };
            let ways = asked.par_iter().flat_map(|one| {
                let stream = Stream::new(StreamKind::Random, SEED).split(u64::from(one.0.key()));
                let ways = sample.patches.par_iter().enumerate();
                ways.map(move |(way, drawn)| (one, stream, way, drawn))
            });
            let ways = ways.map(|(one, stream, way, (patch, stands_for))| {
                let found = sound(std::slice::from_ref(one), &|refiners| {
                    let mut level = 0;
                    let work = refiners[0].sound(patch, || {
                        level += 1;
                        stream.extra(way as u64, level)
                    });
                    vec![(one.0, work)]
                });
                (found, *stands_for)
            });
            let facets = sample.facets.par_iter().map(|(facet, stands_for)| {
                let found = sound(&asked, &|refiners| {
                    let began = Instant::now();
                    FacetRefiner::new(&paths, &screen, self.clearance, refiners).refine(*facet);
                    let time = began.elapsed();
                    let places: u64 = refiners.iter().map(Refiner::places).sum();
                    // Those that share polygons share the time, by their places.
                    let work = refiners.iter().map(|one| {
                        let part = one.places() as f64 / places.max(1) as f64;
                        let time = time.mul_f64(part);
                        let rays = one.counters().rays;
                        (one.signature(), Sounding::new(rays, one.places(), time))
                    });
                    work.collect()
                });
                (found, *stands_for)
            });
            // In order: the same on any threads.
            let found: Vec<(FoundWork, f64)> = ways.chain(facets).collect();
            for (found, stands_for) in found {
                for (signature, work) in found {
                    *all.entry(signature).or_default() += work * stands_for;
                }
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::beams::run::forecast;
    use crate::reference::beams::{BeamSettings, Chaotic, DEFAULT_ERROR};
    use crate::run::Budget;

    fn of(scene: &str) -> (Forecast, u64) {
        let size = [("size".to_owned(), "64".to_owned())];
        let scene = crate::mitsuba::load(format!("scenes/{scene}.xml").as_ref(), &size).unwrap();
        let sensor = &scene.sensors()[0];
        let (estimate, _) = crate::reference::beams::run(
            &scene,
            sensor,
            BeamSettings::default(),
            &Budget::default(),
            &crate::run::Progress::default(),
        )
        .unwrap();
        let settings = BeamSettings::default();
        let forecast = forecast(&scene, sensor, settings, DEFAULT_ERROR);
        (forecast.unwrap(), estimate.counters.rays)
    }

    #[test]
    fn a_forecast_tells_the_rays_of_smooth_cells_and_of_flat_facets_to_a_factor() {
        // The work of a way varies by some times its mean, over 128 ways: a factor of 2. The discovery
        // and a second pass are no part of it, and four of the diamond's facets are asked: another 2.
        for scene in ["glass-ball", "diamond"] {
            let (forecast, rays) = of(scene);
            let ratio = forecast.rays / rays as f64;
            assert!(
                (0.25..4.0).contains(&ratio),
                "{scene}: {forecast:?}, {rays} rays"
            );
        }
    }

    #[test]
    fn beams_give_up_unless_they_are_to_keep_all_light() {
        let size = [("size".to_owned(), "64".to_owned())];
        let scene = crate::mitsuba::load("scenes/glass-ball.xml".as_ref(), &size).unwrap();
        let of = |chaotic| {
            let settings = BeamSettings {
                chaotic,
                ..BeamSettings::default()
            };
            forecast(&scene, &scene.sensors()[0], settings, 0.1).unwrap()
        };
        // A short run: the least work after which it ends.
        assert_eq!(of(Chaotic::Photons).most_work, Some(1_000_000_000));
        assert_eq!(of(Chaotic::Beams).most_work, None);
    }

    #[test]
    fn all_that_is_drawn_stands_for_all() {
        let stream = Stream::new(StreamKind::Random, 1);
        let emitted: Vec<f64> = (0..1000).map(|index| f64::from(index % 10 == 0)).collect();
        let sample = drawn(&emitted, 200, stream);
        assert_eq!(sample.len(), 200);
        // 1000 in all, of which 100 are lit: half of the sample by light finds these.
        let number: f64 = sample.iter().map(|(_, stands_for)| stands_for).sum();
        let lit = |(index, _): &&(usize, f64)| index % 10 == 0;
        let lit_number: f64 = sample.iter().filter(lit).map(|(_, one)| one).sum();
        // Strata are as wide as 2 to 10 elements: no more than that is lost at either end of a hundred runs.
        assert!((number - 1000.0).abs() < 100.0, "{number}");
        assert!((lit_number - 100.0).abs() < 20.0, "{lit_number}");
        assert!(drawn(&[], 4, stream).is_empty());
    }
}
