//! One randomisation of an image, tile by tile.
//!
//! A tile is the work that one thread does at a time. It keeps its samples' sums for itself, including those
//! in the border that the filter reaches into. Tiles are added to the film in their order. So the order of
//! all additions is fixed, and with it every bit, on any number of threads.

use std::time::{Duration, Instant};

use glam::DVec2;
use rayon::prelude::*;

use super::bands::{Bands, TILE};
use super::settings::PathSettings;
use super::tracer::{PathNumbers, RadianceByClass, Tracer};
use crate::film::splat::{Footprint, Splatter};
use crate::geometry::TraversalCounters;
use crate::numeric::{PaddedStream, Stream};
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::camera::{Camera, PixelRay};
use crate::transport::lights::Lights;
use crate::transport::path_class::PathClass;

/// Paths followed together. Of fewer than a hundred too few would soon be left to search for by turns.
const WAVE: usize = 512;

/// Tiles between two additions to the film. Their sums are kept until then, about 50 kB each.
const BATCH: usize = 1024;

/// Pixels whose sums are kept in tiles, beside the film's.
pub const KEPT_PIXELS: usize = BATCH * TILE * TILE;

/// One randomisation of a camera's image.
pub struct Job<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The emitters.
    pub lights: &'a Lights<'a>,
    /// For each shape, true if it shines.
    pub shines: &'a [bool],
    /// The camera.
    pub camera: &'a Camera,
    /// The rows that are wanted: those of others are not whole.
    pub bands: Bands,
    /// Settings of the paths.
    pub settings: &'a PathSettings,
    /// The randomisation's own stream.
    pub stream: Stream,
    /// Samples a pixel.
    pub samples: u64,
    /// Tells when to give up.
    pub stop: &'a (dyn Fn() -> bool + Sync),
    /// Receives the number of paths that each finished tile started.
    pub finished: &'a (dyn Fn(u64) + Sync),
}

/// Sums over the samples of one randomisation.
#[derive(Clone, Debug)]
pub struct ImageSums {
    /// Σ f by pixel, f a sample's filter weight there.
    pub weights: Vec<f64>,
    /// Σ f L by pixel, for each class in the order of [`PathClass::ALL`]; empty if all samples are black.
    pub radiance: [Vec<Rgb>; PathClass::ALL.len()],
    /// The work.
    pub counters: TraversalCounters,
    /// Number of paths ended because they met too many surfaces.
    pub cut_off: u64,
    /// Number of samples that are not finite, and the film point of the first of them.
    pub not_finite: Option<(u64, DVec2)>,
}

/// A rectangle of the film, and the sums there.
struct Block {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
    sums: ImageSums,
}

/// A rectangle of pixels to sample, counted from the top left one. If a border is sampled, too, the film
/// begins behind it.
#[derive(Clone, Copy)]
struct Tile {
    left: usize,
    top: usize,
    right: usize,
    bottom: usize,
}

/// A sample of a pixel.
struct Sample<'a> {
    /// Its point of the film.
    at: DVec2,
    view: PixelRay,
    numbers: PathNumbers<'a>,
    /// Its band of rows: paths of one band are followed together, so that searches are the same in all
    /// parts of a run.
    band: usize,
    /// True if it counts here.
    counts: bool,
}

impl ImageSums {
    fn new(pixels: usize) -> Self {
        Self {
            weights: vec![0.0; pixels],
            radiance: std::array::from_fn(|_| Vec::new()),
            counters: TraversalCounters::default(),
            cut_off: 0,
            not_finite: None,
        }
    }

    /// Adds `radiance` times `weight` to a pixel.
    #[inline]
    fn add(&mut self, pixel: usize, radiance: &RadianceByClass, weight: f64) {
        self.weights[pixel] += weight;
        for (sums, value) in self.radiance.iter_mut().zip(radiance) {
            if !value.is_black() {
                if sums.is_empty() {
                    sums.resize(self.weights.len(), Rgb::BLACK);
                }
                sums[pixel] += *value * weight;
            }
        }
    }

    /// The sums of some rows of `width` pixels.
    #[must_use]
    pub fn of_rows(self, bands: Bands, width: usize) -> Self {
        if bands.is_all() {
            return self;
        }
        Self {
            weights: rows_of(&self.weights, bands, width),
            radiance: self.radiance.map(|sums| rows_of(&sums, bands, width)),
            ..self
        }
    }

    fn note_not_finite(&mut self, count: u64, first: DVec2) {
        let (so_far, earlier) = self.not_finite.unwrap_or((0, first));
        self.not_finite = Some((so_far + count, earlier));
    }
}

