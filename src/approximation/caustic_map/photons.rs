//! Photons through the stages `view`, `refraction`, `hit` and `flux`, tile after tile of the photon buffer.
//!
//! A tile's photons take one stage after the other while they are in a core's cache. Rays of a tile are
//! neighbours, and so find the same parts of meshes.

use std::time::Instant;

use glam::DVec2;
use rayon::prelude::*;

use super::buffers::{Back, Backs, Front, back};
use super::hit::Place;
use super::loss::Loss;
use super::refraction::Exit;
use super::splat::Photon;
use super::spread::spread;
use super::tally::{Left, Tally};
use super::trace::Tracer;
use super::variants::{BySteps, Step};
use super::work::Work;
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;

/// Pixels along each side of a tile.
const TILE: usize = 16;

/// What tiles did in one of the stages.
#[derive(Clone, Copy, Debug, Default)]
pub struct Done {
    /// Counted.
    pub work: Work,
    /// On the clock of whichever thread it was, added up \[s\].
    pub thread_seconds: f64,
}

/// What became of a light's photons.
#[derive(Debug)]
pub struct Traced {
    /// Those on each of some maps, by tiles and in each by rows.
    pub photons: Vec<Vec<Photon>>,
    /// Work of the stages before `splat`.
    pub stages: BySteps<Done>,
    /// Their flux on the way.
    pub tally: Tally,
}

impl Traced {
    fn none(maps: usize) -> Self {
        Self {
            photons: vec![Vec::new(); maps],
            stages: Default::default(),
            tally: Tally::default(),
        }
    }

    fn work(&mut self, step: Step) -> &mut Work {
        &mut self.stages[step as usize].work
    }
}

/// What a pixel of the photon buffer became.
struct Sent<T> {
    /// Its image point.
    at: DVec2,
    /// The flux \[W\] that set out.
    flux: Rgb,
    what: T,
}

impl<T> Sent<T> {
    fn with<U>(&self, what: U) -> Sent<U> {
        Sent {
            at: self.at,
            flux: self.flux,
            what,
        }
    }
}

/// A photon on a receiver, and how it came there.
struct Arrived {
    exit: Exit,
    place: Place,
}

/// Photons at the pixels' centres, shifted by `shift` pixels.
pub fn photons(tracer: &Tracer, shift: DVec2) -> Traced {
    let tiles = tracer.view.side().div_ceil(TILE);
    let done: Vec<Traced> = (0..tiles * tiles)
        .into_par_iter()
        .map(|tile| through_stages(tracer, shift, [tile % tiles, tile / tiles]))
        .collect();
    let mut all = Traced::none(tracer.maps.len());
    for (map, photons) in all.photons.iter_mut().enumerate() {
        photons.reserve_exact(done.iter().map(|traced| traced.photons[map].len()).sum());
    }
    // In the order of tiles: sums of flux are the same bits on any threads.
    for traced in done {
        for (all, photons) in all.photons.iter_mut().zip(traced.photons) {
            all.extend(photons);
        }
        for (sum, did) in all.stages.iter_mut().zip(traced.stages) {
            sum.work += did.work;
            sum.thread_seconds += did.thread_seconds;
        }
        all.tally += traced.tally;
    }
    let pixels = (tracer.view.side() * tracer.view.side()) as u64;
    // Positions and normals, of three numbers each.
    all.work(Step::View).bytes += pixels * 2 * 3 * tracer.settings.view.bytes();
    all
}

/// The middle of a pixel, shifted by `shift` pixels.
fn point([column, row]: [usize; 2], shift: DVec2) -> DVec2 {
    DVec2::new(column as f64, row as f64) + 0.5 + shift
}

/// Image points of a tile's photons, and whether the whole tile is beside all that is specular.
fn image_points(tracer: &Tracer, shift: DVec2, tile: [usize; 2]) -> (Vec<DVec2>, bool) {
    let side = tracer.view.side();
    let [columns, rows] = tile.map(|index| index * TILE..((index + 1) * TILE).min(side));
    let [low, high] = tracer.window;
    let (first, last) = (
        point([columns.start, rows.start], shift),
        point([columns.end - 1, rows.end - 1], shift),
    );
    let is_beside = first.cmpgt(high).any() || last.cmplt(low).any();
    let points = rows.flat_map(|row| {
        columns
            .clone()
            .map(move |column| point([column, row], shift))
    });
    (points.collect(), is_beside)
}

