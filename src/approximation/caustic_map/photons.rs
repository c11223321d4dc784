//! Photons through the stages `view`, `refraction`, `hit` and `flux`, tile after tile of the photon buffer.
//!
//! A tile's photons take one stage after the other while they are in a core's cache. Rays of a tile are
//! neighbours, and so find the same parts of meshes.

use std::time::Instant;

use glam::DVec2;
use rayon::prelude::*;

use super::buffers::{Back, Front, back};
use super::hit::Place;
use super::refraction::Exit;
use super::splat::Photon;
use super::spread::spread;
use super::trace::Tracer;
use super::work::Work;
use crate::approximation::LightView;
use crate::geometry::TraversalCounters;

/// Pixels along each side of a tile.
const TILE: usize = 16;

/// What tiles did in one of the four stages.
#[derive(Clone, Copy, Debug, Default)]
pub struct Done {
    /// Counted.
    pub work: Work,
    /// On the clock of whichever thread it was, added up \[s\].
    pub thread_seconds: f64,
}

/// The four stages, in order.
pub type Stages = [Done; 4];

/// Stages' places in [`Stages`].
const VIEW: usize = 0;
const REFRACTION: usize = 1;
const HIT: usize = 2;
const FLUX: usize = 3;

/// What a pixel of the photon buffer became.
struct Sent<T> {
    /// Its image point.
    at: DVec2,
    what: T,
}

/// A photon on a receiver, and how it came there.
struct Arrived {
    exit: Exit,
    place: Place,
}

/// Photons at the pixels' centres, shifted by `shift` pixels: those on each of some maps, by tiles and in
/// each by rows.
pub fn photons(tracer: &Tracer, maps: &[LightView], shift: DVec2) -> (Vec<Vec<Photon>>, Stages) {
    let tiles = tracer.view.side().div_ceil(TILE);
    let done: Vec<(Vec<Vec<Photon>>, Stages)> = (0..tiles * tiles)
        .into_par_iter()
        .map(|tile| through_stages(tracer, maps, shift, [tile % tiles, tile / tiles]))
        .collect();
    let mut all: Vec<Vec<Photon>> = vec![Vec::new(); maps.len()];
    let mut stages = Stages::default();
    for (photons, did) in done {
        for (all, photons) in all.iter_mut().zip(photons) {
            all.extend(photons);
        }
        for (sum, did) in stages.iter_mut().zip(did) {
            sum.work += did.work;
            sum.thread_seconds += did.thread_seconds;
        }
    }
    let pixels = (tracer.view.side() * tracer.view.side()) as u64;
    // Positions and normals, of three numbers each.
    stages[VIEW].work.bytes += pixels * 2 * 3 * tracer.settings.view.bytes();
    (all, stages)
}

/// Image points of a tile's photons; `None` where the whole tile is beside all that is specular.
fn image_points(tracer: &Tracer, shift: DVec2, tile: [usize; 2]) -> (Vec<DVec2>, bool) {
    let side = tracer.view.side();
    let [columns, rows] = tile.map(|index| index * TILE..((index + 1) * TILE).min(side));
    let at = |column: usize, row: usize| DVec2::new(column as f64, row as f64) + 0.5 + shift;
    let [low, high] = tracer.window;
    let (first, last) = (
        at(columns.start, rows.start),
        at(columns.end - 1, rows.end - 1),
    );
    let is_beside = first.cmpgt(high).any() || last.cmplt(low).any();
    let points = rows.flat_map(|row| columns.clone().map(move |column| at(column, row)));
    (points.collect(), is_beside)
}

fn through_stages(
    tracer: &Tracer,
    maps: &[LightView],
    shift: DVec2,
    tile: [usize; 2],
) -> (Vec<Vec<Photon>>, Stages) {
    let mut stages = Stages::default();
    let (points, is_beside) = image_points(tracer, shift, tile);
    if is_beside {
        stages[VIEW].work.photons += points.len() as u64;
        stages[VIEW].work.dropped += points.len() as u64;
        return (Vec::new(), stages);
    }
    let fronts: Vec<Sent<Front>> = timed(&mut stages[VIEW], |work| {
        let front = |at| tracer.front(at, work).map(|what| Sent { at, what });
        points.into_iter().filter_map(front).collect()
    });
    let exits: Vec<Sent<Exit>> = timed(&mut stages[REFRACTION], |work| {
        let exit = |Sent { at, what }: Sent<Front>| {
            let what = tracer.exit(at, &what, work)?;
            Some(Sent { at, what })
        };
        fronts.into_iter().filter_map(exit).collect()
    });
    let arrived: Vec<Sent<Arrived>> = timed(&mut stages[HIT], |work| {
        let arrive = |Sent { at, what: exit }: Sent<Exit>| {
            let place = tracer.place(&exit, work)?;
            let what = Arrived { exit, place };
            Some(Sent { at, what })
        };
        exits.into_iter().filter_map(arrive).collect()
    });
    let photons = timed(&mut stages[FLUX], |work| {
        work.photons += arrived.len() as u64;
        let on_map = |map| {
            arrived
                .iter()
                .filter_map(move |sent| drawn(tracer, map, sent))
        };
        maps.iter().map(|map| on_map(map).collect()).collect()
    });
    (photons, stages)
}

/// A photon as it is drawn on a map; `None` where it is behind the light there.
fn drawn(tracer: &Tracer, map: &LightView, sent: &Sent<Arrived>) -> Option<Photon> {
    let Arrived { exit, place } = &sent.what;
    let low = sent.at - 0.5;
    let emitted = tracer.emitted(sent.at, low, low + 1.0);
    Some(Photon {
        at: map.project(place.position)?.at,
        flux: emitted * exit.throughput,
        spread: spread(tracer.settings, tracer.mode, tracer.view, map, exit, place),
    })
}

/// Runs a tile's part of a stage on the clock.
fn timed<T>(done: &mut Done, part: impl FnOnce(&mut Work) -> T) -> T {
    let start = Instant::now();
    let result = part(&mut done.work);
    done.thread_seconds += start.elapsed().as_secs_f64();
    result
}

/// The picture of back faces, at pixels' centres.
pub fn backs(tracer: &Tracer) -> (Vec<Option<Back>>, Work) {
    let side = tracer.view.side();
    let mut backs = vec![None; side * side];
    let counters = backs
        .par_chunks_mut(side)
        .enumerate()
        .map(|(row, backs)| {
            let mut counters = TraversalCounters::default();
            for (column, found) in backs.iter_mut().enumerate() {
                let at = DVec2::new(column as f64, row as f64) + 0.5;
                // Rasterised once: that the front is found again is no work of the technique's.
                *found = tracer.front(at, &mut Work::default()).and_then(|front| {
                    let buffers = tracer.settings.view;
                    back(tracer.scene, tracer.view, &front, buffers, &mut counters)
                });
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
    (backs, work)
}