impl Job<'_> {
    /// Traces all samples that the wanted rows gain from; `None` if `stop` asked for an end before.
    pub fn trace(&self) -> Option<ImageSums> {
        let (width, height) = (self.camera.width(), self.camera.height());
        let mut film = ImageSums::new(width * height);
        for batch in self.tiles().chunks(BATCH) {
            let blocks: Option<Vec<Block>> =
                batch.par_iter().map(|tile| self.trace_tile(tile)).collect();
            for block in blocks? {
                add_block(&mut film, width, &block);
            }
        }
        Some(film)
    }

    /// The time that all tiles take, by a few from all over the film; `None` if it is more than `most`, or if
    /// `stop` asked for an end before. It gives up after twice as long as these few may take.
    pub fn time(&self, most: Duration) -> Option<Duration> {
        /// One tile in so many, but at least one for each thread.
        const ONE_IN: usize = 64;
        let tiles = self.tiles();
        let threads = rayon::current_num_threads();
        let count = (tiles.len() / ONE_IN).max(threads).min(tiles.len());
        let share = count as f64 / tiles.len() as f64;
        let start = Instant::now();
        let stop = || (self.stop)() || start.elapsed() > most.mul_f64(2.0 * share);
        let job = Job {
            stop: &stop,
            ..*self
        };
        // By the golden ratio, so that rows and columns have their part of them.
        let golden = |number: usize| ((number as f64 + 0.5) * 0.618_033_988_749_894_9).fract();
        let traced = (0..count).into_par_iter().map(|number| {
            let tile = (golden(number) * tiles.len() as f64) as usize;
            let start = Instant::now();
            job.trace_tile(&tiles[tile]).map(|_| start.elapsed())
        });
        let busy = traced.collect::<Option<Vec<Duration>>>()?.iter().sum();
        Some(time_of_all(busy, count, tiles.len(), threads)).filter(|time| *time <= most)
    }

    /// Number of paths of the wanted rows.
    pub fn paths(&self) -> u64 {
        let [right, bottom] = self.sampled();
        let rows = (0..bottom).filter(|row| self.counts(*row)).count();
        ((right * rows) as u64).saturating_mul(self.samples)
    }

    /// Columns and rows of pixels to sample, those beyond the film included.
    fn sampled(&self) -> [usize; 2] {
        let border = 2 * self.camera.sampled_border();
        [self.camera.width() + border, self.camera.height() + border]
    }

    /// True if the wanted rows gain from samples of this row.
    fn is_sampled(&self, row: usize) -> bool {
        let (reach, border) = (self.camera.filter().border(), self.camera.sampled_border());
        self.bands.is_near(row, border, reach)
    }

    /// True if samples of this row count as work: others do for another part of the run.
    fn counts(&self, row: usize) -> bool {
        self.bands.counts(row, self.camera.sampled_border())
    }

    /// All pixels to sample, row by row of tiles.
    fn tiles(&self) -> Vec<Tile> {
        let [right, bottom] = self.sampled();
        let mut tiles = Vec::new();
        for top in (0..bottom).step_by(TILE) {
            if !(top..(top + TILE).min(bottom)).any(|row| self.is_sampled(row)) {
                continue;
            }
            for left in (0..right).step_by(TILE) {
                tiles.push(Tile {
                    left,
                    top,
                    right: (left + TILE).min(right),
                    bottom: (top + TILE).min(bottom),
                });
            }
        }
        tiles
    }

    /// Traces a tile's samples; `None` if `stop` asked for an end before.
    fn trace_tile(&self, tile: &Tile) -> Option<Block> {
        let mut block = self.block(tile);
        let mut tracer = Tracer::new(self.scene, self.lights, self.settings, self.shines);
        let film = (self.camera.width(), self.camera.height());
        let splatter = Splatter::new(self.camera.filter(), film.0, film.1);
        let mut footprint = Footprint::default();
        let streams = self.streams(tile);
        let mut views = self.views(tile, &streams).peekable();
        let (mut wave, mut places, mut found) = (Vec::new(), Vec::new(), Vec::new());
        loop {
            wave.clear();
            places.clear();
            let Some((band, counts)) = views.peek().map(|next| (next.band, next.counts)) else {
                break;
            };
            while wave.len() < WAVE
                && let Some(sample) = views.next_if(|sample| sample.band == band)
            {
                places.push(sample.at);
                wave.push((sample.view, sample.numbers));
            }
            let before = (tracer.counters, tracer.cut_off);
            if (self.stop)() {
                return None;
            }
            if !tracer.trace_all(&wave, &mut found, self.stop) {
                return None;
            }
            for (&at, radiance) in places.iter().zip(&found) {
                if radiance.iter().all(|value| value.is_finite()) {
                    splatter.spread(at, &mut footprint);
                    block.add(&footprint, radiance);
                } else {
                    block.sums.note_not_finite(1, at);
                }
            }
            if !counts {
                (tracer.counters, tracer.cut_off) = before;
            }
        }
        block.sums.counters = tracer.counters;
        block.sums.cut_off = tracer.cut_off;
        let rows = (tile.top..tile.bottom).filter(|row| self.counts(*row));
        let pixels = (tile.right - tile.left) * rows.count();
        (self.finished)(pixels as u64 * self.samples);
        Some(block)
    }

    /// Columns and rows of a tile's pixels to sample, row by row.
    fn pixels(&self, tile: &Tile) -> impl Iterator<Item = (usize, usize)> {
        let rows = (tile.top..tile.bottom).filter(|row| self.is_sampled(*row));
        rows.flat_map(|y| (tile.left..tile.right).map(move |x| (x, y)))
    }

    /// The streams of a tile's pixels.
    fn streams(&self, tile: &Tile) -> Vec<PaddedStream> {
        let of_pixel = |(x, y)| self.stream.split(x as u64).split(y as u64);
        self.pixels(tile)
            .map(|pixel| PaddedStream::new(of_pixel(pixel), self.samples))
            .collect()
    }

    /// The samples of a tile, pixel by pixel.
    fn views<'b>(
        &self,
        tile: &Tile,
        streams: &'b [PaddedStream],
    ) -> impl Iterator<Item = Sample<'b>> {
        let border = self.camera.sampled_border() as f64;
        let pixels = self.pixels(tile).zip(streams);
        pixels.flat_map(move |((x, y), stream)| {
            let band = self.bands.nearest(y, self.camera.sampled_border()) / TILE;
            let counts = self.counts(y);
            (0..self.samples).map(move |index| {
                let numbers = PathNumbers { stream, index };
                let [u, v, s, t] = numbers.camera();
                let at = DVec2::new(within(x, u), within(y, v)) - border;
                let view = self.camera.ray_through(at, DVec2::new(s, t));
                Sample {
                    at,
                    view,
                    numbers,
                    band,
                    counts,
                }
            })
        })
    }

    /// An empty block of all pixels of the film that a tile's samples may reach.
    fn block(&self, tile: &Tile) -> Block {
        let (reach, border) = (self.camera.filter().border(), self.camera.sampled_border());
        let clip = |from: usize, to: usize, size: usize| {
            let first = from.saturating_sub(border + reach).min(size);
            let end = (to + reach).saturating_sub(border).clamp(first, size);
            (first, end - first)
        };
        let (left, width) = clip(tile.left, tile.right, self.camera.width());
        let (top, height) = clip(tile.top, tile.bottom, self.camera.height());
        Block {
            left,
            top,
            width,
            height,
            sums: ImageSums::new(width * height),
        }
    }
}

