//! Stage `inside`, exact: the beams whose cross-sections hold a point, tile by tile.

use std::ops::Range;

use rayon::prelude::*;

use super::search::{BeamSearch, Drawn};
use super::shade::{ShadeWork, Shading};
use super::slicing::LocalBox;
use super::sums::Sum;
use crate::approximation::SensorFilm;
use crate::approximation::sensor::SensorPoint;
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::scene::Scene;

/// Texels along each side of a tile: its points stay in a core's cache.
const TILE: usize = 16;

/// Texels along each side of the smallest part of a tile that has a list of beams of its own.
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

/// Gathers the light of beams at the points of a film, `samples` x `samples` a texel.
pub fn gather(shading: &Shading, drawn: &[Drawn], film: &SensorFilm, samples: u32) -> Gathered {
    let [width, height] = film.size();
    let search = BeamSearch::new(drawn, shading.lit.slicing.bottom());
    let columns = width.div_ceil(TILE);
    let tiles: Vec<(Tile, ShadeWork)> = (0..columns * height.div_ceil(TILE))
        .into_par_iter()
        .map(|index| {
            let place = [index % columns * TILE, index / columns * TILE];
            let mut tile = Tile::new(shading.lit.scene, film, place, samples);
            let work = tile.fill(shading, &search, drawn);
            (tile, work)
        })
        .collect();
    let mut gathered = Gathered {
        values: vec![Rgb::BLACK; width * height],
        work: ShadeWork::default(),
        views: TraversalCounters::default(),
    };
    for (tile, work) in tiles {
        gathered.work += work;
        gathered.views += tile.views;
        for (row, values) in tile.values.chunks(tile.size[0]).enumerate() {
            let start = (tile.place[1] + row) * width + tile.place[0];
            gathered.values[start..start + values.len()].copy_from_slice(values);
        }
    }
    gathered
}

/// A square of texels with their points.
struct Tile {
    /// Its first column and row.
    place: [usize; 2],
    /// Columns and rows.
    size: [usize; 2],
    points: Vec<SensorPoint>,
    /// The points of each texel.
    ranges: Vec<Range<usize>>,
    weights: Vec<f64>,
    views: TraversalCounters,
    values: Vec<Rgb>,
}

/// Points by their local coordinates.
type Places = [(glam::DVec2, f64)];

impl Tile {
    fn new(scene: &Scene, film: &SensorFilm, place: [usize; 2], samples: u32) -> Self {
        let [width, height] = film.size();
        let size = [TILE.min(width - place[0]), TILE.min(height - place[1])];
        let mut tile = Self {
            place,
            size,
            points: Vec::with_capacity(size[0] * size[1] * (samples * samples) as usize),
            ranges: Vec::with_capacity(size[0] * size[1]),
            weights: Vec::with_capacity(size[0] * size[1]),
            views: TraversalCounters::default(),
            values: vec![Rgb::BLACK; size[0] * size[1]],
        };
        for row in place[1]..place[1] + size[1] {
            let first = row * width + place[0];
            let found = film.points(scene, first..first + size[0], samples, &mut tile.views);
            let mut start = 0;
            for texel in first..first + size[0] {
                let count = found.points[start..]
                    .iter()
                    .take_while(|it| it.texel == texel)
                    .count();
                let end = tile.points.len() + start;
                tile.ranges.push(end..end + count);
                start += count;
            }
            tile.weights.extend(&found.weights);
            tile.points.extend(found.points);
        }
        tile
    }

    /// Fills the tile's values.
    fn fill(&mut self, shading: &Shading, search: &BeamSearch, drawn: &[Drawn]) -> ShadeWork {
        let slicing = shading.lit.slicing;
        let places: Vec<_> = self
            .points
            .iter()
            .map(|it| slicing.local(it.point.position))
            .collect();
        let mut sums = vec![Sum::default(); self.points.len()];
        let mut work = ShadeWork::default();
        if let Some(target) = self.reach(&places, [0, 0], TILE) {
            let mut found = Vec::new();
            search.find(&target, &mut found);
            let mut block = Block {
                tile: self,
                shading,
                drawn,
                places: &places,
                sums: &mut sums,
                work: &mut work,
            };
            block.descend([0, 0], TILE, &found);
        }
        for (texel, value) in self.values.iter_mut().enumerate() {
            for index in self.ranges[texel].clone() {
                let point = &self.points[index];
                let irradiance = shading.irradiance(&sums[index], point);
                *value += point.measured(Rgb::grey(irradiance)) * point.weight;
            }
            if self.weights[texel] > 0.0 {
                *value = *value / self.weights[texel];
            }
        }
        work
    }

    /// The box of the points of a square part; `None` if there are none.
    fn reach(&self, places: &Places, [left, top]: [usize; 2], side: usize) -> Option<LocalBox> {
        let mut all = LocalBox::EMPTY;
        for row in top..(top + side).min(self.size[1]) {
            for column in left..(left + side).min(self.size[0]) {
                for place in &places[self.ranges[row * self.size[0] + column].clone()] {
                    all.extend(*place);
                }
            }
        }
        (all.depths[0] <= all.depths[1]).then_some(all)
    }
}

/// The parts of a tile, each with the beams that may hold its points.
struct Block<'a> {
    tile: &'a Tile,
    shading: &'a Shading<'a>,
    drawn: &'a [Drawn<'a>],
    places: &'a Places,
    sums: &'a mut [Sum],
    work: &'a mut ShadeWork,
}

impl Block<'_> {
    fn descend(&mut self, [left, top]: [usize; 2], side: usize, found: &[u32]) {
        if found.is_empty() {
            return;
        }
        if side <= LEAST {
            self.points([left, top], side, found);
            return;
        }
        let half = side / 2;
        for place in [
            [left, top],
            [left + half, top],
            [left, top + half],
            [left + half, top + half],
        ] {
            if place[0] >= self.tile.size[0] || place[1] >= self.tile.size[1] {
                continue;
            }
            if let Some(target) = self.tile.reach(self.places, place, half) {
                let near = found.iter().copied();
                let near: Vec<u32> = near
                    .filter(|&it| self.drawn[it as usize].may_overlap(&target))
                    .collect();
                self.descend(place, half, &near);
            }
        }
    }

    /// Adds the light of beams, one after the other, at the points of a part.
    fn points(&mut self, [left, top]: [usize; 2], side: usize, found: &[u32]) {
        let [width, height] = self.tile.size;
        for row in top..(top + side).min(height) {
            for column in left..(left + side).min(width) {
                for index in self.tile.ranges[row * width + column].clone() {
                    for &place in found {
                        self.add(index, &self.drawn[place as usize]);
                    }
                }
            }
        }
    }

    #[inline]
    fn add(&mut self, index: usize, drawn: &Drawn) {
        let (across, depth) = self.places[index];
        self.work.inside.fragments += 1;
        if depth < drawn.depths[0] || depth > drawn.depths[1] {
            return;
        }
        let Some(weights) = drawn.beam.section(depth).weights(across) else {
            return;
        };
        if depth < drawn.beam.ruling(weights).start {
            return;
        }
        let point = &self.tile.points[index];
        self.shading.add(
            &mut self.sums[index],
            drawn.beam,
            (weights, depth),
            point,
            self.work,
        );
    }
}
