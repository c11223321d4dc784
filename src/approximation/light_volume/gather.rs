//! Stage `inside`, exact: the beams whose cross-sections hold a point, tile by tile.

use glam::DVec2;
use rayon::prelude::*;

use super::search::{BeamSearch, Drawn};
use super::shade::{ShadeWork, Shading};
use super::slicing::LocalBox;
use super::sums::Sum;
use crate::approximation::SensorFilm;
use crate::approximation::sensor::{SensorPoint, midpoint};
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;

/// Points along each side of a tile: they stay in a core's cache.
const TILE: usize = 16;

/// Points along each side of the smallest part of a tile that has a list of beams of its own.
const LEAST: usize = 2;

/// Texel averages of the sensor's quantity, of one light.
pub struct Gathered {
    /// Row by row, by the source's strength and the water's colour.
    pub values: Vec<Rgb>,
    /// Work.
    pub work: ShadeWork,
    /// View rays.
    pub views: TraversalCounters,
}

impl Gathered {
    /// Its three parts.
    pub fn into_parts(self) -> (Vec<Rgb>, ShadeWork, TraversalCounters) {
        (self.values, self.work, self.views)
    }
}

/// Gathers the light of beams at the points of a film, `samples` x `samples` a texel, a power of two up to
/// 16.
pub fn gather(shading: &Shading, drawn: &[Drawn], film: &SensorFilm, samples: u32) -> Gathered {
    let [width, height] = film.size();
    let search = BeamSearch::new(drawn, shading.lit.slicing.bottom());
    let side = TILE / samples as usize;
    let columns = width.div_ceil(side);
    let mut values = vec![Rgb::BLACK; width * height];
    // Tiles of a band are there at the same time, not those of all.
    let bands: Vec<(ShadeWork, TraversalCounters)> = values
        .par_chunks_mut(side * width)
        .enumerate()
        .map(|(row, band)| {
            let tile = |column: usize| {
                let place = [column * side, row * side];
                if shading.lit.progress.is_stopped() {
                    let size = size_of(film, place, side);
                    return (Tile::dark(size), ShadeWork::default());
                }
                let mut points = TilePoints::new(shading, film, place, samples as usize);
                let work = points.gather(shading, &search, drawn);
                (points.averages(shading), work)
            };
            let tiles: Vec<(Tile, ShadeWork)> = (0..columns).into_par_iter().map(tile).collect();
            let (mut work, mut views) = (ShadeWork::default(), TraversalCounters::default());
            for (column, (tile, done)) in tiles.into_iter().enumerate() {
                work += done;
                views += tile.views;
                let lines = tile.values.chunks(tile.columns);
                for (line, values) in band.chunks_mut(width).zip(lines) {
                    line[column * side..][..values.len()].copy_from_slice(values);
                }
            }
            (work, views)
        })
        .collect();
    let mut gathered = Gathered {
        values,
        work: ShadeWork::default(),
        views: TraversalCounters::default(),
    };
    for (work, views) in bands {
        gathered.work += work;
        gathered.views += views;
    }
    gathered
}

/// Columns and rows of the square of texels that begins at a place.
fn size_of(film: &SensorFilm, place: [usize; 2], side: usize) -> [usize; 2] {
    let [width, height] = film.size();
    [side.min(width - place[0]), side.min(height - place[1])]
}

/// The values of a square of texels.
struct Tile {
    columns: usize,
    values: Vec<Rgb>,
    views: TraversalCounters,
}

impl Tile {
    /// One without light.
    fn dark([columns, rows]: [usize; 2]) -> Self {
        Self {
            columns,
            values: vec![Rgb::BLACK; columns * rows],
            views: TraversalCounters::default(),
        }
    }
}

/// A point of a tile.
struct TilePoint {
    point: SensorPoint,
    /// Where it is across the axis, and its depth.
    across: DVec2,
    depth: f64,
    sum: Sum,
}

/// The points of a square of texels.
struct TilePoints {
    /// Columns and rows of texels.
    size: [usize; 2],
    samples: usize,
    /// Row by row of points; `None` on no surface.
    points: Vec<Option<TilePoint>>,
    /// By texel.
    weights: Vec<f64>,
    views: TraversalCounters,
}