impl Block {
    #[inline]
    fn add(&mut self, footprint: &Footprint, radiance: &RadianceByClass) {
        let columns = self.left..self.left + self.width;
        let rows = self.top..self.top + self.height;
        for (column, row, weight) in footprint.pixels() {
            // Rounding may put a pixel at the very end of the filter, of weight zero, beyond the block.
            if columns.contains(&column) && rows.contains(&row) {
                let pixel = (row - self.top) * self.width + (column - self.left);
                self.sums.add(pixel, radiance, weight);
            }
        }
    }
}

/// The values of some rows of `width` pixels each; none of none.
fn rows_of<T: Copy>(values: &[T], bands: Bands, width: usize) -> Vec<T> {
    if values.is_empty() {
        return Vec::new();
    }
    let rows = bands.rows();
    rows.flat_map(|row| values[row * width..(row + 1) * width].iter().copied())
        .collect()
}

/// `pixel + offset`. Rounding must not lead to the next pixel.
#[inline]
fn within(pixel: usize, offset: f64) -> f64 {
    (pixel as f64 + offset).min(((pixel + 1) as f64).next_down())
}

/// The time of so many tiles on so many threads, given the threads' time for some of them.
fn time_of_all(busy: Duration, some: usize, all: usize, threads: usize) -> Duration {
    let at_once = threads.min(all) as f64;
    busy.mul_f64(all as f64 / (some as f64 * at_once))
}

/// Adds a block to a film of `width` pixels a row.
fn add_block(film: &mut ImageSums, width: usize, block: &Block) {
    for row in 0..block.height {
        let of_block = row * block.width..(row + 1) * block.width;
        let start = (block.top + row) * width + block.left;
        let of_film = start..start + block.width;
        let weights = &mut film.weights[of_film.clone()];
        for (sum, weight) in weights
            .iter_mut()
            .zip(&block.sums.weights[of_block.clone()])
        {
            *sum += weight;
        }
        for (sums, values) in film.radiance.iter_mut().zip(&block.sums.radiance) {
            if values.is_empty() {
                continue;
            }
            if sums.is_empty() {
                sums.resize(film.weights.len(), Rgb::BLACK);
            }
            for (sum, value) in sums[of_film.clone()]
                .iter_mut()
                .zip(&values[of_block.clone()])
            {
                *sum += *value;
            }
        }
    }
    film.counters += block.sums.counters;
    film.cut_off += block.sums.cut_off;
    if let Some((count, first)) = block.sums.not_finite {
        film.note_not_finite(count, first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_of_all_tiles_is_that_of_some_by_their_number_and_threads() {
        let second = Duration::from_secs(1);
        assert_eq!(time_of_all(second, 1, 10, 1), 10 * second);
        assert_eq!(time_of_all(8 * second, 64, 4096, 2), 256 * second);
        // More threads than tiles: the others have nothing to do.
        assert_eq!(time_of_all(3 * second, 3, 3, 64), second);
    }
}