fn through_stages(tracer: &Tracer, shift: DVec2, tile: [usize; 2]) -> Traced {
    let mut traced = Traced::none(tracer.maps.len());
    let (points, is_beside) = image_points(tracer, shift, tile);
    if is_beside {
        let work = traced.work(Step::View);
        work.photons += points.len() as u64;
        work.dropped += points.len() as u64;
        return traced;
    }
    let Traced {
        photons,
        stages,
        tally,
    } = &mut traced;
    let fronts: Vec<Sent<Front>> = timed(&mut stages[Step::View as usize], |work| {
        let found = tracer.fronts(&points, work).into_iter().zip(&points);
        let front = |(found, &at): (Result<Option<Front>, Loss>, &DVec2)| {
            let found = found.transpose()?;
            let flux = tracer.strength(at) * tracer.sent(at - 0.5, at + 0.5);
            let sent = Sent { at, flux, what: () };
            kept(tally, &sent, Left::ALL, found)
        };
        found.filter_map(front).collect()
    });
    let exits: Vec<Sent<Exit>> = timed(&mut stages[Step::Refraction as usize], |work| {
        let arriving = fronts.iter().map(|it| (it.at, &it.what));
        let exits = tracer.exits(arriving, work).into_iter().zip(&fronts);
        exits
            .filter_map(|(exit, sent)| kept(tally, sent, Left::ALL, exit))
            .collect()
    });
    let arrived: Vec<Sent<Arrived>> = timed(&mut stages[Step::Hit as usize], |work| {
        let leaving = exits.iter().map(|it| &it.what);
        let places = tracer.places(leaving, work).into_iter().zip(&exits);
        let arrive = |(place, sent): (Result<Place, Loss>, &Sent<Exit>)| {
            let exit = sent.what;
            let arrived = place.map(|place| Arrived { exit, place });
            kept(tally, sent, exit.left(), arrived)
        };
        places.filter_map(arrive).collect()
    });
    timed(&mut stages[Step::Flux as usize], |work| {
        work.photons += arrived.len() as u64;
        for sent in &arrived {
            draw(tracer, sent, photons, tally);
        }
    });
    traced
}

/// What goes on after a stage; the tally has what does not.
fn kept<T, U>(
    tally: &mut Tally,
    sent: &Sent<T>,
    left: Left,
    found: Result<U, Loss>,
) -> Option<Sent<U>> {
    match found {
        Ok(what) => Some(sent.with(what)),
        Err(loss) => {
            tally.lose(loss, sent.flux, left);
            None
        }
    }
}

/// A photon as it is drawn on each map; none where it is behind the light there.
fn draw(tracer: &Tracer, sent: &Sent<Arrived>, photons: &mut [Vec<Photon>], tally: &mut Tally) {
    let Arrived { exit, place } = &sent.what;
    let measure = tracer.carried(sent.at - 0.5, sent.at + 0.5, place.position);
    let measure = measure.filter(|_| tracer.is_on_a_map(place.position));
    let Some(measure) = measure else {
        tally.lose(Loss::OutsideMap, sent.flux, exit.left());
        return;
    };
    let drawn = tracer.strength(sent.at) * measure;
    tally.land(sent.flux, exit.left(), drawn);
    for (map, photons) in tracer.maps.iter().zip(photons) {
        photons.extend(map.project(place.position).map(|seen| Photon {
            at: seen.at,
            flux: drawn * exit.throughput,
            spread: spread(tracer.settings, tracer.mode, tracer.view, map, exit, place),
        }));
    }
}

/// Runs a tile's part of a stage on the clock.
fn timed<T>(done: &mut Done, part: impl FnOnce(&mut Work) -> T) -> T {
    let start = Instant::now();
    let result = part(&mut done.work);
    done.thread_seconds += start.elapsed().as_secs_f64();
    result
}

/// The picture of back faces, at pixels' centres, shifted by `shift` pixels.
pub fn backs(tracer: &Tracer, shift: DVec2) -> (Backs, Work) {
    let side = tracer.view.side();
    let mut pixels: Vec<Option<Back>> = vec![None; side * side];
    let kind = (tracer.settings.back, tracer.settings.view);
    let counters = pixels
        .par_chunks_mut(side)
        .enumerate()
        .map(|(row, pixels)| {
            let mut counters = TraversalCounters::default();
            let points: Vec<DVec2> = (0..side)
                .map(|column| point([column, row], shift))
                .collect();
            // Rasterised once: that the fronts are found again is no work of the technique's.
            let fronts = tracer.fronts(&points, &mut Work::default());
            for (found, front) in pixels.iter_mut().zip(fronts) {
                let front = front.ok().flatten();
                *found = front
                    .and_then(|front| back(tracer.scene, tracer.view, &front, kind, &mut counters));
            }
            counters
        })
        .reduce(TraversalCounters::default, |mut a, b| {
            a += b;
            a
        });
    let mut work = Work {
        // A normal and a depth.
        bytes: (side * side) as u64 * (3 * tracer.settings.view.bytes() + 4),
        ..Work::default()
    };
    work.add_rays(counters);
    (Backs { pixels, shift }, work)
}
