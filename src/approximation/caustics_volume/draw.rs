//! Stage `splat`: discs drawn on the points that the sensor sees.
//!
//! The film is divided into tiles, these into quarters, and so on: each part has the box of its points, and
//! the discs whose boxes meet it.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::splat::Disc;
use super::work::Work;
use crate::approximation::SensorFilm;
use crate::approximation::sensor::measured;
use crate::geometry::{Bounds, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::Scene;

/// Texels along each side of a tile.
const TILE: usize = 32;

/// Texels along each side of the smallest part that has a list of discs of its own.
const LEAST: usize = 4;

/// Irradiance, or a camera's radiance, of the discs at the middles of a film's texels.
pub fn draw(scene: &Scene, film: &SensorFilm, discs: &[Disc], work: &mut Work) -> Vec<Rgb> {
    let [width, height] = film.size();
    let columns = width.div_ceil(TILE);
    let boxes: Vec<(DVec3, DVec3)> = discs
        .iter()
        .map(|disc| (disc.center, disc.half()))
        .collect();
    let mut values = vec![Rgb::BLACK; width * height];
    // Tiles of a band are there at the same time, not those of all.
    let done: Vec<Work> = values
        .par_chunks_mut(TILE * width)
        .enumerate()
        .map(|(row, band)| {
            let drawn = |column: usize| {
                let mut work = Work::default();
                let mut tile = Tile::new(scene, film, [column * TILE, row * TILE], &mut work);
                let all: Vec<u32> = match tile.reach([0, 0], TILE) {
                    Some(reach) => near(&reach, 0..discs.len() as u32, &boxes),
                    None => Vec::new(),
                };
                tile.descend([0, 0], TILE, (discs, &boxes), &all, &mut work);
                (tile.values, work)
            };
            let (tiles, done): (Vec<Vec<Rgb>>, Vec<Work>) =
                (0..columns).into_par_iter().map(drawn).unzip();
            for (row, line) in band.chunks_mut(width).enumerate() {
                for (part, tile) in line.chunks_mut(TILE).zip(&tiles) {
                    part.copy_from_slice(&tile[row * part.len()..][..part.len()]);
                }
            }
            let mut work = Work::default();
            for one in done {
                work += one;
            }
            work
        })
        .collect();
    for one in done {
        *work += one;
    }
    values
}

/// The discs whose boxes meet a box, in their order.
fn near(reach: &Bounds, all: impl Iterator<Item = u32>, boxes: &[(DVec3, DVec3)]) -> Vec<u32> {
    let (center, half) = (reach.center(), 0.5 * reach.extent());
    all.filter(|disc| {
        let (at, size) = boxes[*disc as usize];
        (at - center).abs().cmple(half + size).all()
    })
    .collect()
}

/// A point as discs ask for it, without the rest of what a sensor knows: a tile's stay in a core's cache.
struct Seen {
    position: DVec3,
    normal: DVec3,
    albedo: Option<Rgb>,
}

/// A square of texels.
struct Tile {
    size: [usize; 2],
    points: Vec<Option<Seen>>,
    values: Vec<Rgb>,
}

impl Tile {
    fn new(scene: &Scene, film: &SensorFilm, place: [usize; 2], work: &mut Work) -> Self {
        let [width, height] = film.size();
        let size = [TILE.min(width - place[0]), TILE.min(height - place[1])];
        let mut counters = TraversalCounters::default();
        let mut points = Vec::with_capacity(size[0] * size[1]);
        for row in 0..size[1] {
            for column in 0..size[0] {
                let texel = (place[1] + row) * width + place[0] + column;
                let (_, point) = film.point(scene, texel, DVec2::splat(0.5), &mut counters);
                points.push(point.map(|point| Seen {
                    position: point.point.position,
                    normal: point.normal,
                    albedo: point.albedo,
                }));
            }
        }
        work.add_rays(counters);
        Self {
            size,
            values: vec![Rgb::BLACK; points.len()],
            points,
        }
    }

    /// The box of the points of a square part; `None` if there are none.
    fn reach(&self, [left, top]: [usize; 2], side: usize) -> Option<Bounds> {
        let [columns, rows] = self.size;
        let lines = top..(top + side).min(rows);
        let points = lines.flat_map(|row| {
            self.points[row * columns..][left..(left + side).min(columns)]
                .iter()
                .flatten()
        });
        let bounds = Bounds::from_points(points.map(|point| point.position));
        (!bounds.is_empty()).then_some(bounds)
    }

    /// Draws discs that may hold points of a square part.
    fn descend(
        &mut self,
        [left, top]: [usize; 2],
        side: usize,
        (discs, boxes): (&[Disc], &[(DVec3, DVec3)]),
        found: &[u32],
        work: &mut Work,
    ) {
        if found.is_empty() {
            return;
        }
        let [columns, rows] = self.size;
        if side <= LEAST {
            for row in top..(top + side).min(rows) {
                for texel in row * columns + left..row * columns + (left + side).min(columns) {
                    let Some(point) = &self.points[texel] else {
                        continue;
                    };
                    work.fragments += found.len() as u64;
                    let mut sum = Rgb::BLACK;
                    for &disc in found {
                        let disc = &discs[disc as usize];
                        if disc.holds(point.position, point.normal) {
                            sum += disc.irradiance;
                        }
                    }
                    self.values[texel] = measured(point.albedo, sum);
                }
            }
            return;
        }
        let half = side / 2;
        for place in [
            [left, top],
            [left + half, top],
            [left, top + half],
            [left + half, top + half],
        ] {
            if place[0] >= columns || place[1] >= rows {
                continue;
            }
            if let Some(reach) = self.reach(place, half) {
                let near = near(&reach, found.iter().copied(), boxes);
                self.descend(place, half, (discs, boxes), &near, work);
            }
        }
    }
}