impl TilePoints {
    fn new(shading: &Shading, film: &SensorFilm, place: [usize; 2], samples: usize) -> Self {
        let width = film.size()[0];
        let size = size_of(film, place, TILE / samples);
        let mut tile = Self {
            size,
            samples,
            points: Vec::with_capacity(size[0] * size[1] * samples * samples),
            weights: vec![0.0; size[0] * size[1]],
            views: TraversalCounters::default(),
        };
        for row in 0..size[1] * samples {
            for column in 0..size[0] * samples {
                let at = midpoint(
                    (row % samples * samples + column % samples) as u32,
                    samples as u32,
                );
                let (x, y) = (column / samples, row / samples);
                let texel = (place[1] + y) * width + place[0] + x;
                let (weight, point) = film.point(shading.lit.scene, texel, at, &mut tile.views);
                tile.weights[y * size[0] + x] += weight;
                tile.points.push(point.map(|point| {
                    let (across, depth) = shading.lit.slicing.local(point.point.position);
                    TilePoint {
                        point,
                        across,
                        depth,
                        sum: Sum::default(),
                    }
                }));
            }
        }
        tile
    }

    /// Columns and rows of points.
    fn sides(&self) -> [usize; 2] {
        self.size.map(|side| side * self.samples)
    }

    /// Gathers the light of beams at the points.
    fn gather(&mut self, shading: &Shading, search: &BeamSearch, drawn: &[Drawn]) -> ShadeWork {
        let mut work = ShadeWork::default();
        if let Some(target) = self.reach([0, 0], TILE) {
            let mut found = Vec::new();
            search.find(&target, &mut found);
            self.descend([0, 0], TILE, shading, (drawn, &found), &mut work);
        }
        work
    }

    /// The box of the points of a square part; `None` if there are none.
    fn reach(&self, [left, top]: [usize; 2], side: usize) -> Option<LocalBox> {
        let mut all = LocalBox::EMPTY;
        let [columns, rows] = self.sides();
        for row in top..(top + side).min(rows) {
            for point in self.points[row * columns..][left..(left + side).min(columns)]
                .iter()
                .flatten()
            {
                all.extend((point.across, point.depth));
            }
        }
        (all.depths[0] <= all.depths[1]).then_some(all)
    }

    /// A square part, with the beams that may hold its points.
    fn descend(
        &mut self,
        [left, top]: [usize; 2],
        side: usize,
        shading: &Shading,
        (drawn, found): (&[Drawn], &[u32]),
        work: &mut ShadeWork,
    ) {
        if found.is_empty() {
            return;
        }
        let [columns, rows] = self.sides();
        if side <= LEAST {
            for row in top..(top + side).min(rows) {
                let line = &mut self.points[row * columns..][left..(left + side).min(columns)];
                for point in line.iter_mut().flatten() {
                    for &place in found {
                        point.add(shading, &drawn[place as usize], work);
                    }
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
            if let Some(target) = self.reach(place, half) {
                let near = found.iter().copied();
                let near: Vec<u32> = near
                    .filter(|&it| drawn[it as usize].may_overlap(&target))
                    .collect();
                self.descend(place, half, shading, (drawn, &near), work);
            }
        }
    }

    /// The texels' averages.
    fn averages(self, shading: &Shading) -> Tile {
        let mut values = vec![Rgb::BLACK; self.weights.len()];
        let columns = self.sides()[0];
        for (index, point) in self.points.iter().enumerate() {
            let Some(point) = point else {
                continue;
            };
            let texel =
                index / columns / self.samples * self.size[0] + index % columns / self.samples;
            let irradiance = shading.irradiance(&point.sum, &point.point);
            values[texel] += point.point.measured(Rgb::grey(irradiance)) * point.point.weight;
        }
        for (value, weight) in values.iter_mut().zip(&self.weights) {
            if *weight > 0.0 {
                *value = *value / *weight;
            }
        }
        Tile {
            columns: self.size[0],
            values,
            views: self.views,
        }
    }
}

impl TilePoint {
    /// Adds the light of a beam, if the point is in it.
    #[inline]
    fn add(&mut self, shading: &Shading, drawn: &Drawn, work: &mut ShadeWork) {
        work.inside.fragments += 1;
        if self.depth < drawn.depths[0] || self.depth > drawn.depths[1] {
            return;
        }
        let Some(weights) = drawn.beam.section(self.depth).weights(self.across) else {
            return;
        };
        // Above the water's surface rays are continued only.
        if self.depth >= drawn.beam.ruling(weights).start {
            shading.add(
                &mut self.sum,
                drawn.beam,
                (weights, self.depth),
                &self.point,
                work,
            );
        }
    }
}
